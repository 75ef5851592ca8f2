// cwm check
#include <algorithm>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "clients/cli/commands.h"
#include "clients/cli/enum_names.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/query_arguments.h"
#include "clients/cli/table.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

// Empty for exact verdicts, so that the table shows only what limits one.
std::string TrustText(const pb::CollisionRow& row) {
  const bool is_plain = row.trust() == pb::TRUST_EXACT || row.trust() == pb::TRUST_UNSPECIFIED;
  return is_plain ? "" : ShortName(row.trust());
}

void WarnOfOpenMeshes(const pb::CheckCollisionsResponse& response, Session& session) {
  const bool is_doubted = std::ranges::any_of(response.rows(), [](const pb::CollisionRow& row) {
    return row.verdict() == pb::VERDICT_FREE && row.trust() == pb::TRUST_SURFACE_ONLY;
  });
  if (!is_doubted) return;
  session.Warn(
      "an open mesh is near, a surface without an inside: free says that nothing touches it, also "
      "of what is within it");
}

void PrintVerdicts(const pb::CheckCollisionsResponse& response, Session& session) {
  std::vector<TableRow> lines;
  for (const pb::CollisionRow& row : response.rows()) {
    lines.push_back({{absl::StrCat(lines.size()), ShortName(row.verdict()), row.variable(),
                      ObstacleName(row), row.object_link(),
                      row.has_object_part() ? absl::StrCat(row.object_part()) : "", BodyName(row),
                      row.has_body_part() ? absl::StrCat(row.body_part()) : "", TrustText(row)}});
  }
  PrintTable({{"ROW", Align::kRight},
              {"VERDICT"},
              {"OUT OF LIMITS"},
              {"OBJECT"},
              {"OBJECT LINK"},
              {"OBJECT PART", Align::kRight},
              {"BODY LINK"},
              {"BODY PART", Align::kRight},
              {"TRUST"}},
             lines, session.table_style(), session.streams.out);
}

ExitCode CodeOf(pb::Verdict verdict) {
  if (verdict == pb::VERDICT_COLLISION) return ExitCode::kCollision;
  return verdict == pb::VERDICT_FREE ? ExitCode::kDone : ExitCode::kNotFree;
}

absl::Status Check(Session& session, const VerdictArguments& arguments) {
  const auto options = ParseQueryOptions(arguments.query);
  if (!options.ok()) return options.status();
  const auto batches = ReadBatches(arguments.body, session);
  if (!batches.ok()) return batches.status();
  const auto answer = EvaluateBatches<pb::CheckCollisionsRequest, pb::CheckCollisionsResponse>(
      session, &pb::QueryService::Stub::CheckCollisions, *batches, *options);
  if (!answer.ok()) return answer.status();
  if (arguments.exit_code) {
    session.verdict_code = ExitCodeOfRows(*answer, RowCount(*batches), CodeOf);
  }
  WarnOfOpenMeshes(*answer, session);
  PrintResult(session, *answer, RowCount(*batches), PrintVerdicts);
  return absl::OkStatus();
}

}  // namespace

void AddCheckCommand(CommandLine& line) {
  const auto arguments = std::make_shared<VerdictArguments>();
  CLI::App& command = AddCommand(
      line,
      {"check",
       "whether a body or a robot is in collision: a verdict for each pose or state",
       {"cwm check --box 0.1,0.08,0.2 --at 0.4,0,0.3 --margin 0.01",
        "cwm check --object mug --at 0.5,0.1,0.2 --exit-code && echo free",
        "cwm check --robot panda --group panda_arm --joints 0,-0.8,0,-2.4,0,1.6,0.8",
        "cwm check --robot panda --joints ready --scope self",
        "cwm check --sphere 0.05 --at - -o ndjson < poses.jsonl"},
       "Collision means that the distance is less than the margin; a robot is also told where "
       "it is out of\n"
       "its limits, and is asked about the world and itself. Many questions: JSON "
       "lines on stdin,\n"
       "see `cwm distance --help`."},
      [arguments](Session& session) { return Check(session, *arguments); });
  AddVerdictOptions(command, *arguments);
}

}  // namespace cwm::cli
