// A thing that was measured far more densely than its noise asks for is modelled on a part of its
// points, and every point is attributed afterwards.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "perception/cloud/oriented_points.h"
#include "perception/cloud/work.h"
#include "perception/scene/segment_scene.h"

namespace cwm::perception {

// Which points of a thing stand for it: every stride-th of SegmentedThing::points. Those lie near
// each other where they follow each other, so that the part is spread as evenly as the whole, along
// the rays too: it shows the same noise.
class ThingSample {
 public:
  // Stride 1, all points, unless the thing has both more points than the modeler makes use of and
  // several per node; so always 1 where nodes are points (images).
  ThingSample(const SegmentedScene& scene, const SegmentedThing& thing);

  std::size_t stride() const { return stride_; }

  // The points that stand for the thing, in its order.
  OrientedPoints Points() const;

  // Per point of the thing the part of the nearest sampled point of those around it in the order.
  std::vector<std::int32_t> OfAll(const std::vector<std::int32_t>& part_of_sampled,
                                  const Work& work) const;

  // As many of all points of the thing as `sampled` of the sample.
  std::uint64_t Scaled(std::uint64_t sampled) const;

 private:
  struct Around {
    std::size_t first, end;  // of the sampled points
  };
  // The sampled points around the s-th in the order, itself included.
  static Around AroundSampled(std::size_t s, std::size_t count);
  // Which of them is nearest to the k-th point of the thing.
  std::size_t NearestSampled(std::size_t k, const Around& around) const;

  const OrientedPoints& all_;
  const std::vector<std::uint32_t>& members_;
  std::size_t stride_ = 1;
};

}  // namespace cwm::perception
