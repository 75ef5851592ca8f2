// The measurements of a benchmark, one per line of its report.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cli/bench/bench_queries.h"
#include "clients/cli/bench/bench_report.h"
#include "clients/cli/bench/measure.h"

namespace cwm::cli {

struct Job {
  BenchLine line;  // without the measurements
  std::function<absl::Status()> call;
  // The same query in empty space; empty: the share of answering is not reported.
  std::function<absl::Status()> empty_space_call = {};
};

// The Add functions keep references to the connection and the stream, which must outlive the jobs.

// Measures the query made by `make_query`, in unary calls and over the stream.
void AddQuery(const client::Connection& connection, client::QueryStream& stream,
              const QueriedWorld& world,
              const std::function<BenchQuery(const QueriedWorld&)>& make_query,
              std::vector<Job>& jobs);
// Moves the object to and fro, with a revision each time.
void AddMoves(const client::Connection& connection, const std::string& world,
              const std::string& object, std::vector<Job>& jobs);
// Sends the same scan repeatedly, like a camera that does not move.
void AddIngests(const client::Connection& connection, const std::string& world,
                std::vector<Job>& jobs);

// The duration of the job, including the warm-up.
double DurationOf_s(const Job& job, double seconds);

absl::StatusOr<BenchLine> RunJob(const Job& job, MeasureOptions options);

}  // namespace cwm::cli
