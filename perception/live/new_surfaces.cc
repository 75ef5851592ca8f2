#include "perception/live/new_surfaces.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "perception/cloud/tolerances.h"
#include "perception/live/pixel_rays.h"
#include "perception/live/world_cell.h"
#include "perception/track/model_surface.h"

namespace cwm::perception {
namespace {

// chosen: a detection is known if known bodies explain so much of it.
constexpr double kKnownShare = 0.5;
// chosen: a plane that is known by less goes on where it was not seen, and not only by its fringe
// within a cell of the world.
constexpr double kKnownPlane = 0.85;
// chosen: so many points of a detection determine that share to five percent.
constexpr std::size_t kSharePoints = 400;
// chosen: two surfaces touch if so much of one is within a cell of the other.
constexpr double kTouchingShare = 0.02;
// chosen: planes of one thing differ by so much in direction and, in the middle of the smaller, in
// height, with an error of some tenths of a degree and a centimetre in each view.
constexpr double kCoplanar_rad = 0.07;
constexpr double kCoplanar_m = 0.03;
// chosen: a shape is a plane if it is so thin and at least so wide.
constexpr double kMaxPlane_m = 0.03;
constexpr double kMinPlane_m = 0.2;
// chosen: depth cameras have no returns in the outermost pixels of an image.
constexpr int kBorder_px = 2 * kBlock_px;

struct Face {
  Vector3 normal_W = Vector3::UnitZ();
  Vector3 center_W = Vector3::Zero();
};

// The plane that the largest shape of a model is, if it is one.
std::optional<Face> FaceOf(const HybridModel& model, const Pose& X_WO) {
  std::optional<Face> face;
  double largest_m2 = 0;
  for (const ShapePart& part : model.shapes) {
    HybridModel alone;
    alone.shapes.push_back({.X_OS = Pose::Identity(), .shape = part.shape});
    const Aabb bounds_S = TightBounds(alone, Pose::Identity());
    const Vector3 size_m = bounds_S.sizes();
    Eigen::Index thin = 0;
    const double thickness_m = size_m.minCoeff(&thin);
    const double wide_m = size_m.maxCoeff();
    const double middle_m = size_m.sum() - thickness_m - wide_m;
    if (wide_m * middle_m <= largest_m2) continue;
    largest_m2 = wide_m * middle_m;
    face.reset();
    if (thickness_m > kMaxPlane_m || middle_m < kMinPlane_m) continue;
    const Pose X_WS = X_WO * part.X_OS;
    face = Face{.normal_W = X_WS.linear().col(thin), .center_W = X_WS * bounds_S.center()};
  }
  return face;
}

bool AreCoplanar(const Face& a, const Face& b) {
  const double cosine = std::abs(a.normal_W.dot(b.normal_W));
  return cosine >= std::cos(kCoplanar_rad) &&
         std::abs(a.normal_W.dot(b.center_W - a.center_W)) <= kCoplanar_m;
}

// A surface at its place.
class PlacedModel {
 public:
  PlacedModel(const HybridModel& model, const Pose& X_WO)
      : surface_(model, 2 * kWorldCell_m),
        X_OW_(X_WO.inverse()),
        bounds_W_(TightBounds(model, X_WO)) {}

  bool IsWithin(const Vector3& p_W, double within_m) const {
    if (bounds_W_.isEmpty() || bounds_W_.exteriorDistance(p_W) > within_m) return false;
    const auto nearest = surface_.Nearest(X_OW_ * p_W, within_m);
    return nearest && nearest->signed_distance_m <= within_m;
  }

