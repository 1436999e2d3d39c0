// The localizer for C: a frame in, copies of the results out.
#include "handhold/localizer.h"

#include <cstdint>
#include <vector>

#include "object.h"
#include "sizes.h"
#include "statuses.h"

using handhold::CloudView;
using handhold::Vector3;
using handhold::c::check;
using handhold::c::fail;
using handhold::c::guarded;
using handhold::c::plausible_size;
using handhold::c::read_struct;
using handhold::c::write_struct;

namespace {

void copy(const Vector3& from, double (&to)[3]) {
  for (std::size_t k = 0; k < 3; ++k) to[k] = from[k];
}

/// Checks what a CloudView cannot express; the rest is checked by the localizer.
CloudView view_of(const handhold_cloud& cloud) {
  if (reinterpret_cast<std::uintptr_t>(cloud.data) % alignof(float) != 0) {
    throw std::invalid_argument("cloud: data is not aligned: its address must be a multiple of 4");
  }
  if (cloud.no_viewpoint > 1) {
    throw std::invalid_argument("cloud: no_viewpoint = " + std::to_string(cloud.no_viewpoint) + ": must be 0 or 1");
  }
  CloudView view;
  view.data = cloud.data;
  view.width = cloud.width;
  view.height = cloud.height;
  if (cloud.point_step != 0) view.point_step = cloud.point_step;
  view.viewpoint.reset();
  if (!cloud.no_viewpoint) view.viewpoint = {cloud.viewpoint[0], cloud.viewpoint[1], cloud.viewpoint[2]};
  return view;
}

handhold_handle to_c(const handhold::Handle& from) {
  handhold_handle to{};
  copy(from.center, to.center), copy(from.axis, to.axis), copy(from.approach, to.approach);
  to.radius = from.radius;
  to.length = from.length;
  to.confidence = from.confidence;
  to.arc = from.arc;
  to.residual = from.residual;
  to.observed_free = from.observed_free;
  to.normal_error = from.normal_error;
  static_assert(sizeof(Vector3) == 3 * sizeof(double), "the points of a path must stand one after the other");
  to.path = from.path.empty() ? nullptr : from.path.front().data();
  to.path_points = static_cast<std::uint32_t>(from.path.size());
  to.affordances = from.affordances.data();
  to.affordance_count = static_cast<std::uint32_t>(from.affordances.size());
  return to;
}

handhold_affordance to_c(const handhold::Affordance& from) {
  handhold_affordance to{};
  copy(from.center, to.center), copy(from.axis, to.axis), copy(from.normal, to.normal);
  to.radius = from.radius;
  to.shell_radius = from.shell_radius;
  to.gap = from.gap;
  to.curvature = from.curvature;
  to.observed_free = from.observed_free;
  to.quality = from.quality;
  to.neighbourhood = from.neighbourhood;
  to.sample = from.sample;
  return to;
}

handhold_funnel to_c(const handhold::Funnel& f) {
  return {f.samples,       f.too_few_points, f.flat,      f.curvature_low,  f.concave,     f.circle_wide,
          f.circle_narrow, f.poor_fit,       f.no_gap,    f.shell_empty,    f.affordances, f.cut,
          f.not_aligned,   f.unconfirmed,    f.too_short, f.low_confidence, f.in_handles};
}

handhold_times to_c(const handhold::StageTimes& t) {
  return {t.index, t.samples, t.neighbours, t.moments, t.fit, t.shell, t.visibility, t.handles, t.total};
}

handhold_frame to_c(const handhold::Result& result) {
  handhold_frame frame{};
  frame.status = handhold::c::status_of(result.status);
  frame.handles = static_cast<std::uint32_t>(result.handles.size());
  frame.affordances = static_cast<std::uint32_t>(result.affordances.size());
  frame.points = result.points;
  frame.finite_points = result.finite_points;
  return frame;
}

/// While it lives no other thread begins to make a result.
class Reading {
 public:
  explicit Reading(const handhold_localizer* localizer) : code_(check(localizer)) {
    if (code_) return;
    int users = localizer->users.load(std::memory_order_relaxed);
    do {
      if (users < 0) {
        code_ = HANDHOLD_BUSY;
        return;
      }
    } while (!localizer->users.compare_exchange_weak(users, users + 1, std::memory_order_acquire));
    localizer_ = localizer;
    if (!localizer->has_result) code_ = HANDHOLD_NO_FRAME;
  }
  ~Reading() {
    if (localizer_) localizer_->users.fetch_sub(1, std::memory_order_release);
  }
  Reading(const Reading&) = delete;
  Reading& operator=(const Reading&) = delete;

  /// Whether there is a result to be read.
  handhold_code code() const { return code_; }

