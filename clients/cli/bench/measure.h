// Measures the duration of successive calls.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"

namespace cwm::cli {

struct MeasureOptions {
  double seconds = 2;  // of all repetitions together; the warm-up takes a tenth more
  std::int64_t rows_per_call = 1;
  std::function<bool()> stopped = {};  // checked between calls; empty: never
};

// chosen: the rate is the median of so many equally long repetitions, so that another busy program
// during one of them does not change it.
inline constexpr int kRepetitions = 5;

// derived: with so many calls one is the slowest in a hundred.
inline constexpr std::size_t kCallsForP99 = 100;

// Successive calls for some time.
struct Repetition {
  std::vector<double> call_s;  // of each call; not empty
  double elapsed_s = 0;        // of all calls together, > 0
};

struct Measurement {
  std::int64_t calls = 0;
  double elapsed_s = 0;
  double p50_ms = 0;             // of all calls
  std::optional<double> p99_ms;  // empty for fewer than kCallsForP99 calls
  double rows_per_s = 0;         // median of the repetitions
  double min_rows_per_s = 0;
  double max_rows_per_s = 0;
  double client_cpu = 0;  // processor seconds of this process per second; above 1: several threads
};

// The value below which a share of the values lies, by nearest rank. `values` must not be empty;
// share in (0, 1].
double Quantile(std::vector<double> values, double share);

// Leaves `client_cpu` at 0. Needs at least one repetition.
Measurement Summarize(const std::vector<Repetition>& repetitions, std::int64_t rows_per_call);

// Every repetition has at least one call. The first failed call ends it with its error; CANCELLED
// if it was stopped.
absl::StatusOr<Measurement> Measure(const std::function<absl::Status()>& call,
                                    const MeasureOptions& options);

}  // namespace cwm::cli
