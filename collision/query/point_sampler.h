// The search of SamplePoints: blocks of neighbouring points are tested against the world together.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "collision/query/hidden_spaces.h"
#include "collision/query/interrupt.h"
#include "collision/query/point_order.h"
#include "collision/query/query.h"
#include "collision/query/sampled_part.h"

namespace cwm::collision {

// Used by one thread. Allocates when it first meets an object, and for entries of bounds(), but not
// per point.
class PointSampler {
 public:
  // `limit_m` is QueryOptions::max_distance_m.
  PointSampler(const WorldSnapshot& world, const WorldFilter& filter, double limit_m,
               Interrupt interrupt)
      : world_(world),
        limit_m_(limit_m),
        parts_(world, filter),
        hidden_(HiddenSpacesOf(world, filter)),
        interrupt_(std::move(interrupt)) {}

  // Writes the answers for points [first, first + count) into columns sized for all of `points`.
  // False if interrupted, which leaves them undefined.
  bool Sample(std::span<const Vector3> points, std::size_t first, std::size_t count,
              PointColumns& columns);
  // The bounds of all rows answered so far that are kBounded, in no particular order.
  const std::vector<PointColumns::Bound>& bounds() const { return bounds_; }

 private:
  // A part near a block, and its distances from the points of the block.
  struct Candidate {
    const SampledPart* part;
    BlockDistances distances_m;
  };
  struct Depth {
    Accuracy accuracy;
    double bound_m;
  };

  void ListNearParts(std::span<const Vector3> chunk);
  void Reset();
  bool MeasureListed(const Aabb& block);
  bool MeasureWorld(const Aabb& block);
  bool MeasurePart(const SampledPart& part);
  void SampleBlock(std::span<const std::uint32_t> rows, PointColumns& columns);
  void SampleGroup(const int* lanes, int count, std::span<const std::uint32_t> rows,
                   PointColumns& columns);
  PointSample SampleOf(const Candidate& candidate, int lane);
  void Write(int lane, const PointSample& sample, std::size_t row, PointColumns& columns);
  bool HasCompetingGradient(int lane, const PointSample& sample);
  // The error of the point's distance because of closed holes of meshes.
  CapError CapErrorOf(int lane, double distance_m);
  // The least distance that the point may have because of hidden spaces.
  double HiddenDistance_m(int lane, double distance_m) const;
  Depth DepthOf(int lane, const PointSample& sample);
  std::optional<double> ExitDistance_m(int lane, const PointSample& sample,
                                       const Vector3& direction_W);
  bool IsCovered(int lane, const Vector3& way_out_W);
  double SolidDistance_m(const Vector3& p_W);
  Vector3 PointOf(int lane) const { return {points_.x[lane], points_.y[lane], points_.z[lane]}; }

  const WorldSnapshot& world_;
  double limit_m_;
  SampledParts parts_;
  const std::vector<HiddenSpace> hidden_;
  Interrupt interrupt_;
  PointOrder order_;
  BlockPoints points_;
  NearestLanes nearest_;
  std::vector<Candidate> candidates_;
  std::vector<PointColumns::Bound> bounds_;
  double reach_m_ = 0;  // largest reach of a point in the block

  // The parts near a chunk, if they are few: testing each is then cheaper than a tree search.
  std::vector<const SampledPart*> listed_;
  std::vector<double> listed_gaps_m2_;  // squared distance of a block's box from theirs
  double listed_reach_m_ = -1;          // all parts nearer than this are listed; negative: no list
};

}  // namespace cwm::collision
