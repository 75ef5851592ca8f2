// The true handles of a scan that an interpretation reports, and the reported handles that are true
// ones.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tests/benchmarks/quality/seen_shapes.h"

namespace cwm::benchmarks {

// A true handle counts if this many points of it were measured.
inline constexpr std::size_t kCountedHandlePoints = 60;
inline constexpr double kSameHandle_iou = 0.5;  // of the points

struct HandleTally {
  int true_count = 0;  // of kCountedHandlePoints or more
  int found_count = 0;
  int reported_count = 0;
  int right_count = 0;  // reported ones that are a true handle, of whatever size
  std::vector<std::string> failures;

  double recall() const;
  double precision() const;
};

// Adds the handles of the interpretation by the labels of their points. Those past the ninth part
// of an object cannot be told apart and count as one.
void AddHandles(const std::string& scene, const InterpretedView& view, HandleTally& tally);

}  // namespace cwm::benchmarks
