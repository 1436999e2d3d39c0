// handhold batch: the handles of many clouds.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "atomic_file.h"
#include "backend.h"
#include "command_line.h"
#include "interrupt.h"
#include "kernels.h"
#include "manifest.h"
#include "option_arguments.h"
#include "progress.h"
#include "ranks.h"
#include "run.h"
#include "statistics.h"
#include "subcommand.h"
#include "usage_error.h"
#include "work_list.h"

namespace handhold {
namespace {

using batch::Outcome;
using batch::Work;

struct Arguments {
  OptionArguments options;
  std::string source, out, csv, json;
  bool recursive = false, force = false;
};

void add_flags(CLI::App& app, Arguments& a) {
  app.add_option("SOURCE", a.source, "Folder of clouds (.pcd, .ply), or a text file with the path of one a line")
      ->option_text(" ");
  const auto flag = [&app](const char* name, bool& target, const char* help, const char* group) {
    app.add_flag(name, target, help)->disable_flag_override()->group(group);
  };
  const char* input = "Input";
  flag("--recursive", a.recursive, "Also the folders within SOURCE", input);
  add_preset_flags(app, a.options, input);
  const char* output = "Output";
  add_text_flag(app, "-o,--out", a.out, "DIR", "Folder for NAME.json of every cloud, as of 'localize --no-times'",
                output);
  flag("--force", a.force, "Make results again that are there already", output);
  add_text_flag(app, "--csv", a.csv, "F", "Write a line per cloud", output);
  add_text_flag(app, "--json", a.json, "F", "Write the summary as JSON", output);
  add_option_flags(app, a.options.texts);
}

const char* name_of(Outcome::Kind kind) {
  switch (kind) {
    case Outcome::kNotReached:
      return "not_reached";
    case Outcome::kDone:
      return "done";
    case Outcome::kKept:
      return "kept";
    case Outcome::kFailed:
      return "failed";
  }
  return "";
}

struct Summary {
  std::size_t clouds = 0, done = 0, kept = 0, failed = 0, handles = 0, points = 0;
  double seconds = 0, median_ms = 0, p99_ms = 0;

