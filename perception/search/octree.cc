#include "perception/search/octree.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace cwm::perception {
namespace {

// derived: shifts the three bits of the first level to the end of a key.
constexpr int kTopShift = (kMortonLevels - 1) * 3;

CellBounds TightBounds(const ModelPoints& points, std::uint32_t begin, std::uint32_t end) {
  Eigen::AlignedBox3d box;
  for (std::uint32_t i = begin; i < end; ++i) box.extend(points.p[i]);
  return {.center = box.center(), .half_m = 0.5 * box.sizes()};
}

}  // namespace

Octree::Octree(const ModelPoints& points) : leaf_of_(points.size(), 0), lanes_(points) {
  if (points.size() > 0) {
    Build(points, 0, static_cast<std::uint32_t>(points.size()), kTopShift, kNone);
  }
}

std::uint32_t Octree::Build(const ModelPoints& points, std::uint32_t begin, std::uint32_t end,
                            int shift, std::uint32_t parent) {
  const auto self = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({.bounds = TightBounds(points, begin, end),
                    .begin = begin,
                    .end = end,
                    .after = 0,
                    .parent = parent,
                    .leaf = end - begin <= kLeafPoints || shift < 0});
  if (nodes_[self].leaf) {
    std::fill(leaf_of_.begin() + begin, leaf_of_.begin() + end, self);
  } else {
    for (std::uint32_t first = begin; first < end;) {
      const std::uint32_t cell = points.key[first] >> shift;
      std::uint32_t last = first + 1;
      while (last < end && points.key[last] >> shift == cell) ++last;
      Build(points, first, last, shift - 3, self);
      first = last;
    }
  }
  nodes_[self].after = static_cast<std::uint32_t>(nodes_.size());
  return self;
}

}  // namespace cwm::perception
