// cwm ray
#include <algorithm>
#include <istream>
#include <memory>
#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"
#include "clients/cli/commands.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/number_list.h"
#include "clients/cli/pose_argument.h"
#include "clients/cli/quantity.h"
#include "clients/cli/query_arguments.h"
#include "clients/cli/table.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;
using Json = nlohmann::json;

struct RayArguments {
  std::string from, direction, to;
  QueryArguments query;
};

absl::StatusOr<client::RayRow> ParseRay(const RayArguments& arguments, Session& session) {
  if (arguments.from.empty() || arguments.direction.empty() == arguments.to.empty()) {
    return UsageError("--from and one of --direction and --to, or JSON lines on stdin");
  }
  const auto from = ParsePoseArgument(session, arguments.from, "--from");
  if (!from.ok()) return from.status();
  client::RayRow ray = {(*from)[0], (*from)[1], (*from)[2], 0, 0, 0};
  if (!arguments.direction.empty()) {
    const auto direction = ParseNumbers(arguments.direction, {"--direction", "x,y,z", 3});
    if (!direction.ok()) return direction.status();
    std::copy(direction->begin(), direction->end(), ray.begin() + 3);
    return ray;
  }
  const auto to = ParsePoseArgument(session, arguments.to, "--to");
  if (!to.ok()) return to.status();
  for (std::size_t i = 0; i < 3; ++i) ray[i + 3] = (*to)[i] - (*from)[i];
  return ray;
}

// Reads "from" or "direction" of a line: three numbers.
bool ReadVector(const Json& line, const char* name, double* values) {
  if (!line.is_object() || !line.contains(name)) return false;
  const Json& list = line[name];
  if (!list.is_array() || list.size() != 3) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!list[i].is_number()) return false;
    values[i] = list[i].get<double>();
  }
  return true;
}

absl::StatusOr<std::vector<client::RayRow>> RaysOnStdin(std::istream& in) {
  std::vector<client::RayRow> rays;
  std::string text;
  for (int number = 1; std::getline(in, text); ++number) {
    if (text.find_first_not_of(" \t\r") == std::string::npos) continue;
    const Json line = Json::parse(text, nullptr, /*allow_exceptions=*/false);
    client::RayRow ray{};
    const bool good = ReadVector(line, "from", ray.data()) &&
                      ReadVector(line, "direction", ray.data() + 3) && line.size() == 2;
    if (!good) {
      return absl::InvalidArgumentError(absl::StrCat(
          "stdin line ", number, ": must be {\"from\": [x, y, z], \"direction\": [x, y, z]}"));
    }
    rays.push_back(ray);
  }
  if (rays.empty()) return absl::InvalidArgumentError("stdin holds no ray: one JSON object a line");
  return rays;
}

absl::StatusOr<std::vector<client::RayRow>> ReadRays(const RayArguments& arguments,
                                                     Session& session) {
  const Streams& streams = session.streams;
  const bool on_the_line =
      !arguments.from.empty() || !arguments.direction.empty() || !arguments.to.empty();
  if (!on_the_line && !streams.in_is_terminal) return RaysOnStdin(streams.in);
  const auto ray = ParseRay(arguments, session);
  if (!ray.ok()) return ray.status();
  return std::vector<client::RayRow>{*ray};
}

void PrintHits(const pb::CastRaysResponse& response, Session& session) {
  std::vector<TableRow> lines;
  for (const pb::RayRow& row : response.rows()) {
    const std::string number = absl::StrCat(lines.size());
    if (!row.hit()) {
      lines.push_back({{number, "none", "", "", "", ""}});
      continue;
    }
    lines.push_back({{number, HitObstacleName(row), absl::StrCat(row.object_part()),
                      FormatFixed(1000 * row.distance_m(), 3), FormatVector(row.point()),
                      FormatVector(row.normal())}});
  }
  PrintTable({{"ROW", Align::kRight},
              {"OBJECT"},
              {"PART", Align::kRight},
              {"DISTANCE mm", Align::kRight},
              {"POINT m"},
              {"NORMAL"}},
             lines, session.table_style(), session.streams.out);
}

absl::StatusOr<pb::CastRaysResponse> Cast(Session& session, const std::vector<client::RayRow>& rays,
                                          const pb::QueryOptions& options) {
  return EvaluateRows<pb::CastRaysRequest, pb::CastRaysResponse>(
      session, &pb::QueryService::Stub::CastRays, rays, options,
      [](const std::vector<client::RayRow>& some, pb::CastRaysRequest& request) {
        request.mutable_rays()->set_scalar(pb::SCALAR_F64);
        request.mutable_rays()->set_data(client::RowBytes(some));
      });
}

absl::Status RayCommand(Session& session, const RayArguments& arguments) {
  const auto options = ParseQueryOptions(arguments.query);
  if (!options.ok()) return options.status();
  const auto rays = ReadRays(arguments, session);
  if (!rays.ok()) return rays.status();
  const auto answer = Cast(session, *rays, *options);
  if (!answer.ok()) return answer.status();
  PrintResult(session, *answer, rays->size(), PrintHits);
  return absl::OkStatus();
}

}  // namespace

void AddRayCommand(CommandLine& line) {
  const auto arguments = std::make_shared<RayArguments>();
  CLI::App& command = AddCommand(
      line,
      {"ray",
       "what a ray hits first, where, and the outward normal there",
       {"cwm ray --from 0.4,0,1 --direction 0,0,-1", "cwm ray --from 0,0,1 --to 0.4,0,0 -o json",
        "echo '{\"from\": [0,0,1], \"direction\": [0,0,-1]}' | cwm ray -o ndjson"}},
      [arguments](Session& session) { return RayCommand(session, *arguments); });
  command.add_option("--from", arguments->from, "origin (m)")->type_name("X,Y,Z|NAME[+DX,DY,DZ]");
  command.add_option("--direction", arguments->direction, "direction, any length")
      ->type_name("X,Y,Z");
  command.add_option("--to", arguments->to, "a point that the ray goes through (m)")
      ->type_name("X,Y,Z");
  AddQueryOptions(command, arguments->query);
}

}  // namespace cwm::cli