  double per_second() const { return seconds > 0 ? static_cast<double>(done) / seconds : 0; }
};

Summary summarize(const std::vector<Outcome>& outcomes, double seconds) {
  Summary s;
  s.clouds = outcomes.size(), s.seconds = seconds;
  std::vector<double> ms;
  for (const Outcome& o : outcomes) {
    s.done += o.kind == Outcome::kDone, s.kept += o.kind == Outcome::kKept, s.failed += o.kind == Outcome::kFailed;
    if (o.kind != Outcome::kDone) continue;
    s.handles += o.handles, s.points += o.points;
    ms.push_back(o.localize_ms);
  }
  if (ms.empty()) return s;
  s.median_ms = quantile(ms, 0.5), s.p99_ms = quantile(ms, 0.99);
  return s;
}

std::string table_of(const Summary& s) {
  char text[512];
  std::snprintf(text, sizeof text,
                "clouds      done      kept    failed   handles      points   time s  clouds/s  median ms    p99 ms\n"
                "%6zu %9zu %9zu %9zu %9zu %11zu %8.1f %9.1f %10.1f %9.1f\n",
                s.clouds, s.done, s.kept, s.failed, s.handles, s.points, s.seconds, s.per_second(), s.median_ms,
                s.p99_ms);
  return text;
}

/// A text in quotes, as CSV wants it.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + '"';
}

void write_csv(const std::string& path, const std::vector<Work>& work, const std::vector<Outcome>& outcomes) {
  std::string text = "name,outcome,points,affordances,handles,read_ms,localize_ms,problem\n";
  for (std::size_t i = 0; i < work.size(); ++i) {
    const Outcome& o = outcomes[i];
    char numbers[160];
    std::snprintf(numbers, sizeof numbers, ",%s,%zu,%zu,%zu,%.3f,%.3f,", name_of(o.kind), o.points, o.affordances,
                  o.handles, o.read_ms, o.localize_ms);
    text += quoted(work[i].name) + numbers + (o.problem.empty() ? "" : quoted(o.problem)) + "\n";
  }
  write_file(path, text);
}

void write_json(const std::string& path, const Summary& s, const std::vector<Work>& work,
                const std::vector<Outcome>& outcomes) {
  nlohmann::ordered_json json = {
      {"clouds", s.clouds},       {"done", s.done},     {"kept", s.kept},       {"failed", s.failed},
      {"handles", s.handles},     {"points", s.points}, {"seconds", s.seconds}, {"per_second", s.per_second()},
      {"median_ms", s.median_ms}, {"p99_ms", s.p99_ms}};
  json["problems"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < work.size(); ++i) {
    if (outcomes[i].kind != Outcome::kFailed) continue;
    json["problems"].push_back({{"name", work[i].name}, {"problem", outcomes[i].problem}});
  }
  write_file(path, json.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

/// What this process has done, for the one that writes the summary.
std::string report_of(const std::vector<Outcome>& outcomes, const std::string& failure) {
  nlohmann::json json = {
      {"failure", failure}, {"interrupted", interrupted.load()}, {"outcomes", nlohmann::json::array()}};
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    const Outcome& o = outcomes[i];
    if (o.kind == Outcome::kNotReached) continue;
    json["outcomes"].push_back(
        {i, static_cast<int>(o.kind), o.problem, o.points, o.handles, o.affordances, o.read_ms, o.localize_ms});
  }
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// Adds what another process has done. Its failure, or nothing.
std::string add_report(const std::string& text, std::vector<Outcome>& outcomes) {
  const nlohmann::json json = nlohmann::json::parse(text);
  for (const auto& o : json["outcomes"]) {
    outcomes.at(o[0].get<std::size_t>()) = {
        static_cast<Outcome::Kind>(o[1].get<int>()), o[2], o[3], o[4], o[5], o[6], o[7]};
  }
  if (json["interrupted"]) interrupted = true;
  return json["failure"];
}

/// The reports of all ranks at the first one, which says whom it waits for.
std::vector<std::string> gather(batch::Ranks& ranks, const std::string& report) {
  Progress progress;
  bool said = false;
  return ranks.gather(report, [&](std::size_t missing) {
    progress.show("waiting for " + batch::name_of_rank(missing));
    if (!interrupted || said) return;
    // Perhaps the last that is heard: a launcher that has lost a rank interrupts the others, and kills them soon.
    said = true;
    progress.show("");
    std::fprintf(stderr,
                 "handhold: interrupted: no report of %s yet; results are kept, the same command goes on from there\n",
                 batch::name_of_rank(missing).c_str());
  });
}

/// The batch, or this process's share of it. `outcomes`: of each cloud of the work.
void work_through(const std::vector<Work>& work, const Options& options, const batch::Manifest& manifest,
                  batch::Ranks* ranks, std::vector<Outcome>& outcomes) {
  Progress progress;
  std::size_t next = 0, ended = 0;
  batch::run(
      work, options, options.threads, interrupted, [&] { return ranks ? ranks->draw() : next++; },
      [&](std::size_t i) { return manifest.finished(work[i]); },
      [&](std::size_t i, const Outcome& outcome) {
        outcomes[i] = outcome;
        if (outcome.kind == Outcome::kFailed) {
          progress.show("");
          std::fprintf(stderr, "handhold: %s\n", outcome.problem.c_str());
        }
        // Of several ranks the first one shows how far all are: numbers are drawn in order.
        ended = ranks ? i + 1 : ended + 1;
        if (ranks && ranks->rank() != 0) return;
        constexpr std::size_t kBar = 30;
        const std::size_t filled = kBar * ended / work.size();
        progress.show('[' + std::string(filled, '#') + std::string(kBar - filled, '.') + "] " + std::to_string(ended) +
                      " of " + std::to_string(work.size()) + " clouds");
      });
}

int run(const Arguments& a) {
  const std::unique_ptr<batch::Ranks> ranks = batch::Ranks::join();
  Options options;
  std::vector<Work> work;
  std::unique_ptr<batch::Manifest> manifest;
  const auto prepare = [&] {
    if (a.source.empty()) {
      throw UsageError("no clouds given; for example 'handhold batch clouds/ -o results/', or a file with a list");
    }
    if (a.out.empty()) throw UsageError("no folder for the results given; add -o DIR");
    options = effective_options(a.options);
    if (const char* problem = kernels::isa_error()) throw UsageError(problem);
    // Each thread makes one of its own; this one says what is wrong with them all.
    const Localizer localizer = make_localizer(a.options, options);
    work = batch::list_work(list_clouds(a.source, a.recursive), a.out);
    const bool first = !ranks || ranks->rank() == 0;
    for (const std::string& path : {a.csv, a.json}) {
      if (first && !path.empty()) AtomicFile::check_writable(path);
    }
    manifest = std::make_unique<batch::Manifest>(a.out, options, localizer.backend(), a.force && first);
    if (first) {
      batch::remove_leftovers(work);
      note_backend(localizer);
    }
  };
  // One process says what is wrong.
  if (!ranks) {
    prepare();
  } else if (!ranks->first_then_others(prepare)) {
    return 0;  // its code is the job's
  }

  const Interrupt interrupt;
  std::vector<Outcome> outcomes(work.size());
  const auto start = std::chrono::steady_clock::now();
  std::string failure;
  try {
    work_through(work, options, *manifest, ranks.get(), outcomes);
  } catch (const std::exception& error) {
    failure = error.what();
  }
  if (ranks) {
    const std::vector<std::string> reports = gather(*ranks, report_of(outcomes, failure));
    if (ranks->rank() != 0) return 0;
    failure.clear();
    for (std::size_t rank = 0; rank < reports.size(); ++rank) {
      const std::string theirs = add_report(reports[rank], outcomes);
      if (failure.empty() && !theirs.empty()) failure = batch::name_of_rank(rank) + ": " + theirs;
    }
  }
  const Summary summary =
      summarize(outcomes, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  write_and_flush(stdout, table_of(summary), "standard output");
  if (!a.csv.empty()) write_csv(a.csv, work, outcomes);
  if (!a.json.empty()) write_json(a.json, summary, work, outcomes);
  if (!failure.empty()) throw std::runtime_error(failure);
  if (interrupted && summary.done + summary.kept + summary.failed < work.size()) {
    std::fprintf(stderr, "handhold: interrupted: %zu of %zu clouds are done; the same command goes on from here\n",
                 summary.done + summary.kept, work.size());
    return 130;
  }
  if (summary.failed == 0) return 0;
  std::fprintf(stderr, "handhold: error: %zu of %zu clouds could not be searched; see above\n", summary.failed,
               work.size());
  return 1;
}

}  // namespace

Subcommand add_batch(CLI::App& parent) {
  CLI::App* app = parent.add_subcommand("batch", "Find the handles in many clouds, several at a time");
  app->allow_extras();
  auto arguments = std::make_shared<Arguments>();
  add_flags(*app, *arguments);
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace handhold
