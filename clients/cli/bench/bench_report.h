// The results of a benchmark, for people and for programs.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "clients/cli/bench/measure.h"
#include "clients/cli/table.h"
#include "cwm/v1/admin.pb.h"

namespace cwm::cli {

// A line of the table.
struct BenchLine {
  std::string name;    // "distances"
  std::string method;  // "unary", "stream", "upload"
  std::string unit;    // the unit of a row: "rows", "changes", "points"
  std::int64_t rows_per_call = 1;
  Measurement measured = {};
  // The share of a call's time that answering takes, measured against queries in empty space; empty
  // if not measured.
  std::optional<double> work_share = {};
};

struct BenchReport {
  std::string address;
  cwm::v1::GetServerInfoResponse server;
  std::string client_version;
  int cores = 1;               // of the machine that runs this program
  std::optional<double> load;  // of that machine, mean of the previous minute
  std::string world;           // the queried world
  bool is_own_world = true;    // created for the benchmark and removed afterwards
  std::int64_t object_count = 0;
  std::int64_t robot_count = 0;
  std::vector<BenchLine> lines;
};

// True for an address on this machine: a Unix socket or loopback, even if something forwards it.
bool IsLocal(const std::string& address);
// "Unix socket", "TCP over loopback" or "TCP".
std::string TransportOf(const std::string& address);

void PrintBench(const BenchReport& report, TableStyle style, std::ostream& out);
nlohmann::ordered_json BenchReportToJson(const BenchReport& report);
nlohmann::ordered_json BenchLineToJson(const BenchLine& line);

// One sentence about what limits the row rate of the stream; empty without such lines.
std::string BottleneckText(const BenchReport& report);

}  // namespace cwm::cli
