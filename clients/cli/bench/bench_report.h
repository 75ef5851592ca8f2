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
  // Of the time of a call, what it saves to ask where nothing is; absent where that was not measured.
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

// Of this machine: a Unix socket or loopback. Whether something forwards it elsewhere cannot be told.
bool IsLocal(const std::string& address);
// "Unix socket", "TCP over loopback" or "TCP".
std::string TransportOf(const std::string& address);

void PrintBench(const BenchReport& report, TableStyle style, std::ostream& out);
nlohmann::ordered_json ToJson(const BenchReport& report);
nlohmann::ordered_json ToJson(const BenchLine& line);

// What keeps the rows of a stream from coming faster, in a sentence; empty without such lines.
std::string Limits(const BenchReport& report);

}  // namespace cwm::cli
