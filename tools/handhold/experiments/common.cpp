#include "common.h"

#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "atomic_file.h"
#include "png_file.h"
#include "usage_error.h"

namespace handhold::experiments {

namespace fs = std::filesystem;

void add_common_flags(CLI::App& app, CommonArguments& a, const std::string& runs) {
  const char* running = "Running";
  add_text_flag(app, "--runs", a.runs, "N", runs, running);
  add_text_flag(app, "--seed", a.seed, "S", "Of the random numbers [1]", running);
  add_text_flag(app, "--threads", a.threads, "N", "Threads to use; 0: all [0]", running);
  const char* output = "Output";
  add_text_flag(app, "-o,--output", a.folder, "FOLDER", "Gets the figures as .csv and .json and the plot as .png",
                output);
  add_text_flag(app, "--csv", a.csv, "F", "Write the figures as comma-separated values", output);
  add_text_flag(app, "--json", a.json, "F", "Write the figures as JSON; '-' is standard output", output);
  add_text_flag(app, "--plot", a.plot, "F.png", "Write the plot", output);
}

void add_method_flag(CLI::App& app, std::string& target, const std::string& standard) {
  add_text_flag(app, "--method", target, "NAME", "default or paper [" + standard + "]", "What is measured");
}

int threads_of(const CommonArguments& a) {
  return a.threads.empty() ? 0 : static_cast<int>(whole_number("--threads", a.threads, 0, 4096));
}

std::uint64_t seed_of(const CommonArguments& a) {
  // Runs and scenes count on from here.
  return a.seed.empty() ? 1 : whole_number("--seed", a.seed, 0, UINT64_MAX / 2);
}

int runs_of(const CommonArguments& a, int standard) {
  return a.runs.empty() ? standard : static_cast<int>(whole_number("--runs", a.runs, 1, 100'000));
}

Outputs::Outputs(const CommonArguments& a, const std::string& name) : csv_(a.csv), json_(a.json), plot_(a.plot) {
  for (const auto& [flag, path] : {std::pair("--csv", csv_), std::pair("--plot", plot_)}) {
    if (path == "-") throw UsageError(std::string(flag) + ": standard output is for JSON; give a file name");
  }
  if (!a.folder.empty()) {
    std::error_code error;
    fs::create_directories(a.folder, error);
    if (!fs::is_directory(a.folder)) {
      throw std::runtime_error("cannot make the folder '" + a.folder + "'" +
                               (error ? ": " + error.message() : std::string()) + "; give another one");
    }
    const std::string start = (fs::path(a.folder) / name).string();
    if (csv_.empty()) csv_ = start + ".csv";
    if (json_.empty()) json_ = start + ".json";
    if (plot_.empty()) plot_ = start + ".png";
  }
  const std::string* paths[] = {&csv_, &json_, &plot_};
  for (const std::string* path : paths) {
    if (path->empty() || *path == "-") continue;
    for (const std::string* other : paths) {
      if (other != path && *other == *path) throw UsageError("two outputs name '" + *path + "'; give two names");
    }
    AtomicFile::check_writable(*path);
  }
}

void Outputs::write(const Report& report) const {
  if (!csv_.empty()) write_file(csv_, report.csv);
  if (!plot_.empty()) write_png(plot_, draw_plot(report.panels, report.columns));
  const std::string json = report.json.dump(1) + "\n";
  if (json_ == "-") {
    write_and_flush(stdout, json, "standard output");
    write_and_flush(stderr, report.text, "standard error");
    return;
  }
  if (!json_.empty()) write_file(json_, json);
  write_and_flush(stdout, report.text, "standard output");
}

}  // namespace handhold::experiments
