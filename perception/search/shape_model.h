// The interface that a shape needs to be searched for and refined (paper, section V: "a common
// interface, so they can be easily enabled and disabled and new models can easily be added"). A
// model is an unbounded surface; the solid that is made of it is bounded.
#pragma once

#include <Eigen/Core>
#include <array>
#include <concepts>
#include <optional>
#include <span>

#include "collision/geometry/pose.h"

namespace cwm::perception {

// A measured point and its unit normal, turned toward the sensor.
struct SamplePoint {
  Vector3 p = Vector3::Zero();
  Vector3 n = Vector3::Zero();
};

// chosen: the least angle between two normals, 10 degrees; with a smaller one noise alone
// determines the axis or the centre.
inline constexpr double kParallel_sin = 0.17;
// derived: the determinant of the mean of the projectors across two lines with that angle between
// them, sin^2 / 4.
inline constexpr double kParallel_determinant = 0.0075;

// An axis-aligned box, as the cells of the octree store it.
struct CellBounds {
  Vector3 center = Vector3::Zero();
  Vector3 half_m = Vector3::Zero();
};

// Curved surfaces are seen from outside (a can) or from inside (the inner wall of a bowl): the
// normals that the sensor sees are the outward ones of the solid, or their opposites.
enum class SeenFrom { kOutside, kInside };

inline double SignOf(SeenFrom side) { return side == SeenFrom::kOutside ? 1.0 : -1.0; }

// The contract of a shape model M:
//   Sample           a minimal sample, an array of SamplePoint: FromSample's input
//   Parameters       a vector of local parameters
//   kParameterCount  degrees of freedom, k of the selection criterion
//   kFirstTilt       index of the two parameters that tilt the axis or normal; none without a
//                    direction
//   FromSample       the surface through a minimal sample; empty if it defines none
//   Distance_m       signed orthogonal distance to the unbounded surface, positive outside
//   Normal           unit gradient of Distance_m at p; where there is none, a valid one of the
//                    surface
//   FacingSign       +1 if the normals that the sensor sees are Normal(), -1 if its opposites
//   Gradient         of Distance_m by the local parameters, at the current ones
//   Moved            the surface after a small step of the local parameters
//   MayReach         false only if no point of the box is within `gate_m` of the surface:
//                    conservative, so that pruning loses nothing
//   Centred          the same surface with its reference point moved to the foot of `p`, where its
//                    parameters are least correlated
template <class M>
concept ShapeModel = requires(const M m, const Vector3 p, const CellBounds box, double gate_m,
                              const typename M::Parameters step, const typename M::Sample sample) {
  requires std::same_as<decltype(M::kParameterCount), const int>;
  { M::FromSample(sample) } -> std::same_as<std::optional<M>>;
  { m.Distance_m(p) } -> std::same_as<double>;
  { m.Normal(p) } -> std::same_as<Vector3>;
  { m.FacingSign() } -> std::same_as<double>;
  { m.Gradient(p) } -> std::same_as<typename M::Parameters>;
  { m.Moved(step) } -> std::same_as<M>;
  { m.MayReach(box, gate_m) } -> std::same_as<bool>;
  { m.Centred(p) } -> std::same_as<M>;
};

// Shape models with an axis or a normal.
template <class M>
concept DirectedModel = ShapeModel<M> && requires {
  { M::kFirstTilt } -> std::convertible_to<int>;
};

}  // namespace cwm::perception
