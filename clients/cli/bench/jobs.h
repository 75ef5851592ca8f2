// The measurements of a benchmark, each a line of its report.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cli/bench/bench_report.h"
#include "clients/cli/bench/measure.h"
#include "clients/cli/bench/questions.h"

namespace cwm::cli {

struct Job {
  BenchLine line;  // without what is measured
  std::function<absl::Status()> call;
  // The same asked of nothing; absent: no share of answering is told.
  std::function<absl::Status()> call_of_nothing = {};
};

// The Add functions keep references to the connection and the stream, which must outlive the jobs.

// What `ask` asks of the world, in unary calls and over the stream.
void AddQuestion(const client::Connection& connection, client::QueryStream& stream,
                 const AskedWorld& world, const std::function<Question(const AskedWorld&)>& ask,
                 std::vector<Job>& jobs);
// Moves the object to and fro, a revision each time.
void AddMoves(const client::Connection& connection, const std::string& world,
              const std::string& object, std::vector<Job>& jobs);
// Sends the same scan again and again, as a camera that stands still.
void AddIngests(const client::Connection& connection, const std::string& world,
                std::vector<Job>& jobs);

// What the job takes, warming up included.
double SecondsOf(const Job& job, double seconds);

absl::StatusOr<BenchLine> Run(const Job& job, MeasureOptions options);

}  // namespace cwm::cli
