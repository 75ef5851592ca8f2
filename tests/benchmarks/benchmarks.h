// The measurements of `./dev bench main`, each adding its figures to the report.
#pragma once

#include "tests/benchmarks/report.h"

namespace cwm::benchmarks {

// Stages of the interpreter beside PCL's plain pipeline, on the same scans in turn:
// pcl_plain_ratio.
void MeasureInterpreter(Report& report);

// Questions in process, by engine: distances_per_s.
void MeasureEngines(Report& report);

// The running server: scan_ms, transport_us_per_distance, query_p99_during_ingest_ratio.
void MeasureService(Report& report);

}  // namespace cwm::benchmarks