 private:
  ModelSurface surface_;
  Pose X_OW_;
  Aabb bounds_W_;
};

struct Known {
  const KnownBody* body = nullptr;
  PlacedModel placed;
  std::optional<Face> face = {};
};

// A support or an object of the scene, by some of its points.
struct Detected {
  std::vector<Vector3> points_W = {};
  std::vector<double> gates_m = {};
  std::optional<Face> face = {};
};

double Share(const Detected& detected, const PlacedModel& placed, double beside_m) {
  double count = 0;
  for (std::size_t i = 0; i < detected.points_W.size(); ++i) {
    count += placed.IsWithin(detected.points_W[i], detected.gates_m[i] + beside_m) ? 1 : 0;
  }
  return detected.points_W.empty() ? 0 : count / static_cast<double>(detected.points_W.size());
}

Mesh Moved(const Mesh& mesh, const Pose& X_OM) {
  TriangleMesh moved = *mesh.mesh;
  for (Vector3& vertex : moved.vertices) vertex = X_OM * vertex;
  return MakeMesh(std::move(moved));
}

void AddParts(const HybridModel& from, const Pose& X_OF, HybridModel& to) {
  for (ShapePart part : from.shapes) {
    part.X_OS = X_OF * part.X_OS;
    if (part.hidden) part.hidden->X_FS = X_OF * part.hidden->X_FS;
    to.shapes.push_back(std::move(part));
  }
  for (const SurfacePart& part : from.surfaces) {
    to.surfaces.push_back({Moved(part.surface, X_OF), part.point_count});
  }
  for (const Handle& handle : from.handles) {
    if (handle.surface.mesh == nullptr || handle.surface.mesh->triangles.empty()) continue;
    to.surfaces.push_back({Moved(handle.surface, X_OF), handle.point_count});
  }
  to.point_count += from.point_count;
}

class Finder {
 public:
  Finder(const FrameEvidence& frame, std::span<const KnownBody> bodies,
         std::span<const Aabb> ways_W, SceneInterpretation& scene)
      : frame_(frame), ways_W_(ways_W), scene_(scene) {
    for (const KnownBody& body : bodies) {
      if (body.kind == KnownBody::Kind::kMover) continue;
      known_.push_back({.body = &body,
                        .placed = PlacedModel(*body.model, body.X_WB),
                        .face = FaceOf(*body.model, body.X_WB)});
    }
  }

  NewSurfaces Find() {
    for (std::size_t i = 0; i < scene_.supports.size(); ++i) GrowBySupport(static_cast<int>(i));
    std::vector<int> places(scene_.objects.size(), -1);
    std::vector<DetectedObject> kept;
    std::vector<DetectedObject> residuals;
    for (std::size_t i = 0; i < scene_.objects.size(); ++i) {
      DetectedObject& object = scene_.objects[i];
      const Detected detected = Describe(object);
      if (IsKnown(detected)) continue;
      if (IsOnWay(detected)) {
        Leave(object);
        continue;
      }
      if (object.kind == DetectedKind::kResidual) {
        if (!GrowByResidual(detected, object)) residuals.push_back(std::move(object));
        continue;
      }
      if (IsCut(object)) {
        Leave(object);
        continue;
      }
      places[i] = static_cast<int>(kept.size());
      kept.push_back(std::move(object));
    }
    for (DetectedObject& object : kept) {
      if (object.rests_on >= 0) object.rests_on = places[static_cast<std::size_t>(object.rests_on)];
    }
    scene_.objects = std::move(kept);
    Join(std::move(residuals));
    scene_.labels.clear();
    for (auto& [id, grown] : grown_) result_.grown.push_back(std::move(grown));
    std::ranges::sort(result_.cut_blocks);
    return std::move(result_);
  }

 private:
  double Gate_m(double range_m) const {
    return ExplainedWithin_m(std::hypot(frame_.noise.AxialSigma_m(range_m),
                                        frame_.noise.WarpSigma_m(),
                                        frame_.pose_sigma.At_m(range_m)));
  }

  void AddPoint(const Vector3& p_L, Detected& to) const {
    to.points_W.push_back(frame_.X_WC.translation() + p_L);
    to.gates_m.push_back(Gate_m(p_L.norm()));
  }

