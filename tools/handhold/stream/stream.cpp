// handhold stream: frame after frame, with a tracker.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "atomic_file.h"
#include "backend.h"
#include "camera_arguments.h"
#include "command_line.h"
#include "frame_queue.h"
#include "frame_source.h"
#include "handhold/localizer.h"
#include "handhold/tracker.h"
#include "interrupt.h"
#include "kernels.h"
#include "option_arguments.h"
#include "progress.h"
#include "result_json.h"
#include "statistics.h"
#include "subcommand.h"
#include "threads.h"
#include "usage_error.h"

namespace handhold {
namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;
using stream::Frame;
using stream::FrameQueue;
using stream::FrameSource;

/// Frames that are read ahead, or wait to be searched.
constexpr std::size_t kWaiting = 2;
/// The live line's percentiles are of so many frames.
constexpr std::size_t kRecent = 200;

struct Arguments {
  OptionArguments options;
  CameraArguments camera;
  std::string source, rate, json;
  bool no_track = false, no_times = false;
};

void add_flags(CLI::App& app, Arguments& a) {
  app.add_option(
         "SOURCE", a.source,
         "Folder of clouds (.pcd, .ply) or of depth images (16-bit gray PNG, with --fx to --depth-unit-m) in order "
         "of their names, a text file with a list of them, an OpenNI2 recording (.oni), 'openni2:' for the first "
         "OpenNI2 device, or 'openni2:URI'")
      ->option_text(" ");
  const auto flag = [&app](const char* name, bool& target, const char* help, const char* group) {
    app.add_flag(name, target, help)->disable_flag_override()->group(group);
  };
  const char* input = "Input";
  add_text_flag(app, "--rate-hz", a.rate, "R",
                "Frames come at this rate (Hz), and the oldest are dropped that cannot be searched in time; without it "
                "every frame is searched, as fast as possible. A device has its own rate",
                input);
  add_camera_flags(app, a.camera, input);
  flag("--no-track", a.no_track, "Search each frame for itself, without a tracker", input);
  add_preset_flags(app, a.options, input);
  const char* output = "Output";
  add_text_flag(app, "--json", a.json, "F", "Write a line of JSON for each frame; '-' is standard output", output);
  flag("--no-times", a.no_times, "Leave out what differs from run to run", output);
  add_option_flags(app, a.options.texts);
}

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Until frame i of `rate_hz` frames a second is due, or the user interrupts.
void wait_until_due(std::size_t i, double rate_hz, Clock::time_point start) {
  const auto due = start + std::chrono::duration_cast<Clock::duration>(
                               std::chrono::duration<double>(static_cast<double>(i) / rate_hz));
  while (Clock::now() < due && !interrupted) {
    std::this_thread::sleep_for(std::min<Clock::duration>(due - Clock::now(), std::chrono::milliseconds(50)));
  }
}

/// The thread that reads: one frame after the other goes into the queue, each when it is due.
class Reader {
 public:
  Reader(FrameSource& source, double rate_hz, Clock::time_point start, FrameQueue& queue)
      : queue_(queue), thread_([this, &source, rate_hz, start] { read_all(source, rate_hz, start); }) {}
  /// Whatever happens, it is waited for.
  ~Reader() { finish(); }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  void finish() {
    queue_.close();
    if (thread_.joinable()) thread_.join();
  }
  /// Frames that came; only after finish(), as the next one.
  std::size_t frames() const { return frames_; }
  /// Throws on what ended the source before its time.
  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  void read_all(FrameSource& source, double rate_hz, Clock::time_point start) {
    try {
      while (std::optional<Frame> frame = interrupted ? std::nullopt : source.next()) {
        if (rate_hz > 0) wait_until_due(frames_, rate_hz, start);
        frame->number = frames_++;
        frame->time_s = seconds_since(start);
        if (!queue_.push(std::move(*frame))) return;
      }
    } catch (...) {
      failure_ = std::current_exception();
    }
    queue_.close();
  }

  FrameQueue& queue_;
  std::size_t frames_ = 0;
  std::exception_ptr failure_;
  std::thread thread_;  ///< last: it uses the others
};

Json track_json(const Track& track) {
  Json json = {{"id", track.id}};
  const Json handle = handle_json(track.handle);
  for (const auto& [key, value] : handle.items()) {
    if (key != "affordances") json[key] = value;
  }
  json["velocity"] = track.velocity;
  json["age"] = track.age;
  json["unseen"] = track.unseen;
  return json;
}

/// What goes where.
class Lines {
 public:
  explicit Lines(const std::string& path) {
    if (path == "-") to_standard_output_ = true;
    if (!path.empty() && path != "-") file_ = std::make_unique<AtomicFile>(path);
  }
  bool wanted() const { return to_standard_output_ || file_; }
  void write(const Json& json) {
    const std::string line = json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
    if (to_standard_output_) write_and_flush(stdout, line, "standard output");
    if (file_) file_->write(line);
  }
  void commit() {
    if (file_) file_->commit();
  }
  std::FILE* for_people() const { return to_standard_output_ ? stderr : stdout; }

