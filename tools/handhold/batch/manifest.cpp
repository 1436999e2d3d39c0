#include "manifest.h"

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>

#include "atomic_file.h"
#include "handhold/config.h"
#include "usage_error.h"

namespace handhold::batch {
namespace {

namespace fs = std::filesystem;
constexpr const char* kName = ".handhold-batch.json";

/// What the results depend on beside the clouds: not on the number of threads.
std::string text_of(Options options, Backend backend) {
  options.threads = 0;
  const nlohmann::ordered_json json = {{"schema", "handhold-batch/1"},
                                       {"version", HANDHOLD_VERSION},
                                       {"backend", std::string(to_string(backend))},
                                       {"options", to_toml(options)}};
  return json.dump(1) + "\n";
}

std::string read(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

Manifest::Manifest(const fs::path& out, const Options& options, Backend backend, bool force) {
  std::error_code error;
  fs::create_directories(out, error);
  if (!fs::is_directory(out)) {
    throw std::runtime_error("cannot make the folder '" + out.string() + "'" + (error ? ": " + error.message() : ""));
  }
  const fs::path path = out / kName;
  const std::string text = text_of(options, backend);
  const bool there = fs::exists(path, error);
  if (there && !force && read(path) != text) {
    throw UsageError(
        "'" + out.string() +
        "' has results of other options, of another backend or of another version; give another folder, or "
        "--force to make them again");
  }
  if (!there || force) write_file(path.string(), text);
  since_ = fs::last_write_time(path);
}

bool Manifest::finished(const Work& work) const {
  std::error_code error;
  const fs::file_time_type result = fs::last_write_time(work.result, error);
  if (error || result < since_) return false;
  const fs::file_time_type cloud = fs::last_write_time(work.cloud, error);
  return !error && result >= cloud;
}

}  // namespace handhold::batch