  Detected Describe(const DetectedObject& object) const {
    Detected detected{.face = FaceOf(*object.model, object.X_WO)};
    const std::size_t step = 1 + object.points_L.size() / kSharePoints;
    for (std::size_t i = 0; i < object.points_L.size(); i += step) {
      AddPoint(object.points_L[i].cast<double>(), detected);
    }
    return detected;
  }

  Detected Describe(const DetectedSupport& support) const {
    Detected detected{.face = FaceOf(*support.model, support.X_WO)};
    const ModelSurface surface(*support.model, kWorldCell_m);
    for (const SurfaceSample& sample : surface.Samples(2 * kSurfaceSamples)) {
      const Vector3 p_L = support.X_WO * sample.p_O - frame_.X_WC.translation();
      const Vector3 normal_W = support.X_WO.linear() * sample.normal_O;
      const bool is_top = normal_W.z() > 0.5;  // of 60 degrees: its sides and its body are assumed
      if (is_top && (sample.two_sided || normal_W.dot(p_L) < 0)) AddPoint(p_L, detected);
    }
    return detected;
  }

  bool IsKnown(const Detected& detected) const {
    return detected.face ? KnownShare(detected, kWorldCell_m) >= kKnownPlane
                         : KnownShare(detected, 0) >= kKnownShare;
  }

  // The share of the detection that known bodies explain, or that is at most so far beside them.
  double KnownShare(const Detected& detected, double beside_m) const {
    double count = 0;
    for (std::size_t i = 0; i < detected.points_W.size(); ++i) {
      const bool is_known = std::ranges::any_of(known_, [&](const Known& known) {
        return known.placed.IsWithin(detected.points_W[i], detected.gates_m[i] + beside_m);
      });
      count += is_known ? 1 : 0;
    }
    return detected.points_W.empty() ? 1 : count / static_cast<double>(detected.points_W.size());
  }

  // The known body of the kind that the detection touches most and continues.
  const Known* Continued(const Detected& detected, KnownBody::Kind kind) const {
    const Known* best = nullptr;
    double most = kTouchingShare;
    for (const Known& known : known_) {
      if (known.body->kind != kind || known.face.has_value() != detected.face.has_value()) continue;
      if (known.face && !AreCoplanar(*known.face, *detected.face)) continue;
      const double share = Share(detected, known.placed, kWorldCell_m);
      if (share <= most) continue;
      most = share;
      best = &known;
    }
    return best;
  }

  GrownBody& Grow(const KnownBody& body, const HybridModel& model, const Pose& X_WO) {
    GrownBody& grown = grown_[body.id];
    HybridModel joined = grown.model == nullptr ? *body.model : *grown.model;
    AddParts(model, body.X_WB.inverse() * X_WO, joined);
    grown.body = body.id;
    grown.model = std::make_shared<const HybridModel>(std::move(joined));
    return grown;
  }

  void GrowBySupport(int i) {
    const DetectedSupport& support = scene_.supports[static_cast<std::size_t>(i)];
    const Detected detected = Describe(support);
    if (IsKnown(detected)) return;
    const Known* const known = Continued(detected, KnownBody::Kind::kSupport);
    if (known == nullptr) return;
    Grow(*known->body, *support.model, support.X_WO).supports.push_back(i);
  }

  bool GrowByResidual(const Detected& detected, const DetectedObject& residual) {
    const Known* const known = Continued(detected, KnownBody::Kind::kResidual);
    if (known != nullptr) Grow(*known->body, *residual.model, residual.X_WO);
    return known != nullptr;
  }

  bool IsOnWay(const Detected& detected) const {
    return std::ranges::any_of(ways_W_, [&](const Aabb& way_W) {
      const auto within = std::ranges::count_if(
          detected.points_W, [&](const Vector3& p_W) { return way_W.contains(p_W); });
      return static_cast<double>(within) >=
             kMajority * static_cast<double>(detected.points_W.size());
    });
  }

