#include "tests/benchmarks/quality/segmentation_score.h"

#include <gtest/gtest.h>

namespace cwm::benchmarks {
namespace {

using Labels = std::vector<std::uint32_t>;

Labels Runs(const std::vector<std::pair<std::uint32_t, int>>& runs) {
  Labels labels;
  for (const auto& [label, count] : runs) labels.insert(labels.end(), count, label);
  return labels;
}

TEST(SegmentationScore, ThatAgreesIsPerfectWhateverTheNumbers) {
  const Labels truth = Runs({{1, 500}, {20, 200}, {21, 100}, {30, 300}, {0, 50}});
  const Labels found = Runs({{2, 500}, {70, 200}, {75, 100}, {40, 300}, {0, 50}});
  const SegmentationScore score = ScoreSegmentation(truth, found, TruthLevel::kObjects);
  EXPECT_DOUBLE_EQ(score.weighted_overlap, 1);
  EXPECT_DOUBLE_EQ(score.over_segmentation, 0);
  EXPECT_DOUBLE_EQ(score.under_segmentation, 0);
  EXPECT_EQ(score.true_count, 2);
  EXPECT_EQ(score.found_count, 2);
  EXPECT_EQ(score.matched_count, 2);
}

TEST(SegmentationScore, CountsAnObjectFoundInTwoHalvesAsOverSegmented) {
  const Labels truth = Runs({{20, 400}}), found = Runs({{20, 300}, {30, 100}});
  const SegmentationScore score = ScoreSegmentation(truth, found, TruthLevel::kObjects);
  EXPECT_DOUBLE_EQ(score.weighted_overlap, 0.75);
  EXPECT_DOUBLE_EQ(score.over_segmentation, 0.25);
  EXPECT_DOUBLE_EQ(score.under_segmentation, 0);
  EXPECT_EQ(score.matched_count, 0) << "above 0.75, not at it";
  EXPECT_EQ(score.found_count, 2);
}

TEST(SegmentationScore, CountsWhatSpillsOntoTheTableAndMergedObjectsAsUnderSegmented) {
  const Labels truth = Runs({{1, 100}, {20, 300}, {30, 100}});
  const Labels found = Runs({{20, 500}});
  const SegmentationScore score = ScoreSegmentation(truth, found, TruthLevel::kObjects);
  EXPECT_DOUBLE_EQ(score.weighted_overlap, (300 * 0.6 + 100 * 0.2) / 400);
  EXPECT_DOUBLE_EQ(score.under_segmentation, (200.0 + 400.0) / 400);
  EXPECT_DOUBLE_EQ(score.over_segmentation, 0);
}

TEST(SegmentationScore, TakesPartsAsObjectsOfTheirOwnOnTheirLevelAlone) {
  const Labels truth = Runs({{20, 100}, {21, 100}}), found = Runs({{20, 200}});
  EXPECT_EQ(ScoreSegmentation(truth, found, TruthLevel::kObjects).matched_count, 1);
  const SegmentationScore parts = ScoreSegmentation(truth, found, TruthLevel::kParts);
  EXPECT_EQ(parts.true_count, 2);
  EXPECT_EQ(parts.matched_count, 0);
  EXPECT_DOUBLE_EQ(parts.weighted_overlap, 0.5);
}

TEST(SegmentationScore, IgnoresWhatHasNoTrueLabelAndSmallInventions) {
  const Labels truth = Runs({{0, 1000}, {20, 300}, {1, 99}});
  const Labels found = Runs({{20, 1300}, {30, 99}});
  const SegmentationScore score = ScoreSegmentation(truth, found, TruthLevel::kObjects);
  EXPECT_DOUBLE_EQ(score.weighted_overlap, 1);
  EXPECT_EQ(score.found_count, 1);
}

TEST(SegmentationTotals, TakeOverlapsBySceneAndCountsByObject) {
  SegmentationTotals totals;
  totals.Add({.weighted_overlap = 1, .true_count = 1, .found_count = 1, .matched_count = 1});
  totals.Add({.weighted_overlap = 0.5, .true_count = 3, .found_count = 1, .matched_count = 1});
  EXPECT_DOUBLE_EQ(totals.weighted_overlap(), 0.75);
  EXPECT_DOUBLE_EQ(totals.precision(), 1);
  EXPECT_DOUBLE_EQ(totals.recall(), 0.5);
  EXPECT_DOUBLE_EQ(totals.f1(), 2.0 / 3);
}

}  // namespace
}  // namespace cwm::benchmarks
