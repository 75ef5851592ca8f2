#include "perception/live/surface_age.h"

#include <chrono>

namespace cwm::perception {
namespace {

using std::chrono::milliseconds;

// chosen: noise moves a surface to the next cell and back within some frames.
constexpr milliseconds kLongestGap{250};
constexpr milliseconds kPruning{1000};

}  // namespace

const SurfaceAge::Age& SurfaceAge::See(const Vector3& p_W, Stamp stamp) {
  Age& age = cells_[KeyOf(CellOf(p_W))];
  if (age.frames > 0 && age.last == stamp) return age;
  if (age.frames == 0 || stamp - age.last > kLongestGap) age = {.since = stamp};
  age.last = stamp;
  ++age.frames;
  return age;
}

void SurfaceAge::Prune(Stamp stamp) {
  if (stamp - pruned_ < kPruning) return;
  pruned_ = stamp;
  absl::erase_if(cells_, [&](const auto& cell) { return stamp - cell.second.last > kPruning; });
}

}  // namespace cwm::perception
