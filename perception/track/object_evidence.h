// Compares every known object with every detection of a scan: shares of points that it explains,
// and counts of rays.
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "perception/track/association.h"
#include "perception/track/model_surface.h"
#include "perception/track/scan_evidence.h"

namespace cwm::perception {

// A known object that the user does not own and that is not a support.
struct KnownEvidence {
  int index = 0;  // index into the list of known objects
  KnownObject::Kind kind = KnownObject::Kind::kObject;
  Pose X_LO = Pose::Identity();
  const HybridModel* model = nullptr;  // never null
  ModelSurface surface;
  std::vector<SurfaceSample> samples;
  SightCounts sights;      // at X_LO
  bool lost_part = false;  // rays pass through a whole part at X_LO
};

struct DetectedEvidence {
  int index = 0;  // index into the scene's objects
  DetectedKind kind = DetectedKind::kObject;
  Pose X_LO = Pose::Identity();
  const HybridModel* model = nullptr;  // never null
  DetectedPoints points;
  double own_share = 0;          // share of its points that its own model explains
  double own_through_share = 0;  // share of its own model's visible part that rays pass through
  bool lost_part = false;        // rays pass through a whole part of its own model
};

// A known object's model at some place, compared with a detection.
struct PlacedFit {
  double explained_share = 0;  // share of the detection's points that the model explains
  double covered_share = 0;    // share of the model's seen surface near the detection's points
  double through_share = 0;    // share of the model's visible surface that rays pass through

  // Similar to intersection over union: the smaller share counts. The constant makes an object with
  // a small visible part score above none.
  double Score() const { return explained_share * (0.1 + covered_share); }
};

class ObjectEvidence {
 public:
  // All arguments must outlive this.
  ObjectEvidence(const std::vector<KnownObject>& known, const SceneInterpretation& scene,
                 const ScanEvidence& scan);

  std::vector<KnownEvidence> known;
  std::vector<DetectedEvidence> detected;

  // The known object at its old place; null if it is far away from the detection.
  const PlacedFit* FitInPlace(int k, int d) const;
  PlacedFit FitAt(int k, const Pose& X_LO, int d) const;

  // True if a part of the known object is gone that is not part of the detection either: a thing
  // that was seen as one with it.
  bool HasLostPart(int k, int d) const { return known[k].lost_part && !detected[d].lost_part; }

  // True if the known model explains the detection within noise, or about as well as the model
  // fitted to the detection: no other model is needed.
  bool IsAsGoodAsDetected(const PlacedFit& fit, int d) const;

  double UserShare(int d) const;     // share of d's points that users' objects explain
  double PresentShare(int d) const;  // the same, with known objects that are still there
  // The largest distance, in metres, of any surface sample between its old place and this one.
  double LargestShift_m(int k, const Pose& X_LO) const;

 private:
  struct SupportFace {
    Pose X_OL = Pose::Identity();
    Eigen::AlignedBox2d area;
  };
  struct InPlace {
    PlacedFit fit;
    std::vector<char> explained;  // per point of the detection
  };

  void AddDetected(const DetectedObject& object, int index);
  void AddKnown(const KnownObject& object, int index);
  void MarkUsers(const std::vector<KnownObject>& objects);
  void MarkPresent(const std::vector<KnownObject>& objects);
  bool OnSupport(const Vector3& p_L) const;
  PlacedFit FitOf(int k, const Pose& X_LO, int d, double explained_share,
                  const SightCounts& sights) const;
  bool LosesPart(const std::vector<SurfaceSample>& samples, const Pose& X_LO) const;
  SightCounts SightsOf(const std::vector<SurfaceSample>& samples, const Pose& X_LO) const;

  const ScanEvidence& scan_;
  std::vector<SupportFace> supports_;
  double reach_m_ = 0;  // the largest gate or tolerance of all points
  std::map<std::pair<int, int>, InPlace> in_place_;
  std::vector<std::vector<char>> by_users_;    // per detection, per point
  std::vector<std::vector<char>> by_present_;  // per detection, per point
};

}  // namespace cwm::perception
