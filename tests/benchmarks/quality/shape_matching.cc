#include "tests/benchmarks/quality/shape_matching.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace cwm::benchmarks {
namespace {

constexpr double kMaxOf = 0.75;  // of its points, as the outcomes say
constexpr double kSomeOf = 0.25;

// The number of points that each pair of groups shares.
using Overlaps = std::map<std::pair<std::int32_t, std::int32_t>, std::size_t>;

constexpr std::int32_t kNoShape = -1;

template <class Shapes>
std::vector<std::int32_t> OwnerOfPoint(const Shapes& shapes, std::size_t point_count) {
  std::vector<std::int32_t> owner(point_count, kNoShape);
  for (std::size_t s = 0; s < shapes.size(); ++s) {
    for (std::uint32_t i : shapes[s].points) owner[i] = static_cast<std::int32_t>(s);
  }
  return owner;
}

Overlaps CountOverlaps(const std::vector<std::int32_t>& a, const std::vector<std::int32_t>& b) {
  Overlaps overlaps;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i] != kNoShape && b[i] != kNoShape) ++overlaps[{a[i], b[i]}];
  }
  return overlaps;
}

double Share(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

double Iou(std::size_t shared, std::size_t a, std::size_t b) {
  return Share(shared, a + b - shared);
}

// The object of each point by the labels, from 0; kNoShape for supports and unlabelled points.
std::vector<std::int32_t> ObjectOfPoint(const perception::SceneInterpretation& interpretation) {
  std::vector<std::int32_t> object;
  object.reserve(interpretation.labels.size());
  for (std::uint32_t label : interpretation.labels) {
    object.push_back(label < 20 ? kNoShape : static_cast<std::int32_t>(label / 10 - 2));
  }
  return object;
}

double AxialSigma_m(const TrueShape& truth, const InterpretedView& view) {
  double sum_m = 0;
  for (std::uint32_t i : truth.points) sum_m += view.scan.cloud.points[i].z();
  const double depth_m = sum_m / static_cast<double>(truth.points.size());
  return view.noise.AxialSigma_m(depth_m);
}

class Matcher {
 public:
  explicit Matcher(const InterpretedView& view) : view_(view) {
    result_.truth = TrueShapes(view);
    result_.found = FoundShapes(view);
    true_owner_ = OwnerOfPoint(result_.truth, view.scan.cloud.size());
    found_owner_ = OwnerOfPoint(result_.found, view.scan.cloud.size());
    overlaps_ = CountOverlaps(true_owner_, found_owner_);
    const std::vector<std::int32_t> objects = ObjectOfPoint(view.interpretation);
    object_overlaps_ = CountOverlaps(true_owner_, objects);
    for (std::int32_t object : objects) object_size_[object] += object != kNoShape;
  }

  SceneShapes Run() {
    for (std::int32_t t = 0; t < Count(result_.truth); ++t) {
      result_.outcomes.push_back(Truth(t).points.empty() ? ShapeOutcome{} : OutcomeOf(t));
    }
    for (std::int32_t f = 0; f < Count(result_.found); ++f) {
      if (Found(f).points.size() >= kCountedFoundPoints && !Matches(f)) AddSpurious(f);
    }
    return std::move(result_);
  }

 private:
  template <class Shapes>
  static std::int32_t Count(const Shapes& shapes) {
    return static_cast<std::int32_t>(shapes.size());
  }
  const TrueShape& Truth(std::int32_t t) const {
    return result_.truth[static_cast<std::size_t>(t)];
  }
  const FoundShape& Found(std::int32_t f) const {
    return result_.found[static_cast<std::size_t>(f)];
  }
  std::size_t Shared(std::int32_t t, std::int32_t f) const {
    const auto at = overlaps_.find({t, f});
    return at == overlaps_.end() ? 0 : at->second;
  }

  ShapeOutcome OutcomeOf(std::int32_t t) const {
    ShapeOutcome result;
    for (std::int32_t f = 0; f < Count(result_.found); ++f) {
      const double iou = Iou(Shared(t, f), Truth(t).points.size(), Found(f).points.size());
      if (iou > result.iou) result.iou = iou, result.best = f;
    }
    for (const auto& [pair, shared] : object_overlaps_) {
      if (pair.first != t) continue;
      const double iou = Iou(shared, Truth(t).points.size(), object_size_.at(pair.second));
      result.object_iou = std::max(result.object_iou, iou);
    }
    result.outcome = result.iou >= kSamePoints_iou ? TypeOutcome(t, result) : LossOf(t, result);
    result.errors = IsFound(result.outcome) ? ErrorsOf(Truth(t), Found(result.best), view_)
                                            : InfiniteErrors(Truth(t), view_);
    return result;
  }

  Outcome TypeOutcome(std::int32_t t, ShapeOutcome& result) const {
    const FoundShape& found = Found(result.best);
    result.surface_sigma =
        SurfaceDifference_m(Truth(t), found, view_) / AxialSigma_m(Truth(t), view_);
    if (KindOf(found.part.shape) == KindOf(Truth(t).shape)) return Outcome::kFound;
    return result.surface_sigma <= kSameSurface_sigma ? Outcome::kEquivalent : Outcome::kWrongType;
  }

  Outcome LossOf(std::int32_t t, const ShapeOutcome& result) const {
    if (result.best < 0) return Outcome::kMissing;
    const std::size_t shared = Shared(t, result.best);
    const double of_truth = Share(shared, Truth(t).points.size());
    if (of_truth >= kMaxOf) return Outcome::kMerged;
    if (of_truth < kSomeOf) return Outcome::kMissing;
    const double of_found = Share(shared, Found(result.best).points.size());
    return of_found >= kMaxOf ? Outcome::kSplit : Outcome::kPartial;
  }

  bool Matches(std::int32_t f) const {
    return std::any_of(result_.outcomes.begin(), result_.outcomes.end(),
                       [&](const ShapeOutcome& o) { return o.best == f && IsFound(o.outcome); });
  }

  void AddSpurious(std::int32_t f) {
    const FoundShape& found = Found(f);
    const auto fixture_points = static_cast<std::size_t>(
        std::count_if(found.points.begin(), found.points.end(),
                      [&](std::uint32_t i) { return true_owner_[i] == kNoShape; }));
    if (2 * fixture_points >= found.points.size()) {
      if (!IsThin(found.part.shape)) result_.spurious.push_back({f, Invention::kBackground});
      return;
    }
    result_.spurious.push_back({f, OnObjects(f)});
  }

  // Lone faces of the modeler are this thin (and at least that wide).
  static bool IsThin(const Shape& shape) {
    constexpr double kThin_m = 0.03;
    if (KindOf(shape) == ShapeKind::kPlate) return true;
    const auto* box = std::get_if<Box>(&shape);
    return box != nullptr && box->size_m.minCoeff() <= kThin_m;
  }

  Invention OnObjects(std::int32_t f) const {
    for (std::int32_t t = 0; t < Count(result_.truth); ++t) {
      const ShapeOutcome& outcome = result_.outcomes[static_cast<std::size_t>(t)];
      if (outcome.best == f && outcome.outcome == Outcome::kWrongType) return Invention::kWrongType;
      if (Share(Shared(t, f), Found(f).points.size()) >= kMaxOf) return Invention::kFragment;
    }
    return Invention::kMixture;
  }

  const InterpretedView& view_;
  SceneShapes result_;
  std::vector<std::int32_t> true_owner_, found_owner_;
  Overlaps overlaps_, object_overlaps_;
  std::map<std::int32_t, std::size_t> object_size_;
};

}  // namespace

std::string_view NameOf(Outcome outcome) {
  constexpr std::array<std::string_view, kOutcomeCount> kNames = {
      "found", "equivalent", "wrong type", "merged", "split", "partial", "missing"};
  return kNames[static_cast<std::size_t>(outcome)];
}

std::string_view NameOf(Invention invention) {
  constexpr std::array<std::string_view, kInventionCount> kNames = {"wrong type", "fragment",
                                                                    "mixture", "background"};
  return kNames[static_cast<std::size_t>(invention)];
}

SceneShapes MatchShapes(const InterpretedView& view) { return Matcher(view).Run(); }

}  // namespace cwm::benchmarks
