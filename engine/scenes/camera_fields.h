// The fields of CameraOptions by name, for files.
#pragma once

#include "handhold/sensor.h"

namespace handhold::sensor {

/// Calls visit(name, field) for every field of the camera itself.
template <class Options, class Visitor>
void visit_camera(Options& o, const Visitor& visit) {
  visit("width", o.width);
  visit("height", o.height);
  visit("fx", o.fx);
  visit("fy", o.fy);
  visit("cx", o.cx);
  visit("cy", o.cy);
  visit("min_range", o.min_range);
  visit("max_range", o.max_range);
  visit("seed", o.seed);
}

/// Calls visit(name, field) for every field of NoiseOptions.
template <class Options, class Visitor>
void visit_noise(Options& o, const Visitor& visit) {
  visit("axial_sigma", o.axial_sigma);
  visit("axial_growth", o.axial_growth);
  visit("axial_from", o.axial_from);
  visit("axial_slant", o.axial_slant);
  visit("lateral_sigma", o.lateral_sigma);
  visit("lateral_slant", o.lateral_slant);
  visit("correlation_u", o.correlation_u);
  visit("correlation_v", o.correlation_v);
  visit("disparity_step", o.disparity_step);
  visit("disparity_focal", o.disparity_focal);
  visit("baseline", o.baseline);
  visit("shadows", o.shadows);
  visit("dropout_from", o.dropout_from);
  visit("dropout_to", o.dropout_to);
  visit("glare_width", o.glare_width);
  visit("signal_full", o.signal_full);
  visit("signal_none", o.signal_none);
  visit("edge_step", o.edge_step);
  visit("edge_dropout", o.edge_dropout);
  visit("mixed", o.mixed);
}

// A field more or less must be named above, or files would lose it. (On platforms whose double has another size or
// alignment there is nothing to compare with.)
static_assert(sizeof(double) != 8 || alignof(double) != 8 || sizeof(NoiseOptions) == 20 * 8,
              "NoiseOptions has changed: name its fields in visit_noise");
static_assert(sizeof(double) != 8 || alignof(double) != 8 || sizeof(CameraOptions) == sizeof(NoiseOptions) + 8 * 8,
              "CameraOptions has changed: name its fields in visit_camera");

}  // namespace handhold::sensor
