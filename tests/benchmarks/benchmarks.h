// The measurements of `./dev bench`, each adding its figures to the report.
#pragma once

#include "tests/benchmarks/report.h"

namespace cwm::benchmarks {

// Stages of the interpreter beside PCL's plain pipeline, on the same scans in turn:
// pcl_plain_ratio.
void MeasureInterpreter(Report& report);

// Questions in process, by engine: distances_per_s.
void MeasureEngines(Report& report);

// Pairs of 20 cm shapes by engine and worlds of up to 10 000 objects: change_us_30, change_us_1000,
// change_us_10000, change_bytes_10000, distances_per_s_2000.
void MeasurePairs(Report& report);
void MeasureWorlds(Report& report);

// The running server: scan_ms, transport_us_per_distance, query_p99_during_ingest_ratio.
void MeasureService(Report& report);

}  // namespace cwm::benchmarks
