#include "perception/track/support_association.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "perception/cloud/tolerances.h"
#include "perception/track/alignment.h"
#include "perception/track/ray_classification.h"

namespace cwm::perception {
namespace {

using Outcome = Association::Outcome;

// derived: a face has as many samples as any other surface.
const double kSamplesAcross = std::sqrt(kSurfaceSamples);

// The face of a support with its samples.
struct Face {
  int index = 0;  // index of the known object, or of the scene's support
  Pose X_LP = Pose::Identity();
  const Plate* plate = nullptr;
  std::vector<Vector3> samples_L;
  bool taken = false;
};

bool OnFace(const Plate& plate, const Vector2& p) {
  return Contains(plate.outline, p) &&
         std::none_of(plate.holes.begin(), plate.holes.end(),
                      [&](const Polygon& hole) { return Contains(hole, p); });
}

std::optional<Face> FaceOf(int index, const Pose& X_LO, const HybridModel* model) {
  if (model == nullptr) return std::nullopt;
  for (const ShapePart& part : model->shapes) {
    const Plate* plate = std::get_if<Plate>(&part.shape);
    if (plate == nullptr) continue;
    Face face{.index = index, .X_LP = X_LO * part.X_OS, .plate = plate, .samples_L = {}};
    Eigen::AlignedBox2d bounds;
    for (const Vector2& p : plate->outline) bounds.extend(p);
    for (double u = 0.5; u < kSamplesAcross; ++u) {
      for (double v = 0.5; v < kSamplesAcross; ++v) {
        const Vector2 p =
            bounds.min() + bounds.sizes().cwiseProduct(Vector2(u, v)) / kSamplesAcross;
        if (OnFace(*plate, p)) face.samples_L.push_back(face.X_LP * Vector3(p.x(), p.y(), 0));
      }
    }
    return face;
  }
  return std::nullopt;
}

// Share of the samples of `a` that lie on the face of `b`.
double Within(const Face& a, const Face& b, const ScanEvidence& scan) {
  if (a.samples_L.empty()) return 0;
  const Pose X_PL = b.X_LP.inverse();
  const auto count = std::count_if(a.samples_L.begin(), a.samples_L.end(), [&](const Vector3& p_L) {
    const Vector3 p = X_PL * p_L;
    return std::abs(p.z()) <= scan.Tolerance_m(p_L) && OnFace(*b.plate, p.head<2>());
  });
  return static_cast<double>(count) / static_cast<double>(a.samples_L.size());
}

SightCounts SightsOf(const Face& face, const ScanEvidence& scan) {
  SightCounts counts;
  for (const Vector3& p_L : face.samples_L) counts.Add(scan.VerdictAt(p_L));
  return counts;
}

struct Match {
  Face* known = nullptr;
  Face* detected = nullptr;
  double known_within = 0;     // share of the known face in the detected one
  double detected_within = 0;  // and vice versa
};

Outcome Judge(const Match& match, const ScanEvidence& scan) {
  // A support that is seen to be larger by this much, and to contain most of the known one,
  // replaces it. Repeated views differ by a few percent at the border.
  const bool grown =
      match.known_within >= kMainShare && match.detected_within < 1 / (1 + kSubstantialShare);
  // The share of the visible face that rays may pass through, besides that of the detected face.
  const double allowed = kSubstantialShare + SightsOf(*match.detected, scan).ThroughShare();
  const bool shrunk = SightsOf(*match.known, scan).ThroughShare() > allowed;
  return grown || shrunk ? Outcome::kReplace : Outcome::kKeep;
}

double UserExplains(const Face& face, const std::vector<KnownObject>& known,
                    const ScanEvidence& scan) {
  std::vector<char> explained(face.samples_L.size(), 0);
  for (const KnownObject& object : known) {
    if (!object.owned_by_user || object.model == nullptr) continue;
    const ModelSurface surface(*object.model, kAlignmentReach_m);
    const Pose X_OL = scan.InLevelFrame(object.X_WO).inverse();
    for (std::size_t i = 0; i < face.samples_L.size(); ++i) {
      const Vector3& p_L = face.samples_L[i];
      const auto nearest = surface.Nearest(X_OL * p_L);
      explained[i] |= nearest && std::abs(nearest->signed_distance_m) <= scan.Tolerance_m(p_L);
    }
  }
  return ShareOf(explained);
}

std::vector<Match> FindMatches(std::vector<Face>& known, std::vector<Face>& detected,
                               const std::vector<KnownObject>& objects, const ScanEvidence& scan) {
  std::vector<Match> matches;
  for (Face& a : known) {
    for (Face& b : detected) {
      const Match match{&a, &b, Within(a, b, scan), Within(b, a, scan)};
      // If less of the smaller face overlaps, the supports are two tables that meet at a corner.
      if (std::max(match.known_within, match.detected_within) >= kSubstantialShare) {
        matches.push_back(match);
      }
    }
  }
  std::stable_sort(matches.begin(), matches.end(), [&](const Match& a, const Match& b) {
    const double score_a = a.known_within + a.detected_within;
    const double score_b = b.known_within + b.detected_within;
    if (score_a != score_b) return score_a > score_b;
    return objects[a.known->index].name < objects[b.known->index].name;
  });
  return matches;
}

}  // namespace

std::vector<Association> AssociateSupports(const std::vector<KnownObject>& known,
                                           const SceneInterpretation& scene,
                                           const ScanEvidence& scan) {
  std::vector<Association> result;
  std::vector<Face> known_faces;
  std::vector<Face> faces;
  for (int i = 0; i < static_cast<int>(known.size()); ++i) {
    if (known[i].owned_by_user || known[i].kind != KnownObject::Kind::kSupport) continue;
    const auto face = FaceOf(i, scan.InLevelFrame(known[i].X_WO), known[i].model.get());
    known_faces.push_back(face.value_or(Face{.index = i, .samples_L = {}}));
  }
  for (int i = 0; i < static_cast<int>(scene.supports.size()); ++i) {
    auto face = FaceOf(i, scan.InLevelFrame(scene.supports[i].X_WO), scene.supports[i].model.get());
    faces.push_back(face.value_or(Face{.index = i, .samples_L = {}}));
    if (UserExplains(faces.back(), known, scan) < kMainShare) continue;
    faces.back().taken = true;
    result.push_back({.outcome = Outcome::kExplained, .support = i});
  }
  const std::vector<Match> matches = FindMatches(known_faces, faces, known, scan);
  for (const Match& match : matches) {
    if (match.known->taken || match.detected->taken) continue;
    match.known->taken = match.detected->taken = true;
    result.push_back({.outcome = Judge(match, scan),
                      .known = match.known->index,
                      .support = match.detected->index,
                      .X_WO = known[match.known->index].X_WO});
  }
  for (Face& face : faces) {
    if (face.taken) continue;
    // A piece of a known support, which this scan shows in two pieces, is not new.
    const bool is_piece = std::any_of(matches.begin(), matches.end(), [&](const Match& match) {
      return match.detected == &face && match.detected_within >= kMainShare;
    });
    result.push_back(
        {.outcome = is_piece ? Outcome::kExplained : Outcome::kAdd, .support = face.index});
  }
  for (const Face& face : known_faces) {
    if (face.taken) continue;
    result.push_back({.outcome = ClassifyByRays(SightsOf(face, scan)),
                      .known = face.index,
                      .X_WO = known[face.index].X_WO});
  }
  return result;
}

}  // namespace cwm::perception
