#include "run.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <chrono>
#include <exception>
#include <filesystem>
#include <memory>
#include <mutex>
#include <stdexcept>

#include "atomic_file.h"
#include "handhold/io.h"
#include "handhold/localizer.h"
#include "result_json.h"
#include "threads.h"
#include "why_failed.h"

namespace handhold::batch {
namespace {

using Clock = std::chrono::steady_clock;
double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// A cloud on its way through the pipeline.
struct Token {
  std::size_t index = 0;
  Outcome outcome;
  Cloud cloud;
  std::string json;
};
using TokenPointer = std::shared_ptr<Token>;

/// Clouds in memory beside those that are searched: read before a thread is free, or not yet written.
constexpr int kWaiting = 2;

}  // namespace

void run(const std::vector<Work>& work, const Options& options, int threads, const std::atomic<bool>& stop,
         const std::function<std::size_t()>& draw, const std::function<bool(std::size_t)>& skip,
         const std::function<void(std::size_t, const Outcome&)>& ended) {
  // A cloud's threads are the others' time: with one each nothing waits.
  Options own = options;
  own.threads = 1;
  tbb::enumerable_thread_specific<std::unique_ptr<Localizer>> localizers;
  std::atomic<bool> cannot_write{false};
  std::mutex mutex;
  std::string why_not_written;

  const auto give = [&](tbb::flow_control& flow) -> TokenPointer {
    const std::size_t index = stop || cannot_write ? work.size() : draw();
    if (index >= work.size()) {
      flow.stop();
      return nullptr;
    }
    auto token = std::make_shared<Token>();
    token->index = index;
    if (skip(token->index)) token->outcome.kind = Outcome::kKept;
    return token;
  };
  const auto fail = [](Token& token, const std::string& problem) {
    token.outcome.kind = Outcome::kFailed;
    token.outcome.problem = problem;
    token.cloud = {};
  };
  const auto read = [&](TokenPointer token) {
    if (token->outcome.kind != Outcome::kNotReached) return token;
    const auto start = Clock::now();
    try {
      token->cloud = read_cloud(work[token->index].cloud.string());
      token->outcome.points = token->cloud.view().size();
    } catch (const std::exception& error) {
      fail(*token, error.what());
    }
    token->outcome.read_ms = milliseconds_since(start);
    return token;
  };
  const auto localize = [&](TokenPointer token) {
    if (token->outcome.kind != Outcome::kNotReached) return token;
    const auto start = Clock::now();
    try {
      std::unique_ptr<Localizer>& localizer = localizers.local();
      if (!localizer) localizer = std::make_unique<Localizer>(own);
      const Result result = localizer->localize(token->cloud.view());
      const std::string problem = why_failed(work[token->index].cloud.string(), token->cloud.view(), options, result);
      token->outcome.localize_ms = milliseconds_since(start);
      if (!problem.empty()) {
        fail(*token, problem);
        return token;
      }
      token->outcome.handles = result.handles.size(), token->outcome.affordances = result.affordances.size();
      token->json = to_json(token->cloud.view(), options, localizer->backend(), result, nullptr);
    } catch (const std::exception& error) {
      fail(*token, "'" + work[token->index].cloud.string() + "': " + error.what());
    }
    token->cloud = {};
    return token;
  };
  const auto write = [&](TokenPointer token) {
    if (token->outcome.kind != Outcome::kNotReached) return token;
    try {
      std::filesystem::create_directories(work[token->index].result.parent_path());
      write_file(work[token->index].result.string(), token->json);
      token->outcome.kind = Outcome::kDone;
    } catch (const std::exception& error) {
      // No other one could be written either.
      const std::lock_guard<std::mutex> lock(mutex);
      if (why_not_written.empty()) why_not_written = error.what();
      cannot_write = true;
    }
    token->json.clear();
    return token;
  };
  const auto end = [&](const TokenPointer& token) {
    if (token->outcome.kind != Outcome::kNotReached) ended(token->index, token->outcome);
  };

  with_threads(threads, [&] {
    using tbb::filter_mode;
    const auto tokens = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency() + kWaiting);
    tbb::parallel_pipeline(tokens, tbb::make_filter<void, TokenPointer>(filter_mode::serial_in_order, give) &
                                       tbb::make_filter<TokenPointer, TokenPointer>(filter_mode::parallel, read) &
                                       tbb::make_filter<TokenPointer, TokenPointer>(filter_mode::parallel, localize) &
                                       tbb::make_filter<TokenPointer, TokenPointer>(filter_mode::parallel, write) &
                                       tbb::make_filter<TokenPointer, void>(filter_mode::serial_in_order, end));
  });
  if (cannot_write) throw std::runtime_error(why_not_written);
}

}  // namespace handhold::batch