 private:
  bool to_standard_output_ = false;
  std::unique_ptr<AtomicFile> file_;
};

int run(const Arguments& a) {
  if (a.source.empty()) throw UsageError("no source given; for example 'handhold stream frames/'");
  const Options options = effective_options(a.options);
  if (const char* problem = kernels::isa_error()) throw UsageError(problem);
  const double rate = a.rate.empty() ? 0 : numbers("--rate-hz", a.rate, 1e-3, 1e4, "Hz").front();
  const std::unique_ptr<FrameSource> source = stream::open_source(a.source, a.camera, rate > 0);
  const auto more_threads = allow_threads(options.threads);
  Localizer localizer = make_localizer(a.options, options);
  Lines lines(a.json);
  note_backend(localizer);

  const Interrupt interrupt;
  Tracker tracker;
  Result result;
  std::vector<Vector3> guesses;
  std::vector<double> ms;
  std::size_t bad = 0, handles = 0;
  FrameQueue queue(kWaiting, rate > 0 || source->live());
  const auto start = Clock::now();
  Reader reader(*source, rate, start, queue);
  {
    Progress progress;
    std::vector<double> recent;
    while (std::optional<Frame> frame = interrupted ? std::nullopt : queue.pop()) {
      Json json = {{"frame", frame->number}, {"source", frame->source}};
      if (!a.no_times) json["time_s"] = frame->time_s;
      if (!frame->problem.empty()) {
        ++bad;
        progress.show("");
        std::fprintf(stderr, "handhold: %s\n", frame->problem.c_str());
        json["status"] = "unreadable";
        json["problem"] = frame->problem;
        lines.write(json);
        continue;
      }
      // Other random numbers in each frame: what one overlooks another one finds.
      localizer.set_seed(options.seed + frame->number);
      const auto before = Clock::now();
      if (!a.no_track) tracker.guesses(guesses);
      localizer.localize(frame->cloud.view(), result, guesses);
      if (!a.no_track) tracker.update(result.handles);
      ms.push_back(1e3 * std::chrono::duration<double>(Clock::now() - before).count());
      handles += result.handles.size();
      if (lines.wanted()) {
        json["status"] = std::string(to_string(result.status));
        json["backend"] = std::string(to_string(localizer.backend()));
        if (!a.no_times) {
          json["search_ms"] = ms.back();
          json["latency_ms"] = 1e3 * (seconds_since(start) - frame->time_s);
          json["dropped"] = queue.dropped();
        }
        json["handles"] = Json::array();
        for (const Handle& handle : result.handles) {
          json["handles"].push_back(handle_json(handle));
          json["handles"].back().erase("affordances");
        }
        if (!a.no_track) {
          json["tracks"] = Json::array();
          for (const Track& track : tracker.tracks()) json["tracks"].push_back(track_json(track));
        }
        lines.write(json);
      }
      recent.assign(ms.end() - static_cast<std::ptrdiff_t>(std::min(kRecent, ms.size())), ms.end());
      char text[160];
      std::snprintf(text, sizeof text,
                    "frame %zu: %.1f frames/s, search p50 %.1f ms, p99 %.1f ms, %zu handles, %zu dropped",
                    frame->number, static_cast<double>(ms.size()) / std::max(1e-9, seconds_since(start)),
                    quantile(recent, 0.5), quantile(recent, 0.99), result.handles.size(), queue.dropped());
      progress.show(text);
    }
  }
  reader.finish();
  lines.commit();
  const double seconds = seconds_since(start);
  char text[320];
  std::snprintf(
      text, sizeof text,
      "%zu frames of %zu searched in %.2f s (%.1f frames/s); search p50 %.1f ms, p99 %.1f ms; %zu dropped, %zu "
      "unreadable; %zu handles\n",
      ms.size(), source->size().value_or(reader.frames()), seconds,
      static_cast<double>(ms.size()) / std::max(1e-9, seconds), ms.empty() ? 0.0 : quantile(ms, 0.5),
      ms.empty() ? 0.0 : quantile(ms, 0.99), queue.dropped(), bad, handles);
  write_and_flush(lines.for_people(), text, "standard output");
  if (interrupted) return 130;
  reader.rethrow();
  return bad ? 1 : 0;
}

}  // namespace

Subcommand add_stream(CLI::App& parent) {
  CLI::App* app = parent.add_subcommand("stream", "Find and track the handles in frame after frame");
  app->allow_extras();
  auto arguments = std::make_shared<Arguments>();
  add_flags(*app, *arguments);
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace handhold
