#include "clients/cli/bench/bench_report.h"

#include <algorithm>
#include <cmath>
#include <ostream>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "clients/cli/quantity.h"

namespace cwm::cli {
namespace {

using OrderedJson = nlohmann::ordered_json;

// Formats 1234567 as "1 234 567".
std::string Grouped(double value) {
  std::string digits = FormatFixed(value, value < 10 && value != std::floor(value) ? 1 : 0);
  const std::size_t end = std::min(digits.find('.'), digits.size());
  for (std::size_t k = 3; k < end; k += 3) digits.insert(end - k, " ");
  return digits;
}

// Milliseconds with a useful number of decimals.
std::string Milliseconds(double time_ms) {
  return FormatFixed(time_ms, time_ms < 1 ? 3 : time_ms < 100 ? 2 : 0);
}

std::string Spread(const Measurement& measured) {
  return absl::StrCat(
      FormatFixed(100 * (measured.max_rows_per_s - measured.min_rows_per_s) / measured.rows_per_s,
                  0),
      " %");
}

void PrintHead(const BenchReport& report, std::ostream& out) {
  const bool is_local = IsLocal(report.address);
  out << "server  " << report.address << " (" << TransportOf(report.address) << "), version "
      << report.server.version() << ", up " << FormatFixed(report.server.uptime_s(), 0) << " s\n";
  out << "client  version " << report.client_version << ", " << report.cores
      << (report.cores == 1 ? " core" : " cores")
      << (is_local ? ", shared with the server unless something forwards the address"
                   : "; those of the server are not known");
  if (report.load) out << ", load " << FormatFixed(*report.load, 1) << " before it began";
  out << "\n";
  out << "world   ";
  if (report.is_own_world) {
    out << "one of its own, removed again: " << report.object_count << " shapes";
  } else {
    out << "\"" << report.world << "\" as it is: " << report.object_count
        << (report.object_count == 1 ? " object, " : " objects, ") << report.robot_count
        << (report.robot_count == 1 ? " robot" : " robots");
  }
  out << "\n\n";
}

}  // namespace

std::string TransportOf(const std::string& address) {
  if (absl::StartsWith(address, "unix:")) return "Unix socket";
  return IsLocal(address) ? "TCP over loopback" : "TCP";
}

bool IsLocal(const std::string& address) {
  return absl::StartsWith(address, "unix:") || absl::StartsWith(address, "localhost:") ||
         absl::StartsWith(address, "127.") || absl::StartsWith(address, "[::1]:");
}

std::string BottleneckText(const BenchReport& report) {
  std::vector<std::string> work;
  double client_cpu = 0;
  for (const BenchLine& line : report.lines) {
    if (!line.work_share || line.rows_per_call == 1) continue;
    work.push_back(absl::StrCat(line.name, " ", FormatFixed(100 * *line.work_share, 0), " %"));
    client_cpu = std::max(client_cpu, line.measured.client_cpu);
  }
  if (work.empty()) return "";
  return absl::StrCat("Of the time of a batch over a stream the server works on its answers: ",
                      absl::StrJoin(work, ", "),
                      ".\nThe rest is its messages: packed, carried and read on both sides. This "
                      "client used up to ",
                      FormatFixed(100 * client_cpu, 0), " % of one core meanwhile.");
}

void PrintBench(const BenchReport& report, TableStyle style, std::ostream& out) {
  PrintHead(report, out);
  std::vector<TableRow> rows;
  for (const BenchLine& line : report.lines) {
    const Measurement& measured = line.measured;
    rows.push_back(
        {{line.name, line.method, Grouped(static_cast<double>(line.rows_per_call)),
          Grouped(static_cast<double>(measured.calls)), FormatFixed(measured.elapsed_s, 1),
          Milliseconds(measured.p50_ms), measured.p99_ms ? Milliseconds(*measured.p99_ms) : "",
          absl::StrCat(Grouped(measured.rows_per_s), " ", line.unit), Spread(measured),
          line.work_share ? FormatFixed(100 * *line.work_share, 0) + " %" : ""}});
  }
  PrintTable({{"QUESTION"},
              {"THROUGH"},
              {"ROWS A CALL", Align::kRight},
              {"CALLS", Align::kRight},
              {"SECONDS", Align::kRight},
              {"p50 ms", Align::kRight},
              {"p99 ms", Align::kRight},
              {"EACH SECOND", Align::kRight},
              {"SPREAD", Align::kRight},
              {"ANSWERING", Align::kRight}},
             rows, style, out);
  if (const std::string bottleneck = BottleneckText(report); !bottleneck.empty())
    out << "\n" << bottleneck << "\n";
}

OrderedJson BenchLineToJson(const BenchLine& line) {
  const Measurement& measured = line.measured;
  OrderedJson json = {{"of", line.name},
                      {"through", line.method},
                      {"unit", line.unit},
                      {"rows_per_call", line.rows_per_call},
                      {"calls", measured.calls},
                      {"elapsed_s", measured.elapsed_s},
                      {"repetitions", kRepetitions},
                      {"p50_ms", measured.p50_ms}};
  if (measured.p99_ms) json["p99_ms"] = *measured.p99_ms;
  json["rows_per_s"] = measured.rows_per_s;
  json["least_rows_per_s"] = measured.min_rows_per_s;
  json["most_rows_per_s"] = measured.max_rows_per_s;
  json["client_cpu"] = measured.client_cpu;
  if (line.work_share) json["work_share"] = *line.work_share;
  return json;
}

OrderedJson BenchReportToJson(const BenchReport& report) {
  OrderedJson json = {{"address", report.address},
                      {"transport", TransportOf(report.address)},
                      {"is_local_address", IsLocal(report.address)},
                      {"server_version", report.server.version()},
                      {"server_uptime_s", report.server.uptime_s()},
                      {"client_version", report.client_version},
                      {"client_cores", report.cores}};
  if (report.load) json["client_load"] = *report.load;
  json["world"] = report.world;
  json["is_own_world"] = report.is_own_world;
  json["object_count"] = report.object_count;
  json["robot_count"] = report.robot_count;
  json["measurements"] = OrderedJson::array();
  for (const BenchLine& line : report.lines) json["measurements"].push_back(BenchLineToJson(line));
  return json;
}

}  // namespace cwm::cli
