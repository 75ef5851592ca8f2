#include "perception/track/object_association.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "perception/cloud/tolerances.h"
#include "perception/track/alignment.h"
#include "perception/track/object_evidence.h"
#include "perception/track/ray_classification.h"
#include "perception/track/relocation.h"

namespace cwm::perception {
namespace {

using Outcome = Association::Outcome;

// measured: by so much do the scores differ at most of fits of two objects of one shape, simulated
// household things seen by a Kinect, to the points of one of them.
constexpr double kAlikeMargin = 0.03;

struct Pair {
  int known = 0;     // index into KnownEvidence
  int detected = 0;  // index into DetectedEvidence
  double score = 0;
};

// Matches known objects and detections in steps, the surest first; each removes what it matched.
class ObjectMatcher {
 public:
  ObjectMatcher(const std::vector<KnownObject>& known, const SceneInterpretation& scene,
                const ScanEvidence& scan)
      : objects_(known), scan_(scan), evidence_(known, scene, scan) {
    known_taken_.assign(evidence_.known.size(), 0);
    detected_taken_.assign(evidence_.detected.size(), 0);
  }

  std::vector<Association> Match() {
    ExplainByUsers();
    KeepUnchanged();
    ExplainPieces();
    MoveDisplaced();
    ReplaceChanged();
    AddNew();
    JudgeUnseen();
    return std::move(result_);
  }

 private:
  void Take(Outcome outcome, const Pair& pair, const Pose& X_WO) {
    known_taken_[pair.known] = detected_taken_[pair.detected] = 1;
    result_.push_back({.outcome = outcome,
                       .known = evidence_.known[pair.known].index,
                       .object = evidence_.detected[pair.detected].index,
                       .X_WO = X_WO});
  }

  void TakeDetected(Outcome outcome, int detected) {
    detected_taken_[detected] = 1;
    result_.push_back({.outcome = outcome, .object = evidence_.detected[detected].index});
  }

  const KnownObject& ObjectOf(int known) const { return objects_[evidence_.known[known].index]; }
  const std::string& NameOf(int known) const { return ObjectOf(known).name; }

  // Best first; ties by name, then by the order of the scene.
  void Sort(std::vector<Pair>& pairs) const {
    std::sort(pairs.begin(), pairs.end(), [&](const Pair& a, const Pair& b) {
      if (a.score != b.score) return a.score > b.score;
      if (a.known != b.known) return NameOf(a.known) < NameOf(b.known);
      return a.detected < b.detected;
    });
  }

  template <class Use>
  void ForFreePairs(std::vector<Pair> pairs, const Use& use) {
    Sort(pairs);
    for (const Pair& pair : pairs) {
      if (!known_taken_[pair.known] && !detected_taken_[pair.detected]) use(pair);
    }
  }

  void ExplainByUsers() {
    for (int d = 0; d < DetectedCount(); ++d) {
      if (evidence_.UserShare(d) >= kNearlyAll) TakeDetected(Outcome::kExplained, d);
    }
  }

  void KeepUnchanged() {
    std::vector<Pair> pairs;
    for (int k = 0; k < KnownCount(); ++k) {
      for (int d = 0; d < DetectedCount(); ++d) {
        const PlacedFit* fit = evidence_.FitInPlace(k, d);
        if (fit == nullptr || !evidence_.IsAsGoodAsDetected(*fit, d)) continue;
        if (evidence_.HasLostPart(k, d)) continue;
        pairs.push_back({k, d, fit->Score()});
      }
    }
    ForFreePairs(std::move(pairs),
                 [&](const Pair& pair) { Take(Outcome::kKeep, pair, ObjectOf(pair.known).X_WO); });
  }

  // A detection that is explained by known objects that are still there is not new: this scan was
  // only segmented differently.
  void ExplainPieces() {
    for (int d = 0; d < DetectedCount(); ++d) {
      if (detected_taken_[d]) continue;
      if (evidence_.PresentShare(d) >= kNearlyAll) TakeDetected(Outcome::kExplained, d);
    }
  }

