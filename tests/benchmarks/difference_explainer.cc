#include "tests/benchmarks/difference_explainer.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "collision/engines/engine.h"
#include "collision/geometry/signed_distance.h"
#include "collision/geometry/tessellate.h"
#include "collision/geometry/winding.h"

namespace cwm::benchmarks {

using namespace collision;

namespace {

// True if all corners of `other` lie in `holder`, by solid angles or formulas rather than by the
// trees and hulls that the engine uses. If the surfaces crossed, some corner would lie outside.
bool Encloses(const PlacedPart& holder, const PlacedPart& other) {
  const Pose X_HO = holder.X_WP.inverse(Eigen::Isometry) * other.X_WP;
  const auto* mesh = std::get_if<Mesh>(&holder.part.shape);
  if (mesh != nullptr && !mesh->watertight) return false;
  const std::vector<Vector3> corners = Tessellate(other.part.shape).vertices;
  return std::all_of(corners.begin(), corners.end(), [&](const Vector3& p_O) {
    const Vector3 p = X_HO * p_O;
    if (mesh == nullptr) return SignedDistance_m(holder.part.shape, p) < 0;
    return std::abs(WindingNumber(*mesh->mesh, p)) > 0.5;
  });
}

using Exact = long double;  // rounds some tenths of a metre to 1e-19 m
using ExactPoint = Eigen::Matrix<Exact, 3, 1>;

// The largest of the convex functions that bound a convex solid: negative inside. A search for the
// deepest point needs no more. Empty for other shapes.
std::optional<Exact> Outside_m(const Shape& shape, const ExactPoint& p) {
  if (const auto* box = std::get_if<Box>(&shape)) {
    return (p.cwiseAbs() - 0.5L * box->size_m.cast<Exact>()).maxCoeff();
  }
  if (const auto* sphere = std::get_if<Sphere>(&shape)) return p.norm() - sphere->radius_m;
  if (const auto* cylinder = std::get_if<Cylinder>(&shape)) {
    return std::max(p.head<2>().norm() - cylinder->radius_m,
                    std::abs(p.z()) - 0.5L * cylinder->length_m);
  }
  return std::nullopt;
}

// The minimum of a convex function on [0, 1].
template <class Function>
Exact MinimumOf(const Function& f) {
  constexpr int kSteps = 80;  // thirds, down to 1e-14 of a triangle's edge
  Exact low = 0, high = 1;
  for (int k = 0; k < kSteps; ++k) {
    const Exact a = low + (high - low) / 3, b = high - (high - low) / 3;
    if (f(a) < f(b)) {
      high = b;
    } else {
      low = a;
    }
  }
  return f((low + high) / 2);
}

// True if a point of one of the mesh's triangles is certainly inside the solid: by formulas in
// extended precision, without any of the engine's kernels.
bool SharesPoint(const PlacedPart& of_mesh, const PlacedPart& solid) {
  constexpr Exact kSurely_m = 1e-12L;  // poses are products in double precision
  const auto* mesh = std::get_if<Mesh>(&of_mesh.part.shape);
  if (mesh == nullptr || !Outside_m(solid.part.shape, ExactPoint::Zero())) return false;
  const auto in_solid = [&](const Vector3& p) -> ExactPoint {
    const ExactPoint p_W = of_mesh.X_WP.linear().cast<Exact>() * p.cast<Exact>() +
                           of_mesh.X_WP.translation().cast<Exact>();
    return solid.X_WP.linear().cast<Exact>().transpose() *
           (p_W - solid.X_WP.translation().cast<Exact>());
  };
  const auto outside_m = [&](const ExactPoint& p) { return *Outside_m(solid.part.shape, p); };
  return std::ranges::any_of(mesh->mesh->triangles, [&](const TriangleMesh::Triangle& triangle) {
    const ExactPoint a = in_solid(mesh->mesh->vertices[triangle[0]]),
                     b = in_solid(mesh->mesh->vertices[triangle[1]]),
                     c = in_solid(mesh->mesh->vertices[triangle[2]]);
    const ExactPoint middle = (a + b + c) / 3;
    const Exact radius_m =
        std::max({(a - middle).norm(), (b - middle).norm(), (c - middle).norm()});
    if (outside_m(middle) > radius_m) return false;
    const Exact deepest_m = MinimumOf([&](Exact u) {
      const ExactPoint on_ab = a + u * (b - a);
      return MinimumOf([&](Exact v) { return outside_m(on_ab + v * (c - on_ab)); });
    });
    return deepest_m < -kSurely_m;
  });
}

// True if FCL's verdict changes when the second part moves by no more than kTouching_m.
bool ChangesWithinTouching(const FclRobot& fcl, const FclRobot::Pair& pair, bool verdict) {
  for (const double x : {-1.0, 0.0, 1.0}) {
    for (const double y : {-1.0, 0.0, 1.0}) {
      for (const double z : {-1.0, 0.0, 1.0}) {
        const Vector3 d(x, y, z);
        if (d.isZero()) continue;
        if (fcl.PairCollides(pair, kTouching_m * d.normalized()) != verdict) return true;
      }
    }
  }
  return false;
}

}  // namespace

std::string_view NameOf(DifferenceCause cause) {
  switch (cause) {
    case DifferenceCause::kContained:
      return "one part inside of another, of which FCL has the surface alone";
    case DifferenceCause::kShared:
      return "a point of a triangle lies in the other solid, by formulas in extended precision";
    case DifferenceCause::kTouching:
      return "touching, FCL tells otherwise a micrometre farther";
    case DifferenceCause::kUnknown:
      break;
  }
  return "unexplained";
}

DifferenceExplainer::DifferenceExplainer(const QueryBody& body, const WorldSnapshot& world,
                                         const FclRobot& fcl)
    : body_(body), fcl_(fcl) {
  for (const WorldObjectPtr& object : world.objects()) {
    for (std::size_t k = 0; k < object->parts_W.size(); ++k) {
      world_.push_back({object->geometry->parts[k], object->parts_W[k].X_WP});
    }
  }
}

DifferenceCause DifferenceExplainer::Explain(std::span<const Pose> X_WF) const {
  const std::vector<FclRobot::Pair> different = DifferingPairs(X_WF);
  if (different.empty()) return DifferenceCause::kUnknown;
  DifferenceCause weakest = DifferenceCause::kContained;
  for (const FclRobot::Pair& pair : different) weakest = std::max(weakest, CauseOf(pair, X_WF));
  return weakest;
}

PlacedPart DifferenceExplainer::Part(std::size_t k, std::span<const Pose> X_WF) const {
  const PreparedPart& part = body_.geometry->parts[k];
  return {part, X_WF[static_cast<std::size_t>(body_.frame_of_part[k])] * part.X_OP};
}

PlacedPart DifferenceExplainer::Other(const FclRobot::Pair& pair,
                                      std::span<const Pose> X_WF) const {
  return pair.is_self_pair ? Part(pair.other, X_WF) : world_[pair.other];
}

bool DifferenceExplainer::CollidesByExactEngine(const FclRobot::Pair& pair,
                                                std::span<const Pose> X_WF) const {
  const auto placed = [](const PlacedPart& p) {
    return PlacedGeometry{KindOf(p.part.shape),
                          *p.part.engines[static_cast<int>(EngineKind::kExact)], p.X_WP};
  };
  const PlacedPart first = Part(pair.part, X_WF), second = Other(pair, X_WF);
  return GetEngine(EngineKind::kExact).Collides(placed(first), placed(second));
}

std::vector<FclRobot::Pair> DifferenceExplainer::DifferingPairs(std::span<const Pose> X_WF) const {
  std::vector<FclRobot::Pair> pairs;
  const auto add = [&](const FclRobot::Pair& pair) {
    if (CollidesByExactEngine(pair, X_WF) != fcl_.PairCollides(pair, Vector3::Zero()))
      pairs.push_back(pair);
  };
  for (const PartPair& pair : body_.self_pairs) {
    add({static_cast<std::size_t>(pair.first), static_cast<std::size_t>(pair.second), true});
  }
  for (std::size_t part = 0; part < body_.geometry->parts.size(); ++part) {
    for (std::size_t other = 0; other < world_.size(); ++other) add({part, other, false});
  }
  return pairs;
}

DifferenceCause DifferenceExplainer::CauseOf(const FclRobot::Pair& pair,
                                             std::span<const Pose> X_WF) const {
  const bool fcl = fcl_.PairCollides(pair, Vector3::Zero());
  const PlacedPart first = Part(pair.part, X_WF), second = Other(pair, X_WF);
  if (!fcl && (Encloses(first, second) || Encloses(second, first)))
    return DifferenceCause::kContained;
  if (!fcl && (SharesPoint(first, second) || SharesPoint(second, first)))
    return DifferenceCause::kShared;
  return ChangesWithinTouching(fcl_, pair, fcl) ? DifferenceCause::kTouching
                                                : DifferenceCause::kUnknown;
}

}  // namespace cwm::benchmarks
