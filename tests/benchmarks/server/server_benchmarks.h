// The figures of `./dev bench server`: what one client can take from all others. Each starts
// cwm-servers of its own, is bounded in time, and goes on where a server dies.
#pragma once

#include <string>

#include "tests/benchmarks/report.h"

namespace cwm::benchmarks {

// A table of hostile requests, one a line: amplification_bytes, amplification_cpu,
// amplification_over.
void MeasureAmplification(Report& report);
// Those alone whose names match the regular expression.
void MeasureAmplificationOf(const std::string& pattern, Report& report);

// SIGTERM with a hundred idle clients and under load: stop_idle_clients_s, stop_load_s,
// stop_calls_unexplained.
void MeasureStops(Report& report);

// Small questions and batches beside a hostile crowd: overload_small_p99_ratio,
// overload_small_failed, overload_goodput, overload_batch_wait_s, overload_advice_ratio.
void MeasureOverload(Report& report);

// Whether calls are answered after 1 100 connections to a server with 1 024 descriptors have come
// and gone: accept_after_emfile.
void MeasureListener(Report& report);

// What a server gives back when its worlds are deleted: memory_returned.
void MeasureMemoryReturned(Report& report);

// All of the above.
void MeasureServer(Report& report);

// Questions and publishing beside another server program, in turn: question_us, batch_us,
// publish_call_us; the ratio is that of the processor time.
void MeasureCostsBeside(const std::string& other_program, Report& report);

// The figure with its limit in the place of a rival's value.
Figure WithLimit(Figure figure, double limit, const std::string& kind = "limit, at most");

}  // namespace cwm::benchmarks
