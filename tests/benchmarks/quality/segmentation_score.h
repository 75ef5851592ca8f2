// The agreement of a scan's labels with hand-made ones, after the modified Object Segmentation
// Database (mOSD): 0 nothing, 1-9 support, 10 k + part for parts of objects.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace cwm::benchmarks {

enum class TruthLevel {
  kObjects,  // whole, also if an occluder cuts them in two
  kParts     // the pieces that a view of the scan alone tells apart
};

struct SegmentationScore {
  // Mean over the true objects, weighted by their points, of the best intersection over union.
  double weighted_overlap = 0;
  // Share of the object points that lie outside the found object that shares most with theirs.
  double over_segmentation = 0;
  // Points of those found objects that lie on something else, per object point.
  double under_segmentation = 0;
  int true_count = 0;
  int found_count = 0;    // of kSmallestFoundObject points or more
  int matched_count = 0;  // true ones with an intersection over union above kMatch_iou
};

inline constexpr double kMatch_iou = 0.75;
inline constexpr std::size_t kSmallestFoundObject = 100;

// Takes one label per point on either side, equally many on both. Found parts are merged into their
// object; points whose true label is 0 are not counted.
SegmentationScore ScoreSegmentation(const std::vector<std::uint32_t>& truth,
                                    const std::vector<std::uint32_t>& found, TruthLevel level);

// Means of the overlaps over scenes; precision and recall of the objects of all scenes.
class SegmentationTotals {
 public:
  void Add(const SegmentationScore& score);

  int scenes() const { return scenes_; }
  double weighted_overlap() const { return sum_.weighted_overlap / scenes_; }
  double over_segmentation() const { return sum_.over_segmentation / scenes_; }
  double under_segmentation() const { return sum_.under_segmentation / scenes_; }
  double precision() const;
  double recall() const;
  double f1() const;
  std::string Line(const std::string& name) const;

 private:
  SegmentationScore sum_;
  int scenes_ = 0;
};

}  // namespace cwm::benchmarks
