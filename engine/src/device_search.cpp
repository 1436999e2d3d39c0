#include "device_search.h"

#include <algorithm>

#include "device.h"
#include "handhold/device.h"
#include "handles.h"
#include "random.h"
#include "sampler.h"
#include "search.h"
#include "tiles.h"

namespace handhold {

std::string why_not_on_device(const Options& options) {
  const CudaDevice device = cuda_device();
  if (!device.available) return device.reason;
  if (options.method != Method::kPaper) return "only the paper's method runs there, not method = default";
  if (options.axis != AxisEstimator::kTaubin) {
    return "only axes from the fitted quadric are found there, not axis = " + std::string(to_string(options.axis));
  }
  return {};
}

DeviceSearch::DeviceSearch(const Options& options, std::unique_ptr<DeviceFrame> frame)
    : options_(&options), frame_(std::move(frame)) {
  const Scale scale = scales_of(options).front();
  query_.shell = shell_limits(options);
  radius_ = scale.radius;
  query_.radius = static_cast<float>(scale.radius);
  query_.flat_rms = scale.flat_rms, query_.flat_slope = scale.flat_slope;
  query_.min_points = options.min_neighbours;
  query_.align = align_limits(options);
  query_.sigma = options.effective_proposal_sigma();
  query_.snap_radius = static_cast<float>(scale.radius);
  query_.only_nearest = options.strategy == Strategy::kMax;
}

void DeviceSearch::take(const CloudView& cloud) {
  times_ = {};
  cloud_ = cloud;
  // Only what is not organized is put in order by them.
  if (!is_image(cloud)) bounds_.find(cloud);
  query_.fit = fit_limits(*options_, radius_, false, cloud.viewpoint);
  frame_->take(cloud, bounds_);
}

std::uint32_t DeviceSearch::draw(const std::vector<int>& rounds, Step* steps, std::vector<Affordance>& found) {
  rounds_.clear();
  std::uint32_t n = 0;
  for (std::size_t i = 0; i < rounds.size(); ++i) {
    kernels::FrameQuery& q = rounds_.emplace_back(query_);
    const int round = static_cast<int>(i);
    q.first = n, q.samples = static_cast<std::uint32_t>(rounds[i]);
    n += q.samples;
    q.seed = options_->seed, q.stream = Sampler::uniform_stream(round);
    q.proposals = CounterRandom::stream_state(options_->seed, Sampler::proposal_stream(round));
  }
  frame_->draw(rounds_.data(), static_cast<std::uint32_t>(rounds_.size()));
  if (is_image(cloud_)) bounds_.find(cloud_);  // while the device is busy
  return collect(n, 0, steps, found);
}

void DeviceSearch::run(const float* xyz, std::uint32_t n, std::uint32_t first, Step* steps,
                       std::vector<Affordance>& found) {
  query_.first = 0, query_.samples = n;
  frame_->look(query_, xyz);
  collect(n, first, steps, found);
}

std::uint32_t DeviceSearch::collect(std::uint32_t n, std::uint32_t first, Step* steps, std::vector<Affordance>& found) {
  const DeviceFrame::Found f = frame_->wait();
  frame_->add_times(times_);
  for (std::uint32_t i = 0; i < n; ++i) steps[i] = static_cast<Step>(f.end[i]);
  // In the order of their samples.
  order_.resize(f.shells);
  for (std::uint32_t i = 0; i < f.shells; ++i) order_[i] = i;
  std::sort(order_.begin(), order_.end(),
            [&](std::uint32_t a, std::uint32_t b) { return f.shell[a].sample < f.shell[b].sample; });
  aligned_.clear();
  for (const std::uint32_t i : order_) {
    const kernels::FoundShell& s = f.shell[i];
    Affordance& a = found.emplace_back();
    std::copy_n(s.place.center, 3, a.center.data()), std::copy_n(s.place.axis, 3, a.axis.data());
    std::copy_n(s.place.normal, 3, a.normal.data());
    a.radius = s.radius;
    a.neighbourhood = query_.fit.radius;
    a.curvature = s.curvature;
    a.shell_radius = static_cast<double>(s.shell_radius);
    a.gap = static_cast<double>(s.free_to) - static_cast<double>(s.shell_radius);
    a.sample = first + s.sample;
    aligned_.push_back(s.aligned);
  }
  return f.finite;
}

void DeviceSearch::add_times(StageTimes& times) const {
  times.index += times_.index, times.samples += times_.samples, times.moments += times_.moments;
  times.fit += times_.fit, times.shell += times_.shell, times.handles += times_.handles;
}

}  // namespace handhold
