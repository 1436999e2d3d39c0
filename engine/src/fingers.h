// Do the two fingers of the hand fit beside a part, as far as the sensor saw?
//
// The paper asks for an empty shell all around. Two fingers need less, and one camera never sees the far side: here the
// volumes of the fingers, on both sides of the part, must have been seen empty.
#pragma once

#include "conditions.h"
#include "cylinder.h"
#include "depth_image.h"
#include "handhold/options.h"

namespace handhold {

struct Grip {
  bool fits = false;
  double free = 0;  ///< 0..1; share of the finger volumes that was seen empty, of the worse finger; 0: one has no place
  double opening = 0;  ///< m; distance between the fingers; 0: one has no place
  Vector3 from{};      ///< unit; from the part towards the hand
  double angle = 0;    ///< rad; of `from` about the axis, 0 towards the sensor
};

class FingerTest {
 public:
  FingerTest(const Options& options, const DepthImage& image, const Conditions& conditions = {})
      : options_(&options), image_(&image), conditions_(conditions) {}

  /// Approach angles are multiples of kStep up to kWidest on either side of the sensor's direction.
  static constexpr int kAngles = 9;
  /// How many of them are tried.
  int angles() const { return conditions_.other_angles ? kAngles : 1; }
  /// 0, 15, -15, 30, ... degrees.
  static double angle(int i) { return (i + 1) / 2 * (i % 2 ? 1 : -1) * 0.2617993877991494; }

  /// The hand about one slice of a part: centred on the axis, `width` (m) long, at one approach angle (rad).
  Grip at(const Vector3& center, const Vector3& axis, double radius, double width, double angle) const;
  /// The first approach angle at which it fits, if there is one.
  Grip any(const Vector3& center, const Vector3& axis, double radius, double width) const;

 private:
  const Options* options_;
  const DepthImage* image_;
  Conditions conditions_;
};

}  // namespace handhold
