// The cloud or depth image that a command line names.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "camera_arguments.h"
#include "handhold/cloud.h"

namespace handhold {

/// What the user gave; empty: not given.
struct CloudArguments {
  CameraArguments camera;
  std::string cloud, depth, viewpoint;
};

/// Adds CLOUD, --depth with its camera, and --viewpoint; what the user gives ends in `a`, which must outlive the
/// parsing.
void add_cloud_flags(CLI::App& app, CloudArguments& a, const std::string& group);

/// Reads what the arguments name; wrong combinations are refused before.
class CloudInput {
 public:
  /// @param subcommand  for the example in a message: "localize" @throws UsageError
  CloudInput(const CloudArguments& a, const std::string& subcommand);

  const std::string& path() const { return path_; }
  /// Of the file, without its folder.
  std::string name() const;
  /// @throws std::runtime_error with one line: the file, what is wrong, what would be right
  Cloud read() const;

 private:
  std::string path_;
  bool is_depth_;
  DepthCamera camera_;
  std::optional<std::optional<Vector3>> viewpoint_;  ///< none: the cloud's own
};

/// Files to write; empty: not asked for.
struct ResultPaths {
  std::string json, picture, html;
};
/// Refuses values of --json, --picture and --html that cannot work, before anything is computed.
/// @throws UsageError, std::runtime_error naming the flag or the path
void check_result_paths(const ResultPaths& paths, const std::string& input);

}  // namespace handhold
