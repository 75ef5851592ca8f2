#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/kernels/vertex_lanes.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each instruction set
//
#include "collision/kernels/vertex_lanes.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace cwm::collision {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<double, 8>;
using Lane = hn::Vec<Tag>;
constexpr Tag kTag;

struct Best {
  Lane along, index;

  void Offer(Lane other_along, Lane other_index) {
    const auto is_farther = hn::Gt(other_along, along);
    along = hn::IfThenElse(is_farther, other_along, along);
    index = hn::IfThenElse(is_farther, other_index, index);
  }
};

// The index of the farthest corner. Compares the two halves of the corners independently, so that
// no comparison waits for the previous one.
std::size_t FarthestOf(const double* coordinates, std::size_t stride, double dx, double dy,
                       double dz) {
  const double *x = coordinates, *y = x + stride, *z = y + stride;
  const Lane of_x = hn::Set(kTag, dx), of_y = hn::Set(kTag, dy), of_z = hn::Set(kTag, dz);
  const auto along = [&](std::size_t i) HWY_ATTR {
    // Summed in the order of Eigen's dot product of two 3-vectors.
    const Lane xy =
        hn::Add(hn::Mul(hn::LoadU(kTag, x + i), of_x), hn::Mul(hn::LoadU(kTag, y + i), of_y));
    return hn::Add(xy, hn::Mul(hn::LoadU(kTag, z + i), of_z));
  };
  const std::size_t lanes = hn::Lanes(kTag), half = stride / 2;
  const Lane step = hn::Set(kTag, static_cast<double>(lanes));
  Lane index = hn::Iota(kTag, 0), index_above = hn::Iota(kTag, static_cast<double>(half));
  Best best{along(0), index}, above{along(half), index_above};
  for (std::size_t i = lanes; i < half; i += lanes) {
    index = hn::Add(index, step);
    index_above = hn::Add(index_above, step);
    best.Offer(along(i), index);
    above.Offer(along(half + i), index_above);
  }
  best.Offer(above.along, above.index);
  // The first of several equally far corners: indices of other lanes are replaced by `last`.
  const auto is_farthest = hn::Eq(best.along, hn::MaxOfLanes(kTag, best.along));
  const Lane last = hn::Set(kTag, static_cast<double>(stride));
  const Lane first = hn::MinOfLanes(kTag, hn::IfThenElse(is_farthest, best.index, last));
  return static_cast<std::size_t>(hn::GetLane(first));
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace cwm::collision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace cwm::collision {
namespace {

constexpr std::size_t kBlock = 16;  // two halves of eight lanes

}  // namespace

HWY_EXPORT(FarthestOf);

VertexLanes::VertexLanes(std::span<const Vector3> vertices)
    : stride_((vertices.size() + kBlock - 1) / kBlock * kBlock) {
  coordinates_.resize(3 * stride_);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < stride_; ++i) {
      coordinates_[axis * stride_ + i] =
          vertices[i < vertices.size() ? i : 0][static_cast<Eigen::Index>(axis)];
    }
  }
}

std::size_t VertexLanes::Farthest(const Vector3& d) const {
  const std::size_t found =
      HWY_DYNAMIC_DISPATCH(FarthestOf)(coordinates_.data(), stride_, d.x(), d.y(), d.z());
  return found < stride_ ? found : 0;  // a NaN direction has no farthest corner
}

}  // namespace cwm::collision
#endif  // HWY_ONCE
