// How long calls take, one after another.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"

namespace cwm::cli {

struct MeasureOptions {
  double seconds = 2;  // of measuring, all repetitions together; a tenth more warms up before
  std::int64_t rows_per_call = 1;
  std::function<bool()> stopped = {};  // asked between calls; absent: never
};

// The median of so many equally long stretches is the rate: one in which another program was busy
// does not move it.
inline constexpr int kRepetitions = 5;

// So many calls have one slowest in a hundred.
inline constexpr std::size_t kCallsForP99 = 100;

// Calls one after another for a while.
struct Repetition {
  std::vector<double> call_s;  // not empty, of each call
  double elapsed_s = 0;        // of all, > 0
};

struct Measurement {
  std::int64_t calls = 0;
  double elapsed_s = 0;
  double p50_ms = 0;             // of all calls
  std::optional<double> p99_ms;  // absent below kCallsForP99 calls
  double rows_per_s = 0;         // median of the repetitions
  double least_rows_per_s = 0;
  double most_rows_per_s = 0;
  double client_cpu =
      0;  // seconds of processor time of this process a second; above 1: several threads
};

// The value below which a share of the values lies, by the nearest rank. Not empty; share in (0, 1].
double Quantile(std::vector<double> values, double share);

// `client_cpu` is left at 0. At least one repetition.
Measurement Summarize(const std::vector<Repetition>& repetitions, std::int64_t rows_per_call);

// Every repetition has at least one call. The first error of a call ends it; CANCELLED when it was
// stopped.
absl::StatusOr<Measurement> Measure(const std::function<absl::Status()>& call,
                                    const MeasureOptions& options);

}  // namespace cwm::cli
