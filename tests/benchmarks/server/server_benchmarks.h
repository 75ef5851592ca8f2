// The figures of `./dev bench server`: how much of the server one client can take from all others.
// Each starts its own cwm-servers, is bounded in time, and goes on if a server dies.
#pragma once

#include <string>

#include "tests/benchmarks/report.h"

namespace cwm::benchmarks {

// A table of hostile requests, one per line: amplification_bytes, amplification_cpu,
// amplification_over.
void MeasureAmplification(Report& report);
// Only those whose names match the regular expression.
void MeasureAmplificationOf(const std::string& pattern, Report& report);

// SIGTERM with a hundred idle clients and under load: stop_idle_clients_s, stop_load_s,
// stop_calls_unexplained.
void MeasureStops(Report& report);

// Small queries and batches beside a hostile crowd: overload_small_p99_ratio,
// overload_small_failed, overload_goodput, overload_batch_wait_s, overload_advice_ratio.
void MeasureOverload(Report& report);

// Answers to calls after 1 100 connections to a server with 1 024 descriptors were opened and
// closed: accept_after_emfile.
void MeasureListener(Report& report);

// The memory that a server gives back when its worlds are deleted: memory_returned.
void MeasureMemoryReturned(Report& report);

// All of the above.
void MeasureServer(Report& report);

// Queries and publishing beside another server program, in turn: question_us, batch_us,
// publish_call_us; the ratio is that of the processor time.
void MeasureCostsBeside(const std::string& other_program, Report& report);

// The figure with its limit in the place of an alternative's value.
Figure WithLimit(Figure figure, double limit, const std::string& kind = "limit, at most");

}  // namespace cwm::benchmarks
