// Samples objects whose points are much denser than their noise requires: shapes are found on the
// sample, and then every point is attributed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "perception/cloud/oriented_points.h"
#include "perception/cloud/work.h"
#include "perception/hypotheses/object_hypothesis.h"

namespace cwm::perception {

// The sample of a hypothesis: every stride-th of its points. Consecutive points lie near each
// other, so the sample is spread as evenly as all points, also along the rays, and shows the same
// noise.
class PointSample {
 public:
  // The stride is 1 (all points) unless there are more points than the modeler uses and several per
  // node; it is always 1 if nodes are points (images). `all` and `members` must outlive the sample.
  PointSample(const OrientedPoints& all, const PointSet& members, std::size_t node_count);

  std::size_t stride() const { return stride_; }

  // The sampled points, in the order of the members.
  OrientedPoints Points() const;

  // Returns, per member, the part of the nearest sampled point among those around it in the order.
  std::vector<std::int32_t> PartsOfAllPoints(const std::vector<std::int32_t>& part_of_sampled,
                                             const Work& work) const;

  // Returns the parts of the sampled points, given those of all members.
  std::vector<std::int32_t> PartsOfSampledPoints(
      const std::vector<std::int32_t>& part_of_member) const;

  // Scales a number of sampled points to all members.
  std::uint64_t Scaled(std::uint64_t sampled) const;

 private:
  struct Around {
    std::size_t first, end;  // indices of sampled points
  };
  // The sampled points around the s-th in the order, including it.
  static Around AroundSampled(std::size_t s, std::size_t count);
  // The index of the sampled point that is nearest to the k-th member.
  std::size_t NearestSampled(std::size_t k, const Around& around) const;

  const OrientedPoints& all_;
  const PointSet& members_;
  std::size_t stride_ = 1;
};

}  // namespace cwm::perception
