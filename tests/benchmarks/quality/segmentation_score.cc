#include "tests/benchmarks/quality/segmentation_score.h"

#include <algorithm>
#include <cassert>
#include <cstdio>
#include <map>
#include <unordered_map>

namespace cwm::benchmarks {
namespace {

constexpr std::uint32_t kFirstTrueLabel = 10, kLabelsPerTrueObject = 10;

// The group of a label; 0 for labels that are no object.
std::uint32_t TrueGroup(std::uint32_t label, TruthLevel level) {
  if (label < kFirstTrueLabel) return 0;
  return level == TruthLevel::kObjects ? label / kLabelsPerTrueObject : label;
}

std::uint32_t FoundGroup(std::uint32_t label) { return TrueGroup(label, TruthLevel::kObjects); }

struct TrueGroupCounts {
  std::size_t points = 0;
  std::map<std::uint32_t, std::size_t> shared;  // by found group
};

struct Counts {
  std::map<std::uint32_t, TrueGroupCounts> truth;
  std::unordered_map<std::uint32_t, std::size_t> found;
  std::size_t object_points = 0;
};

Counts CountGroups(const std::vector<std::uint32_t>& truth, const std::vector<std::uint32_t>& found,
                   TruthLevel level) {
  Counts counts;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (truth[i] == 0) continue;
    const std::uint32_t theirs = FoundGroup(found[i]);
    if (theirs != 0) ++counts.found[theirs];
    const std::uint32_t group = TrueGroup(truth[i], level);
    if (group == 0) continue;
    ++counts.object_points;
    TrueGroupCounts& of_group = counts.truth[group];
    ++of_group.points;
    if (theirs != 0) ++of_group.shared[theirs];
  }
  return counts;
}

struct Best {
  double iou = 0;
  std::size_t shared = 0;  // with the found object that shares most ...
  std::size_t beside = 0;  // ... and the points of that one elsewhere
};

Best BestFor(const TrueGroupCounts& truth, const Counts& counts) {
  Best best;
  for (const auto& [found, shared] : truth.shared) {
    const std::size_t size = counts.found.at(found);
    const double iou =
        static_cast<double>(shared) / static_cast<double>(truth.points + size - shared);
    best.iou = std::max(best.iou, iou);
    if (shared > best.shared) best.shared = shared, best.beside = size - shared;
  }
  return best;
}

double Ratio(double part, double whole) { return whole > 0 ? part / whole : 0; }

}  // namespace

SegmentationScore ScoreSegmentation(const std::vector<std::uint32_t>& truth,
                                    const std::vector<std::uint32_t>& found, TruthLevel level) {
  assert(truth.size() == found.size());
  const Counts counts = CountGroups(truth, found, level);
  SegmentationScore score;
  score.true_count = static_cast<int>(counts.truth.size());
  for (const auto& [group, size] : counts.found) score.found_count += size >= kSmallestFoundObject;
  double inside = 0, beside = 0;
  for (const auto& [group, of_group] : counts.truth) {
    const Best best = BestFor(of_group, counts);
    score.weighted_overlap += best.iou * static_cast<double>(of_group.points);
    score.matched_count += best.iou > kMatch_iou;
    inside += static_cast<double>(best.shared);
    beside += static_cast<double>(best.beside);
  }
  const auto all = static_cast<double>(counts.object_points);
  score.weighted_overlap = Ratio(score.weighted_overlap, all);
  score.over_segmentation = Ratio(all - inside, all);
  score.under_segmentation = Ratio(beside, all);
  return score;
}

void SegmentationTotals::Add(const SegmentationScore& score) {
  sum_.weighted_overlap += score.weighted_overlap;
  sum_.over_segmentation += score.over_segmentation;
  sum_.under_segmentation += score.under_segmentation;
  sum_.true_count += score.true_count;
  sum_.found_count += score.found_count;
  sum_.matched_count += score.matched_count;
  ++scenes_;
}

double SegmentationTotals::precision() const { return Ratio(sum_.matched_count, sum_.found_count); }

double SegmentationTotals::recall() const { return Ratio(sum_.matched_count, sum_.true_count); }

double SegmentationTotals::f1() const {
  return Ratio(2 * precision() * recall(), precision() + recall());
}

std::string SegmentationTotals::Line(const std::string& name) const {
  char text[160];
  std::snprintf(text, sizeof(text),
                "%s scenes %d WOv %.4f Fos %.4f Fus %.4f P75 %.3f R75 %.3f F1 %.3f", name.c_str(),
                scenes_, weighted_overlap(), over_segmentation(), under_segmentation(), precision(),
                recall(), f1());
  return text;
}

}  // namespace cwm::benchmarks
