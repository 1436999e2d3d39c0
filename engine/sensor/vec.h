// The vector arithmetic of the engine, for the simulation.
#pragma once

#include "vec3.h"

namespace handhold::sensor {

using handhold::operator+;
using handhold::operator-;
using handhold::operator*;
using handhold::cross;
using handhold::dot;
using handhold::norm;

/// Of a vector that is not zero.
inline Vector3 unit(const Vector3& a) {
  return (1 / norm(a)) * a;
}

}  // namespace handhold::sensor
