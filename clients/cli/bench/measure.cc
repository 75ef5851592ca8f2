#include "clients/cli/bench/measure.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>

namespace cwm::cli {
namespace {

using Clock = std::chrono::steady_clock;

double Seconds(Clock::duration duration) { return std::chrono::duration<double>(duration).count(); }

double ProcessorSeconds() {
  timespec used = {};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used);
  return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
}

absl::StatusOr<Repetition> CallFor(double seconds, const std::function<absl::Status()>& call,
                                   const std::function<bool()>& stopped) {
  Repetition repetition;
  const Clock::time_point start = Clock::now();
  Clock::time_point sent = start;
  do {
    if (stopped && stopped()) return absl::CancelledError("interrupted");
    if (absl::Status status = call(); !status.ok()) return status;
    const Clock::time_point answered = Clock::now();
    repetition.call_s.push_back(Seconds(answered - sent));
    sent = answered;
  } while (Seconds(sent - start) < seconds);
  repetition.elapsed_s = Seconds(sent - start);
  return repetition;
}

}  // namespace

double Quantile(std::vector<double> values, double share) {
  const double rank = std::ceil(share * static_cast<double>(values.size()));
  const auto nth = static_cast<std::ptrdiff_t>(std::max(rank, 1.0)) - 1;
  std::nth_element(values.begin(), values.begin() + nth, values.end());
  return values[static_cast<std::size_t>(nth)];
}

Measurement Summarize(const std::vector<Repetition>& repetitions, std::int64_t rows_per_call) {
  Measurement measured;
  std::vector<double> calls_s, rates;
  for (const Repetition& repetition : repetitions) {
    calls_s.insert(calls_s.end(), repetition.call_s.begin(), repetition.call_s.end());
    measured.elapsed_s += repetition.elapsed_s;
    rates.push_back(static_cast<double>(rows_per_call) *
                    static_cast<double>(repetition.call_s.size()) / repetition.elapsed_s);
  }
  measured.calls = static_cast<std::int64_t>(calls_s.size());
  measured.p50_ms = 1e3 * Quantile(calls_s, 0.5);
  if (calls_s.size() >= kCallsForP99) measured.p99_ms = 1e3 * Quantile(calls_s, 0.99);
  measured.rows_per_s = Quantile(rates, 0.5);
  measured.min_rows_per_s = *std::min_element(rates.begin(), rates.end());
  measured.max_rows_per_s = *std::max_element(rates.begin(), rates.end());
  return measured;
}

absl::StatusOr<Measurement> Measure(const std::function<absl::Status()>& call,
                                    const MeasureOptions& options) {
  const auto warm = CallFor(options.seconds / 10, call, options.stopped);
  if (!warm.ok()) return warm.status();
  const double used_s = ProcessorSeconds();
  std::vector<Repetition> repetitions;
  for (int i = 0; i < kRepetitions; ++i) {
    auto repetition = CallFor(options.seconds / kRepetitions, call, options.stopped);
    if (!repetition.ok()) return repetition.status();
    repetitions.push_back(*std::move(repetition));
  }
  const double spent_s = ProcessorSeconds() - used_s;
  Measurement measured = Summarize(repetitions, options.rows_per_call);
  measured.client_cpu = spent_s / measured.elapsed_s;
  return measured;
}

}  // namespace cwm::cli
