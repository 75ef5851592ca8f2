// The truth and the published world, frame by frame: plain values, for the judge.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "collision/geometry/pose.h"

namespace cwm::benchmarks {

enum class PublishedKind : std::uint8_t { kThing, kResidual, kMover };

// An object of the published world that is neither a support nor a user's.
struct PublishedThing {
  std::string name = {};
  PublishedKind kind = PublishedKind::kThing;
  Pose X_WO = Pose::Identity();
  Vector3 center_W = Vector3::Zero();  // of its bounds
  double diagonal_m = 0;               // of its bounds
  std::int64_t geometry_revision = 0;
  bool is_moving = false;  // by its published motion
};

struct TrueThing {
  Pose X_WO = Pose::Identity();
  Vector3 center_W = Vector3::Zero();
  double diagonal_m = 0;
  bool is_present = true;
  bool is_moving = false;
  double visible_share = 1;  // of what would be seen of it if it were alone
};

// One processed frame. All moments of a timeline have the same true things, in the same order.
struct Moment {
  double stamp_s = 0;
  std::vector<TrueThing> truth = {};
  std::vector<PublishedThing> published = {};
};

using Timeline = std::vector<Moment>;

}  // namespace cwm::benchmarks
