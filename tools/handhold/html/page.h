// A result as one HTML file that shows it in three dimensions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "handhold/cloud.h"
#include "handhold/options.h"
#include "handhold/result.h"
#include "handhold/sensor.h"

namespace handhold {

/// A part of a hand.
struct PageBody {
  enum class Kind { kBox, kCylinder, kSphere };
  Kind kind = Kind::kBox;
  Vector3 size = {0, 0, 0};  ///< m; edges of a box, or of the box around a cylinder along z or a sphere
  sensor::Pose T_cloud_body;
};

struct PageGrasp {
  std::size_t handle = 0;                    ///< index into Result::handles
  std::vector<PageBody> hand;                ///< as it stands at the grasp, open
  Vector3 from = {0, 0, 0}, to = {0, 0, 0};  ///< m; cloud's frame; the hand's frame at the pre-grasp and at the grasp
  double width = 0;                          ///< m; of the part
  double opening = 0;                        ///< m; of the hand on its way
  double time = 0;                           ///< s; from the arm's start to the grasp
};
struct PageRejection {
  std::size_t handle = 0;
  std::string reason;
};
struct PagePlan {
  std::string arm, base, tip;     ///< names of the arm and of its links
  sensor::Pose T_base_cloud;      ///< the robot's z is up
  std::vector<PageGrasp> grasps;  ///< in the order planned
  std::vector<PageRejection> rejected;
};

struct Page {
  std::string name;  ///< of the cloud's file: the title
  const Cloud* cloud = nullptr;
  const Options* options = nullptr;
  Backend backend = Backend::kCpu;  ///< what searched
  const Result* result = nullptr;
  std::vector<Sample> samples;
  std::optional<PagePlan> plan;
};

/// Does nothing where this build can write pages. @throws std::runtime_error saying what it lacks
void check_page_support();

/// The whole file: the page's program, the result as JSON of schema "handhold/1" without times, and the cloud. Points
/// are rounded to 1/65535 of the box that holds them; of more than a million a share is there, and what stands alone
/// far away is left out: the page tells how many. The same input gives the same bytes.
/// @throws as check_page_support()
std::string page_text(const Page& page);

/// Atomic: `path` has the old file or the whole new one. @throws std::runtime_error as AtomicFile, and as page_text()
void write_page(const std::string& path, const Page& page);

}  // namespace handhold
