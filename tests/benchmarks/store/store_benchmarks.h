// The figures of `./dev bench store`: what durable writes cost, and how fast a store is replayed.
#pragma once

#include <string>

#include "tests/benchmarks/report.h"

namespace cwm::benchmarks {

struct StoreBenchmarkOptions {
  std::string directory;        // stores are made in it; must lie on a disk
  std::string fault_directory;  // of the states of `./dev fault`
  std::string other_program;    // a cwm-server that `store_cost` is measured beside; may be empty
};

// The directory of stores beside this program, and that of `./dev fault` in the build.
StoreBenchmarkOptions DefaultStoreBenchmarkOptions();

// 16 writers of one world and of 16 worlds: durable_revisions_per_s_16,
// durable_revisions_per_s_16_worlds, durable_p99_ms.
void MeasureDurableWriters(const StoreBenchmarkOptions& options, Report& report);

// One writer, beside the same without a store and beside the disk: durable_overhead_ms.
void MeasureDurableOverhead(const StoreBenchmarkOptions& options, Report& report);

// A question and a publishing write without a store: store_cost_question_us,
// store_cost_publish_us; with `other_program` the figures of MeasureCostsBeside.
void MeasureStoreCost(const StoreBenchmarkOptions& options, Report& report);

// A store of 10,000 objects with 1 million triangles and 100,000 revisions of moves, restored from
// the disk by a new process (replay_main.cc): replay_s.
void MeasureReplay(const StoreBenchmarkOptions& options, Report& report);

// Counts of `./dev fault`, as far as it has run: kills, kills_lost, power_cuts, power_cuts_lost,
// violations.
void ReportFaults(const StoreBenchmarkOptions& options, Report& report);

// All of the above.
void MeasureStore(Report& report);

}  // namespace cwm::benchmarks