 private:
  handhold_code code_;
  const handhold_localizer* localizer_ = nullptr;
};

/// Copies one part of the result.
template <class To, class From>
handhold_code get(const handhold_localizer* localizer, From handhold::Result::*part, To* to, std::size_t size) {
  const Reading reading(localizer);
  if (reading.code()) return reading.code();
  if (!to) return HANDHOLD_NULL_ARGUMENT;
  if (!plausible_size<To>(size)) return HANDHOLD_BAD_SIZE;
  write_struct(to_c(localizer->result.*part), to, 0, size);
  return HANDHOLD_OK;
}

/// Copies a stretch of one of the result's lists.
template <class To, class From>
handhold_code get(const handhold_localizer* localizer, std::vector<From> handhold::Result::*list, std::size_t first,
                  std::size_t count, To* to, std::size_t size) {
  const Reading reading(localizer);
  if (reading.code()) return reading.code();
  if (!to && count > 0) return HANDHOLD_NULL_ARGUMENT;
  if (!plausible_size<To>(size)) return HANDHOLD_BAD_SIZE;
  const std::vector<From>& values = localizer->result.*list;
  if (first > values.size() || count > values.size() - first) return HANDHOLD_BAD_INDEX;
  for (std::size_t i = 0; i < count; ++i) write_struct(to_c(values[first + i]), to, i, size);
  return HANDHOLD_OK;
}

}  // namespace

handhold_code handhold_localizer_create(handhold_options* options, handhold_localizer** localizer) {
  if (localizer) *localizer = nullptr;
  if (options) {
    if (const handhold_code code = check(options)) return code;
  }
  handhold::c::Message* message = options ? &options->message : nullptr;
  if (!localizer) return fail(message, HANDHOLD_NULL_ARGUMENT);
  return guarded(message, HANDHOLD_FAILED,
                 [&] { *localizer = new handhold_localizer(options ? options->options : handhold::Options()); });
}

void handhold_localizer_destroy(handhold_localizer* localizer) {
  handhold::c::destroy(localizer);
}

const char* handhold_localizer_backend(const handhold_localizer* localizer) {
  const handhold_code code = check(localizer);
  return code ? handhold_code_text(code) : to_string(localizer->localizer.backend()).data();  // a literal
}
const char* handhold_localizer_backend_reason(const handhold_localizer* localizer) {
  const handhold_code code = check(localizer);
  return code ? handhold_code_text(code) : localizer->localizer.backend_reason().c_str();
}

handhold_code handhold_localize(handhold_localizer* localizer, const handhold_cloud* cloud, size_t size) {
  if (const handhold_code code = check(localizer)) return code;
  // Not the message, either: it belongs to the thread that runs.
  int users = 0;
  if (!localizer->users.compare_exchange_strong(users, -1, std::memory_order_acquire)) return HANDHOLD_BUSY;
  localizer->has_result = false;
  handhold_code code = HANDHOLD_OK;
  handhold_cloud known;
  if (!cloud) {
    code = fail(&localizer->message, HANDHOLD_NULL_ARGUMENT);
  } else if (!read_struct(cloud, size, known)) {
    code = fail(&localizer->message, HANDHOLD_BAD_SIZE);
  } else {
    code = guarded(&localizer->message, HANDHOLD_BAD_CLOUD,
                   [&] { localizer->localizer.localize(view_of(known), localizer->result); });
  }
  localizer->has_result = code == HANDHOLD_OK;
  localizer->users.store(0, std::memory_order_release);
  return code;
}

handhold_code handhold_cancel(handhold_localizer* localizer) {
  if (const handhold_code code = check(localizer)) return code;
  localizer->localizer.cancel();
  return HANDHOLD_OK;
}

const char* handhold_localizer_message(const handhold_localizer* localizer) {
  const handhold_code code = check(localizer);
  return code ? handhold_code_text(code) : localizer->message.text;
}

handhold_code handhold_get_frame(const handhold_localizer* localizer, handhold_frame* frame, size_t size) {
  const Reading reading(localizer);
  if (reading.code()) return reading.code();
  if (!frame) return HANDHOLD_NULL_ARGUMENT;
  if (!plausible_size<handhold_frame>(size)) return HANDHOLD_BAD_SIZE;
  write_struct(to_c(localizer->result), frame, 0, size);
  return HANDHOLD_OK;
}
handhold_code handhold_get_funnel(const handhold_localizer* localizer, handhold_funnel* funnel, size_t size) {
  return get(localizer, &handhold::Result::funnel, funnel, size);
}
handhold_code handhold_get_times(const handhold_localizer* localizer, handhold_times* times, size_t size) {
  return get(localizer, &handhold::Result::times_ms, times, size);
}
handhold_code handhold_get_handles(const handhold_localizer* localizer, size_t first, size_t count,
                                   handhold_handle* handles, size_t size) {
  return get(localizer, &handhold::Result::handles, first, count, handles, size);
}
handhold_code handhold_get_affordances(const handhold_localizer* localizer, size_t first, size_t count,
                                       handhold_affordance* affordances, size_t size) {
  return get(localizer, &handhold::Result::affordances, first, count, affordances, size);
}
