#include "clients/cli/error_report.h"

#include <map>
#include <ostream>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/quantity.h"
#include "clients/cpp/call_error.h"

namespace cwm::cli {
namespace {

std::string Category(const absl::Status& status, const client::ErrorDetails& details) {
  if (IsUsageError(status)) return "usage";
  if (absl::StartsWith(details.reason, "STORE_")) return "store";
  static const std::map<absl::StatusCode, std::string> kCategories = {
      {absl::StatusCode::kUnavailable, "server unavailable"},
      {absl::StatusCode::kNotFound, "not found"},
      {absl::StatusCode::kAborted, "revision conflict"},
      {absl::StatusCode::kFailedPrecondition, "revision conflict"},
      {absl::StatusCode::kOutOfRange, "out of range"},
      {absl::StatusCode::kDeadlineExceeded, "deadline exceeded"},
      {absl::StatusCode::kCancelled, "cancelled"},
      {absl::StatusCode::kPermissionDenied, "permission denied"},
      {absl::StatusCode::kUnauthenticated, "not authenticated"},
      {absl::StatusCode::kResourceExhausted, "server is at its limit"},
      {absl::StatusCode::kInvalidArgument, "bad input"},
      {absl::StatusCode::kUnimplemented, "not offered by this server"},
  };
  const auto found = kCategories.find(status.code());
  return found == kCategories.end() ? absl::StatusCodeToString(status.code()) : found->second;
}

std::string HintForReason(const std::string& reason) {
  static const std::map<std::string, std::string> kHints = {
      {"WORLD_UNKNOWN",
       "`cwm status` lists the worlds; ingest, put, import and robot load create one"},
      {"OBJECT_UNKNOWN", "`cwm objects` lists the names"},
      {"ROBOT_UNKNOWN", "`cwm robot list` lists the names"},
      {"NO_SPHERES", "`cwm robot load URDF --spheres FILE` gives it a sphere model"},
      {"GEOMETRY_UNKNOWN", "`cwm get NAME -o json` shows the hashes of an object"},
      {"REVISION_MISMATCH", "`cwm status` shows the present revision; read, decide, try again"},
      {"OBJECT_REVISION_MISMATCH", "`cwm get NAME` shows the object as it is now"},
      {"REVISION_COMPACTED", "that revision is no longer kept: start from the latest"},
      {"REVISION_IN_FUTURE", "`cwm status` shows the present revision"},
      {"REQUEST_ID_REUSED", "use a new --request-id for a new change"},
      {"SCAN_CONTRADICTS_WORLD", "`cwm ingest --force` takes it all the same"},
      {"BACKUP_UNDER_WAY", "each copy takes as much room as the store, so one is made at a time"},
      {"DISK_FULL", "make room on the disk of the store: writes are accepted again by themselves"},
      {"STORE_DAMAGED", "`cwm restore DIR PATH` makes a new store of a backup; docs/durability.md"},
      {"STORE_IN_MEMORY", "`cwm-server --store sqlite:PATH` keeps worlds across restarts"},
      {"STORE_LOCKED", "a server has it open: `cwm status` and `cwm backup DIR` ask that server"},
      {"STORE_REPLAYING", "`cwm status` shows how far it is"},
      {"WORLD_REPLACED", "the world was deleted and made anew: start from its present state"},
  };
  const auto found = kHints.find(reason);
  return found == kHints.end() ? "" : found->second;
}

// The message without a remedy in words of the API: the hint has that of the command line.
std::string WithoutRemedy(const absl::Status& status, const client::ErrorDetails& details) {
  const std::string message(status.message());
  return details.reason == "SCAN_CONTRADICTS_WORLD" ? message.substr(0, message.rfind(';'))
                                                    : message;
}

std::string Hint(const absl::Status& status, const client::ErrorDetails& details,
                 const FailedCommand& command) {
  if (command.suggestion) return absl::StrCat("did you mean ", *command.suggestion, "?");
  if (const std::string hint = HintForReason(details.reason); !hint.empty()) return hint;
  switch (status.code()) {
    case absl::StatusCode::kUnavailable:
      return absl::StrCat("tried ", command.address,
                          "; start `cwm-server`, or name another with --addr or CWM_ADDR");
    case absl::StatusCode::kDeadlineExceeded:
      return "allow more time with --deadline SECONDS, or send fewer rows";
    case absl::StatusCode::kInvalidArgument:
      if (command.program != "cwm") {
        return absl::StrCat("`", command.program, " --help` shows examples and units");
      }
      return command.name.empty()
                 ? "`cwm --help` lists the commands"
                 : absl::StrCat("`cwm ", command.name, " --help` shows examples and units");
    default:
      return "";
  }
}

}  // namespace

void ReportError(const absl::Status& status, const FailedCommand& command, std::ostream& err) {
  const client::ErrorDetails details = client::DetailsOf(status);
  err << command.program << ": " << Category(status, details) << ": "
      << WithoutRemedy(status, details) << "\n";
  for (const auto& [field, description] : details.fields) {
    const std::string line = absl::StrCat(field, ": ", description);
    if (line != status.message()) err << "  " << line << "\n";
  }
  if (!details.reason.empty()) {
    err << "  reason: " << details.reason;
    for (const auto& [key, value] : details.metadata) err << ", " << key << " " << value;
    err << "\n";
  }
  if (details.retry_after_s) {
    err << "  retry after " << FormatFixed(*details.retry_after_s, 2) << " s\n";
  }
  const std::string hint = Hint(status, details, command);
  if (!hint.empty()) err << "hint: " << hint << "\n";
}

}  // namespace cwm::cli
