// An object that was measured far more densely than its noise asks for is modelled on a sample of its
// points, and every point is attributed afterwards.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "perception/cloud/oriented_points.h"
#include "perception/cloud/work.h"
#include "perception/hypotheses/object_hypothesis.h"

namespace cwm::perception {

// The points that stand for a hypothesis: every stride-th of its own. Those lie near each other where
// they follow each other, so that the sample is spread as evenly as the whole, along the rays too: it
// shows the same noise.
class PointSample {
 public:
  // Stride 1, all points, unless there are both more points than the modeler makes use of and several
  // per node; so always 1 where nodes are points (images). `all` and `members` outlive it.
  PointSample(const OrientedPoints& all, const PointSet& members, std::size_t node_count);

  std::size_t stride() const { return stride_; }

  // The sampled points, in the order of the members.
  OrientedPoints Points() const;

  // Per member the part of the nearest sampled point of those around it in the order.
  std::vector<std::int32_t> OfAll(const std::vector<std::int32_t>& part_of_sampled,
                                  const Work& work) const;

  // The parts of the sampled points, of those of all members.
  std::vector<std::int32_t> OfSampled(const std::vector<std::int32_t>& part_of_member) const;

  // As many of all members as `sampled` of the sample.
  std::uint64_t Scaled(std::uint64_t sampled) const;

 private:
  struct Around {
    std::size_t first, end;  // of the sampled points
  };
  // The sampled points around the s-th in the order, itself included.
  static Around AroundSampled(std::size_t s, std::size_t count);
  // Which of them is nearest to the k-th member.
  std::size_t NearestSampled(std::size_t k, const Around& around) const;

  const OrientedPoints& all_;
  const PointSet& members_;
  std::size_t stride_ = 1;
};

}  // namespace cwm::perception