  // True if the border of the view cuts the object.
  bool IsCut(const DetectedObject& object) const {
    bool is_cut = false;
    ForPixels(object, [&](int u, int v) {
      is_cut |= u < kBorder_px || v < kBorder_px || u >= frame_.camera.width - kBorder_px ||
                v >= frame_.camera.height - kBorder_px;
    });
    return is_cut;
  }

  // Leaves the object to a later frame.
  void Leave(const DetectedObject& object) {
    ForPixels(object, [&](int u, int v) {
      result_.cut_blocks.push_back(v / kBlock_px * frame_.classes->block_columns + u / kBlock_px);
    });
  }

  template <typename Visit>
  void ForPixels(const DetectedObject& object, const Visit& visit) const {
    const Pinhole& pinhole = frame_.camera.pinhole;
    for (const Eigen::Vector3f& p_L : object.points_L) {
      const Vector3 p_C = frame_.X_WC.linear().transpose() * p_L.cast<double>();
      const auto u = static_cast<int>(
          std::lround(pinhole.focal_u_px * p_C.x() / p_C.z() + pinhole.center_u_px));
      const auto v = static_cast<int>(
          std::lround(pinhole.focal_v_px * p_C.y() / p_C.z() + pinhole.center_v_px));
      if (u < 0 || v < 0 || u >= frame_.camera.width || v >= frame_.camera.height) continue;
      visit(u, v);
    }
  }

  // Joins residuals to what they touch, the largest first.
  void Join(std::vector<DetectedObject> residuals) {
    std::ranges::stable_sort(residuals, std::greater(),
                             [](const DetectedObject& each) { return each.points_L.size(); });
    std::vector<bool> is_taken(residuals.size(), false);
    std::vector<Detected> detected;
    for (const DetectedObject& residual : residuals) detected.push_back(Describe(residual));
    for (std::size_t first = 0; first < residuals.size(); ++first) {
      if (is_taken[first]) continue;
      DetectedObject joined = residuals[first];
      std::optional<HybridModel> model;
      // A residual that was joined may touch others that the first one does not.
      std::vector<std::size_t> open = {first};
      while (!open.empty()) {
        const std::size_t from = open.back();
        open.pop_back();
        const PlacedModel placed(*residuals[from].model, residuals[from].X_WO);
        for (std::size_t i = first + 1; i < residuals.size(); ++i) {
          if (is_taken[i] || !Belong(detected[first], detected[i])) continue;
          if (Share(detected[i], placed, kWorldCell_m) <= kTouchingShare) continue;
          is_taken[i] = true;
          open.push_back(i);
          if (!model) model = *joined.model;
          AddParts(*residuals[i].model, joined.X_WO.inverse() * residuals[i].X_WO, *model);
          joined.points_L.insert(joined.points_L.end(), residuals[i].points_L.begin(),
                                 residuals[i].points_L.end());
        }
      }
      if (model) joined.model = std::make_shared<const HybridModel>(*std::move(model));
      scene_.objects.push_back(std::move(joined));
    }
  }

  static bool Belong(const Detected& a, const Detected& b) {
    if (a.face && b.face) return AreCoplanar(*a.face, *b.face);
    return !a.face && !b.face;
  }

  const FrameEvidence& frame_;
  const std::span<const Aabb> ways_W_;
  SceneInterpretation& scene_;
  std::vector<Known> known_;
  std::map<BodyId, GrownBody> grown_;
  NewSurfaces result_;
};

}  // namespace

NewSurfaces FindNewSurfaces(const FrameEvidence& frame, std::span<const KnownBody> bodies,
                            std::span<const Aabb> ways_W, SceneInterpretation& scene) {
  return Finder(frame, bodies, ways_W, scene).Find();
}

}  // namespace cwm::perception
