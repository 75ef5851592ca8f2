// cwm sample
#include <algorithm>
#include <array>
#include <istream>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "absl/strings/str_cat.h"
#include "clients/cli/commands.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/pose_argument.h"
#include "clients/cli/quantity.h"
#include "clients/cli/query_arguments.h"
#include "clients/cli/table.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;
using Json = nlohmann::json;
using Point = std::array<double, 3>;

struct SampleArguments {
  std::vector<std::string> places;
  QueryArguments query;
};

// Parses {"point": [x, y, z]}.
bool ReadPoint(const Json& line, Point& point) {
  if (!line.is_object() || line.size() != 1 || !line.contains("point")) return false;
  const Json& list = line["point"];
  if (!list.is_array() || list.size() != point.size()) return false;
  for (std::size_t i = 0; i < point.size(); ++i) {
    if (!list[i].is_number()) return false;
    point[i] = list[i].get<double>();
  }
  return true;
}

absl::StatusOr<std::vector<Point>> PointsOnStdin(std::istream& in) {
  std::vector<Point> points;
  std::string text;
  for (int number = 1; std::getline(in, text); ++number) {
    if (text.find_first_not_of(" \t\r") == std::string::npos) continue;
    Point point{};
    if (!ReadPoint(Json::parse(text, nullptr, /*allow_exceptions=*/false), point)) {
      return absl::InvalidArgumentError(
          absl::StrCat("stdin line ", number, ": must be {\"point\": [x, y, z]}"));
    }
    points.push_back(point);
  }
  if (points.empty()) {
    return absl::InvalidArgumentError("stdin holds no point: one JSON object a line");
  }
  return points;
}

absl::StatusOr<std::vector<Point>> ReadPoints(const SampleArguments& arguments, Session& session) {
  if (arguments.places.empty()) {
    if (!session.streams.in_is_terminal) return PointsOnStdin(session.streams.in);
    return UsageError("points X,Y,Z, or JSON lines on stdin");
  }
  std::vector<Point> points;
  for (const std::string& place : arguments.places) {
    const auto at = ParsePoseArgument(session, place, "the point");
    if (!at.ok()) return at.status();
    points.push_back({(*at)[0], (*at)[1], (*at)[2]});
  }
  return points;
}

std::string StateName(const pb::SampleRow& row) {
  if (row.state() == pb::SAMPLE_STATE_KINK) return "kink";
  switch (row.trust()) {
    case pb::TRUST_BOUNDED:
      return absl::StrCat("up to ", FormatFixed(1000 * row.bound_m(), 3), " mm ",
                          row.distance_m() < 0 ? "deeper" : "nearer");
    case pb::TRUST_SURFACE_ONLY:
      return "surface only";
    case pb::TRUST_DEGRADED:
      return "deeper";
    default:
      return "";
  }
}

void PrintSamples(const pb::SamplePointsResponse& response, Session& session) {
  std::vector<TableRow> lines;
  for (const pb::SampleRow& row : response.rows()) {
    const std::string number = absl::StrCat(lines.size());
    if (row.state() == pb::SAMPLE_STATE_BEYOND) {
      lines.push_back({{number, "none", "", "", "", ""}});
      continue;
    }
    lines.push_back(
        {{number, HitObstacleName(row), absl::StrCat(row.object_part()),
          FormatFixed(1000 * row.distance_m(), 3), FormatVector(row.gradient()), StateName(row)}});
  }
  PrintTable({{"ROW", Align::kRight},
              {"OBJECT"},
              {"PART", Align::kRight},
              {"DISTANCE mm", Align::kRight},
              {"GRADIENT"},
              {"NOTE"}},
             lines, session.table_style(), session.streams.out);
}

absl::StatusOr<pb::SamplePointsResponse> Sample(Session& session, const std::vector<Point>& points,
                                                const pb::QueryOptions& options) {
  return EvaluateRows<pb::SamplePointsRequest, pb::SamplePointsResponse>(
      session, &pb::QueryService::Stub::SamplePoints, points, options,
      [](const std::vector<Point>& some, pb::SamplePointsRequest& request) {
        request.mutable_points()->set_scalar(pb::SCALAR_F64);
        request.mutable_points()->set_data(client::RowBytes(some));
      });
}

absl::Status SampleCommand(Session& session, const SampleArguments& arguments) {
  const auto options = ParseQueryOptions(arguments.query);
  if (!options.ok()) return options.status();
  const auto points = ReadPoints(arguments, session);
  if (!points.ok()) return points.status();
  const auto answer = Sample(session, *points, *options);
  if (!answer.ok()) return answer.status();
  PrintResult(session, *answer, points->size(), PrintSamples);
  return absl::OkStatus();
}

}  // namespace

void AddSampleCommand(CommandLine& line) {
  const auto arguments = std::make_shared<SampleArguments>();
  CLI::App& command =
      AddCommand(line,
                 {"sample",
                  "how far the world is from points (< 0: inside), and which way that grows",
                  {"cwm sample 0.4,0,0.3", "cwm sample 0.4,0,0.3 cup+0,0,0.1 -o json",
                   "echo '{\"point\": [0.4, 0, 0.3]}' | cwm sample -o ndjson"}},
                 [arguments](Session& session) { return SampleCommand(session, *arguments); });
  command.add_option("points", arguments->places, "points (m)")->type_name("X,Y,Z|NAME[+DX,DY,DZ]");
  AddQueryOptions(command, arguments->query);
}

}  // namespace cwm::cli