  bool MayHaveMoved(int k, int d) const {
    const KnownEvidence& known = evidence_.known[k];
    if (known.kind != KnownObject::Kind::kObject ||
        evidence_.detected[d].kind != DetectedKind::kObject) {
      return false;
    }
    const PlacedFit* fit = evidence_.FitInPlace(k, d);
    const bool overlaps = fit != nullptr && fit->explained_share > 0;
    return overlaps || ObjectOf(k).is_gone || ClassifyByRays(known.sights) == Outcome::kRemove;
  }

  // True if the pose is nearer to the object's last one than the object is large.
  bool IsNearItsPlace(int k, const Pose& X_LO) const {
    const Aabb bounds_O = TightBounds(*evidence_.known[k].model, Pose::Identity());
    return evidence_.LargestShift_m(k, X_LO) < bounds_O.diagonal().norm();
  }

  void MoveDisplaced() {
    std::vector<Pair> pairs;
    for (int k = 0; k < KnownCount(); ++k) {
      if (known_taken_[k]) continue;
      for (int d = 0; d < DetectedCount(); ++d) {
        if (detected_taken_[d] || !MayHaveMoved(k, d)) continue;
        const auto place = Relocate(evidence_, k, d, scan_);
        if (!place) continue;
        // If several objects fit alike, the one that was there is the likeliest.
        const double margin = IsNearItsPlace(k, place->X_LO) ? kAlikeMargin : 0;
        pairs.push_back({k, d, place->fit.Score() + margin});
        moved_[{k, d}] = place->X_LO;
      }
    }
    ForFreePairs(std::move(pairs), [&](const Pair& pair) {
      const Pose& X_LO = moved_.at({pair.known, pair.detected});
      const Pose& X_WO_old = ObjectOf(pair.known).X_WO;
      const bool at_rest =
          evidence_.LargestShift_m(pair.known, X_LO) < scan_.SmallestMove_m(X_LO.translation());
      if (at_rest && evidence_.HasLostPart(pair.known, pair.detected)) return;  // it is replaced
      Take(at_rest ? Outcome::kKeep : Outcome::kMove, pair,
           at_rest ? X_WO_old : scan_.InWorld(X_LO));
    });
  }

  void ReplaceChanged() {
    std::vector<Pair> pairs;
    for (int k = 0; k < KnownCount(); ++k) {
      for (int d = 0; d < DetectedCount(); ++d) {
        const PlacedFit* fit = evidence_.FitInPlace(k, d);
        // A known object that explains less is beside the detection, not at its place.
        if (fit == nullptr || fit->explained_share < kSubstantialShare) continue;
        pairs.push_back({k, d, fit->Score()});
      }
    }
    ForFreePairs(std::move(pairs), [&](const Pair& pair) {
      Take(Outcome::kReplace, pair, ObjectOf(pair.known).X_WO);
    });
  }

  void AddNew() {
    for (int d = 0; d < DetectedCount(); ++d) {
      if (!detected_taken_[d]) TakeDetected(Outcome::kAdd, d);
    }
  }

  void JudgeUnseen() {
    for (int k = 0; k < KnownCount(); ++k) {
      if (known_taken_[k]) continue;
      const KnownEvidence& known = evidence_.known[k];
      result_.push_back({.outcome = ClassifyByRays(known.sights),
                         .known = known.index,
                         .X_WO = ObjectOf(k).X_WO});
    }
  }

  int KnownCount() const { return static_cast<int>(evidence_.known.size()); }
  int DetectedCount() const { return static_cast<int>(evidence_.detected.size()); }

  const std::vector<KnownObject>& objects_;
  const ScanEvidence& scan_;
  ObjectEvidence evidence_;
  std::vector<char> known_taken_;
  std::vector<char> detected_taken_;
  std::map<std::pair<int, int>, Pose> moved_;
  std::vector<Association> result_;
};

}  // namespace

std::vector<Association> AssociateObjects(const std::vector<KnownObject>& known,
                                          const SceneInterpretation& scene,
                                          const ScanEvidence& scan) {
  return ObjectMatcher(known, scene, scan).Match();
}

}  // namespace cwm::perception
