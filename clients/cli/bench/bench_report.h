// What a benchmark found, for people and for programs.
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
  std::string of;       // "distances"
  std::string through;  // "unary", "stream", "upload"
  std::string unit;     // of a row: "rows", "changes", "points"
  std::int64_t rows_per_call = 1;
  Measurement measured = {};
  // The share of the time that the same rows cost beyond the same rows asked of nothing; absent
  // where that was not asked.
  std::optional<double> work_share = {};
};

struct BenchReport {
  std::string address;
  cwm::v1::GetServerInfoResponse server;
  std::string client_version;
  int cores = 1;               // of the machine that this program runs on
  std::optional<double> load;  // of that machine, mean of the minute before
  std::string world;           // that was asked
  bool is_own_world = true;    // made for this and removed again
  std::int64_t object_count = 0;
  std::int64_t robot_count = 0;
  std::vector<BenchLine> lines;
};

// "Unix socket" or "TCP over loopback": this machine, which client and server share; "TCP": which
// machine answers is not known.
std::string TransportOf(const std::string& address);
bool IsThisMachine(const std::string& address);

void PrintBench(const BenchReport& report, TableStyle style, std::ostream& out);
nlohmann::ordered_json ToJson(const BenchReport& report);
nlohmann::ordered_json ToJson(const BenchLine& line);

// What keeps the rows of a stream from coming faster, in a sentence; empty without such lines.
std::string Limits(const BenchReport& report);

}  // namespace cwm::cli
