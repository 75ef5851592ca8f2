// cwm motion
#include <algorithm>
#include <memory>
#include <vector>

#include "absl/strings/str_cat.h"
#include "clients/cli/commands.h"
#include "clients/cli/enum_names.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/quantity.h"
#include "clients/cli/query_arguments.h"
#include "clients/cli/table.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

absl::Status TooShort(int row_count) {
  return UsageError(absl::StrCat(
      "a motion leads through ", row_count, row_count == 1 ? " place" : " places",
      ", must be at least 2: give --at or --joints twice or more, or lines with several"));
}

// Requests of whole paths, each with as many paths as a message may have.
absl::StatusOr<std::vector<pb::CheckMotionsRequest>> ToRequests(const std::vector<Body>& bodies) {
  std::vector<pb::CheckMotionsRequest> requests;
  for (const Body& body : bodies) {
    std::size_t begin = 0, end = 0;
    pb::CheckMotionsRequest request;
    const auto finish = [&] {
      if (begin == end) return;
      *request.mutable_subject() = SubjectOf(body, begin, end);
      requests.push_back(request);
      request.Clear();
      begin = end;
    };
    for (const int row_count : body.row_counts) {
      if (row_count < 2) return TooShort(row_count);
      const std::size_t next = end + static_cast<std::size_t>(row_count);
      const bool is_full =
          static_cast<std::size_t>(request.path_row_counts_size()) == kMaxMessageRows;
      if (is_full || next - begin > kMaxRows) finish();
      request.add_path_row_counts(row_count);
      end = next;
    }
    finish();
  }
  return requests;
}

std::size_t MotionCount(const std::vector<Body>& bodies) {
  std::size_t count = 0;
  for (const Body& body : bodies) count += body.row_counts.size();
  return count;
}

absl::StatusOr<pb::CheckMotionsResponse> EvaluateMotions(
    Session& session, const std::vector<pb::CheckMotionsRequest>& requests,
    const pb::QueryOptions& options) {
  return EvaluateInTurn<pb::CheckMotionsRequest, pb::CheckMotionsResponse>(
      session, &pb::QueryService::Stub::CheckMotions, requests.size(), options,
      [&](std::size_t i, pb::CheckMotionsRequest& request) {
        request.MergeFrom(requests[i]);
        return request.path_row_counts_size();
      },
      [](const pb::CheckMotionsResponse& all, pb::CheckMotionsResponse& answer) {
        if (all.completed_count() > 0) {  // rows have their own names
          answer.clear_body_links();
          answer.clear_body_objects();
        }
        return absl::OkStatus();
      });
}

void PrintMotions(const pb::CheckMotionsResponse& response, Session& session) {
  std::vector<TableRow> lines;
  for (const pb::MotionRow& row : response.rows()) {
    lines.push_back(
        {{absl::StrCat(lines.size()), ShortName(row.verdict()), row.variable(),
          row.has_clearance_m() ? FormatFixed(1000 * row.clearance_m(), 3) : "",
          row.has_segment() ? absl::StrCat(row.segment()) : "",
          row.has_lo() ? FormatFixed(row.lo(), 5) : "",
          row.has_hi() ? FormatFixed(row.hi(), 5) : "", ObstacleName(row), row.object_link(),
          row.has_object_part() ? absl::StrCat(row.object_part()) : "", BodyName(row),
          row.has_body_part() ? absl::StrCat(row.body_part()) : "", ShortName(row.trust())}});
  }
  PrintTable({{"MOTION", Align::kRight},
              {"VERDICT"},
              {"OUT OF LIMITS"},
              {"CLEARANCE mm", Align::kRight},
              {"SEGMENT", Align::kRight},
              {"FREE TO", Align::kRight},
              {"MET AT", Align::kRight},
              {"OBJECT"},
              {"OBJECT LINK"},
              {"OBJECT PART", Align::kRight},
              {"BODY LINK"},
              {"BODY PART", Align::kRight},
              {"TRUST"}},
             lines, session.table_style(), session.streams.out);
}

ExitCode CodeOf(pb::MotionVerdict verdict) {
  if (verdict == pb::MOTION_VERDICT_CONTACT) return ExitCode::kCollision;
  return verdict == pb::MOTION_VERDICT_FREE ? ExitCode::kDone : ExitCode::kNotFree;
}

absl::Status Move(Session& session, const VerdictArguments& arguments) {
  const auto options = ParseQueryOptions(arguments.query);
  if (!options.ok()) return options.status();
  const auto bodies = ReadBodies(arguments.body, session);
  if (!bodies.ok()) return bodies.status();
  const auto requests = ToRequests(*bodies);
  if (!requests.ok()) return requests.status();
  const auto answer = EvaluateMotions(session, *requests, *options);
  if (!answer.ok()) return answer.status();
  if (arguments.exit_code) {
    session.verdict_code = ExitCodeOfRows(*answer, MotionCount(*bodies), CodeOf);
  }
  PrintResult(session, *answer, MotionCount(*bodies), PrintMotions, "motion");
  return absl::OkStatus();
}

}  // namespace

void AddMotionCommand(CommandLine& line) {
  const auto arguments = std::make_shared<VerdictArguments>();
  CLI::App& command = AddCommand(
      line,
      {"motion",
       "whether a body or a robot meets anything on its way: certified, never sampled",
       {"cwm motion --box 0.1,0.08,0.2 --at 0.4,0,0.5 --at 0.4,0.3,0.2",
        "cwm motion --object mug --at 0.5,0.1,0.2 --at 0.5,0.1,0.4 --exit-code && echo free",
        "cwm motion --robot panda --group panda_arm --joints ready --joints "
        "0.5,-0.8,0,-2.4,0,1.6,0.8",
        "cwm motion --robot panda --joints - -o ndjson < paths.jsonl"},
       "The places given make one path: joints move linearly (continuous ones the short way), "
       "poses linearly\n"
       "with the rotation by slerp. The first contact tells: the body is free to a share of the "
       "segment, and\n"
       "in contact at the other. JSON lines on stdin are a motion each: {\"sphere\": 0.1, \"at\": "
       "[[..], [..]]},\n"
       "{\"robot\": \"panda\", \"joints\": [[..], [..], [..]]}, or with a body on the command "
       "line the rows alone."},
      [arguments](Session& session) { return Move(session, *arguments); });
  AddVerdictOptions(command, *arguments);
}

}  // namespace cwm::cli
