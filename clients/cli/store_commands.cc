// cwm restore, cwm store check, stat
#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>
#include <string>

#include "absl/strings/str_cat.h"
#include "clients/cli/commands.h"
#include "clients/cli/quantity.h"
#include "clients/cli/table.h"
#include "clients/cpp/call_error.h"
#include "server/core/error.h"
#include "server/store/sqlite/store_directory.h"

namespace cwm::cli {
namespace {

using server::StoreReport;
using OrderedJson = nlohmann::ordered_json;

struct RestoreArguments {
  std::string from, to;
};

// The same error with its details as those of a server's reply.
absl::Status ClientStatus(const absl::Status& status) {
  server::ErrorDetails details = server::DetailsOf(status);
  return client::MakeStatus(status.code(), std::string(status.message()),
                            {.reason = std::move(details.reason),
                             .fields = {},
                             .metadata = std::move(details.metadata),
                             .retry_after_s = details.retry_after_s});
}

OrderedJson JsonOf(const StoreReport& report) {
  return {{"store_uid", report.store_uid},
          {"version", report.version},
          {"epoch", report.epoch},
          {"last_sequence", report.last_sequence},
          {"world_count", report.world_count},
          {"record_count", report.record_count},
          {"record_bytes", report.record_bytes},
          {"snapshot_count", report.snapshot_count},
          {"snapshot_bytes", report.snapshot_bytes},
          {"blob_count", report.blob_count},
          {"blob_bytes", report.blob_bytes},
          {"unused_blob_count", report.unused_blob_count},
          {"missing_blob_count", report.missing_blob_count},
          {"database_bytes", report.database_bytes},
          {"log_bytes", report.log_bytes},
          {"was_closed", report.was_closed},
          {"faults", report.faults},
          {"fault_count", report.fault_count}};
}

// A count and the bytes of what is counted.
std::string Counted(std::int64_t count, std::int64_t bytes) {
  return absl::StrCat(count, ", ", FormatBytes(static_cast<double>(bytes)));
}

void PrintReport(const StoreReport& report, Session& session) {
  const auto bytes = [](std::int64_t size) { return FormatBytes(static_cast<double>(size)); };
  PrintTable({{"STORE"}, {report.store_uid, Align::kRight}},
             {{{"worlds", absl::StrCat(report.world_count)}},
              {{"snapshots", Counted(report.snapshot_count, report.snapshot_bytes)}},
              {{"records beside snapshots", Counted(report.record_count, report.record_bytes)}},
              {{"newest record", absl::StrCat(report.last_sequence)}},
              {{"blobs", Counted(report.blob_count, report.blob_bytes)}},
              {{"blobs without use", absl::StrCat(report.unused_blob_count)}},
              {{"blobs that are missing", absl::StrCat(report.missing_blob_count)}},
              {{"database", bytes(report.database_bytes)}},
              {{"log", bytes(report.log_bytes)}},
              {{"version", absl::StrCat(report.version)}},
              {{"opened by servers", absl::StrCat(report.epoch)}},
              {{"closed",
                report.was_closed ? "yes" : "no: the server was killed or the machine went down"}}},
             session.table_style(), session.streams.out);
}

absl::Status FaultOf(const StoreReport& report, const std::string& path) {
  if (report.fault_count == 0) return absl::OkStatus();
  return client::MakeStatus(
      absl::StatusCode::kDataLoss,
      absl::StrCat(path, ": ", report.fault_count, report.fault_count == 1 ? " fault" : " faults"),
      {.reason = "STORE_DAMAGED", .fields = {}, .metadata = {}, .retry_after_s = {}});
}

// Prints the report; an error if the store is damaged.
absl::Status Tell(Session& session, const std::string& path,
                  const absl::StatusOr<StoreReport>& report) {
  if (!report.ok()) return ClientStatus(report.status());
  std::ostream& out = session.streams.out;
  if (session.form == OutputForm::kTable) {
    PrintReport(*report, session);
    for (const std::string& fault : report->faults) out << "fault: " << fault << "\n";
  } else {
    out << JsonOf(*report).dump(session.form == OutputForm::kJson ? 1 : -1) << "\n";
  }
  return FaultOf(*report, path);
}

absl::Status Restore(Session& session, const RestoreArguments& arguments) {
  const auto report = server::RestoreStore(arguments.from, arguments.to);
  if (!report.ok()) return ClientStatus(report.status());
  if (session.form != OutputForm::kTable) return Tell(session, arguments.to, report);
  session.streams.out << "restored " << report->world_count
                      << (report->world_count == 1 ? " world" : " worlds") << " to " << arguments.to
                      << "; newest record " << report->last_sequence << "\n";
  return absl::OkStatus();
}

void AddRestoreCommand(CommandLine& line) {
  const auto arguments = std::make_shared<RestoreArguments>();
  CLI::App& command =
      AddCommand(line,
                 {"restore",
                  "a store for a server, made of a backup",
                  {"cwm restore /srv/backups/monday /var/lib/cwm",
                   "cwm restore /srv/backups/monday /tmp/monday && cwm-server --store "
                   "sqlite:/tmp/monday"},
                  "All of the copy is checked. No server is asked: PATH must be new or empty, and "
                  "afterwards\nbelong to the user that the server runs as."},
                 [arguments](Session& session) { return Restore(session, *arguments); });
  command.add_option("DIR", arguments->from, "what `cwm backup` has made")->required();
  command.add_option("PATH", arguments->to, "the directory of the new store")->required();
}

using Inspect = absl::StatusOr<StoreReport> (*)(const std::string&);

void AddInspectCommand(CommandLine& line, CLI::App& family, const CommandText& text,
                       Inspect inspect) {
  const auto path = std::make_shared<std::string>();
  CLI::App& command = AddCommand(line, family, text, [path, inspect](Session& session) {
    return Tell(session, *path, inspect(*path));
  });
  command.add_option("PATH", *path, "the directory of the store, without sqlite:")->required();
}

}  // namespace

void AddStoreCommands(CommandLine& line) {
  AddRestoreCommand(line);
  CLI::App& family =
      AddFamily(line, {"store",
                       "a store that no server has open: check, stat",
                       {"cwm store check /var/lib/cwm", "cwm store stat /var/lib/cwm"}});
  AddInspectCommand(line, family,
                    {"check",
                     "reads all of a store or a backup, and names what is damaged",
                     {"cwm store check /var/lib/cwm", "cwm store check /srv/backups/monday"},
                     "Changes nothing. Exit code 70 if anything is damaged."},
                    &server::CheckStore);
  AddInspectCommand(line, family,
                    {"stat",
                     "what a store or a backup holds, without reading its blobs",
                     {"cwm store stat /var/lib/cwm", "cwm store stat /var/lib/cwm -o json"}},
                    &server::StatStore);
}

}  // namespace cwm::cli
