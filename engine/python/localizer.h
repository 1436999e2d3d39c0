// handhold.Localizer: a localizer, the memory of its results, and who may use it when.
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "handhold/localizer.h"
#include "results.h"

namespace handhold::python {

class PyLocalizer {
 public:
  explicit PyLocalizer(const Options& options) : localizer_(options) {}

  /// Without the GIL. @throws std::runtime_error while another thread's frame is in progress
  PyResult localize(const pybind11::object& points, const pybind11::object& viewpoint, const pybind11::object& guesses);
  void set_seed(std::uint64_t seed);
  void cancel() noexcept { localizer_.cancel(); }
  std::vector<Sample> samples() const;
  const Options& options() const { return localizer_.options(); }
  Backend backend() const { return localizer_.backend(); }
  const std::string& backend_reason() const { return localizer_.backend_reason(); }

 private:
  class Turn;
  std::shared_ptr<Result> spare_result();

  Localizer localizer_;
  std::vector<float> copied_points_;
  std::vector<std::shared_ptr<Result>> results_;  // the last ones; one that Python let go of is used again
  mutable std::atomic<bool> busy_{false};
  bool failed_ = false;
};

void bind_localizer(pybind11::module_& m);
void bind_tracker(pybind11::module_& m);

}  // namespace handhold::python
