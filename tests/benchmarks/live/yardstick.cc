#include "tests/benchmarks/live/yardstick.h"

#ifdef CWM_HAS_OCTOMAP
#include "tests/benchmarks/live/octomap_insertion.h"
#endif

namespace cwm::benchmarks {

#ifdef CWM_HAS_OCTOMAP
std::optional<std::vector<double>> InsertIntoOctoMap_ms(const std::vector<RecordedFrame>& frames) {
  OctoMapInsertion map(kYardstickVoxel_m);
  std::vector<double> times_ms;
  for (const RecordedFrame& frame : frames) {
    times_ms.push_back(map.Insert_ms(PointsInWorld(frame), frame.X_WC.translation()));
  }
  return times_ms;
}
#else
std::optional<std::vector<double>> InsertIntoOctoMap_ms(const std::vector<RecordedFrame>&) {
  return std::nullopt;
}
#endif

}  // namespace cwm::benchmarks
