// What programs that time whole frames ask for.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <string>

#include "handhold/localizer.h"

namespace handhold::bench {

struct FrameArguments {
  std::string cloud, csv, plot;
  Options options;
  int frames = 0;  ///< timed ones
};

/// Parses the command line - cloud, --FLAG frames, samples, threads, method, backend, CSV and plot, and what `app` has
/// already - and runs. Returns the program's exit code: any exception is one line on standard error.
template <class Run>
int main_of(CLI::App& app, int argc, char** argv, const char* frames_flag, FrameArguments& a, Run run) {
  std::string method = "default", backend = "cpu";
  a.options.threads = 1;
  app.add_option("cloud", a.cloud, "PCD or PLY file; default: data/table_scene.pcd, or a synthetic frame");
  app.add_option(frames_flag, a.frames, "timed frames (of each case)")
      ->check(CLI::Range(1, 100000000))
      ->capture_default_str();
  app.add_option("--samples", a.options.samples, "neighbourhoods")
      ->check(CLI::Range(1, 10000000))
      ->capture_default_str();
  app.add_option("--threads", a.options.threads, "threads")->check(CLI::Range(1, 1024))->capture_default_str();
  app.add_option("--method", method, "'default' or 'paper'")->check(CLI::IsMember({"default", "paper"}));
  app.add_option("--backend", backend, "'cpu', 'cuda' or 'auto'")->check(CLI::IsMember({"cpu", "cuda", "auto"}));
  app.add_option("--csv", a.csv, "Write the times");
  app.add_option("--plot", a.plot, "Write a figure, PNG");
  CLI11_PARSE(app, argc, argv);
  try {
    from_string(method, a.options.method);
    from_string(backend, a.options.backend);
    run();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", argv[0], error.what());
    return 1;
  }
  return 0;
}

}  // namespace handhold::bench
