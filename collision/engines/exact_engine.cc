#include "collision/engines/exact_engine.h"

#include <utility>

#include "collision/kernels/contact_patch.h"
#include "collision/kernels/exact_geometry.h"

namespace cwm::collision {
namespace {

struct ExactForm final : EngineGeometry {
  explicit ExactForm(std::shared_ptr<const ExactGeometry> g) : geometry(std::move(g)) {}
  std::shared_ptr<const ExactGeometry> geometry;
};

PlacedExact Placed(const EngineGeometry& geometry, const Pose& X_WS) {
  return {*static_cast<const ExactForm&>(geometry).geometry, X_WS};
}

}  // namespace

bool ExactEngine::Supports(ShapeKind, ShapeKind, QueryKind) const { return true; }

std::shared_ptr<const EngineGeometry> ExactEngine::PrepareFrom(
    std::shared_ptr<const ExactGeometry> exact) const {
  return std::make_shared<const ExactForm>(std::move(exact));
}

bool ExactEngine::Collides(const PlacedGeometry& a, const PlacedGeometry& b,
                           WorkCounter* work) const {
  return ExactOverlap(Placed(a.geometry, a.X_WS), Placed(b.geometry, b.X_WS), work);
}

PairDistance ExactEngine::Distance(const PlacedGeometry& a, const PlacedGeometry& b,
                                   double max_distance_m, WorkCounter* work) const {
  return ExactDistance(Placed(a.geometry, a.X_WS), Placed(b.geometry, b.X_WS), max_distance_m,
                       work);
}

void ExactEngine::Contacts(const PlacedGeometry& a, const PlacedGeometry& b, double max_distance_m,
                           int max_count, std::vector<PairDistance>& contacts,
                           WorkCounter* work) const {
  ExactContacts(Placed(a.geometry, a.X_WS), Placed(b.geometry, b.X_WS),
                {max_distance_m, max_count, work}, contacts);
}

std::optional<RayHit> CastRay(const EngineGeometry& exact, const Pose& X_WS, const Ray& ray,
                              WorkCounter* work) {
  return ExactRay(Placed(exact, X_WS), ray, work);
}

PairDistance DistanceWithin(const PlacedGeometry& a, const PlacedGeometry& b, double max_distance_m,
                            double slack, WorkCounter* work) {
  return ExactDistanceWithin(Placed(a.geometry, a.X_WS), Placed(b.geometry, b.X_WS), max_distance_m,
                             slack, work);
}

std::optional<double> LowerBound_m(const PlacedGeometry& a, const PlacedGeometry& b) {
  return ExactLowerBound_m(Placed(a.geometry, a.X_WS), Placed(b.geometry, b.X_WS));
}

CapError CapErrorOf(const PlacedGeometry& a, const PlacedGeometry& b, double reach_m,
                    WorkCounter* work) {
  return CapErrorOf(Placed(a.geometry, a.X_WS), Placed(b.geometry, b.X_WS), reach_m, work);
}

CapError CapErrorAt(const EngineGeometry& exact, const Vector3& p, double reach_m) {
  return CapErrorAt(*static_cast<const ExactForm&>(exact).geometry, p, reach_m);
}

bool MayMeetCap(const EngineGeometry& exact, const Pose& X_WS, const Ray& ray) {
  return MayMeetCap(Placed(exact, X_WS), ray);
}

const Shape& ShapeOf(const EngineGeometry& exact) {
  return static_cast<const ExactForm&>(exact).geometry->shape();
}

const TriangleTree* TreeOf(const EngineGeometry& exact) {
  return static_cast<const ExactForm&>(exact).geometry->tree();
}

}  // namespace cwm::collision
