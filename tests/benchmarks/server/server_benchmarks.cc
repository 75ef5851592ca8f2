#include "tests/benchmarks/server/server_benchmarks.h"

#include <utility>

namespace cwm::benchmarks {

Figure WithLimit(Figure figure, double limit, const std::string& kind) {
  figure.baseline = kind;
  figure.baseline_value = limit;
  return figure;
}

void MeasureServer(Report& report) {
  MeasureListener(report);
  MeasureStops(report);
  MeasureMemoryReturned(report);
  MeasureOverload(report);
  MeasureAmplification(report);
}

}  // namespace cwm::benchmarks
