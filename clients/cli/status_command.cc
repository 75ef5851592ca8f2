// cwm status, cwm info
#include <algorithm>
#include <nlohmann/json.hpp>
#include <ostream>

#include "absl/strings/str_cat.h"
#include "clients/cli/commands.h"
#include "clients/cli/message_json.h"
#include "clients/cli/natural_order.h"
#include "clients/cli/quantity.h"
#include "clients/cli/table.h"
#include "clients/cpp/call_error.h"
#include "grpc/health/v1/health.grpc.pb.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;
using OrderedJson = nlohmann::ordered_json;

// "SERVING", "NOT_SERVING", or "UNKNOWN" from a server without health checking.
absl::StatusOr<std::string> Health(Session& session) {
  namespace health = grpc::health::v1;
  const auto stub = health::Health::NewStub(session.connection().channel());
  const auto answer =
      session.connection().Call(&health::Health::Stub::Check, *stub, health::HealthCheckRequest());
  if (absl::IsUnimplemented(answer.status())) return "UNKNOWN";
  if (!answer.ok()) return answer.status();
  return health::HealthCheckResponse::ServingStatus_Name(answer->status());
}

bool IsReplaying(const absl::Status& status) {
  return client::DetailsOf(status).reason == "STORE_REPLAYING";
}

void PrintStore(const pb::GetServerInfoResponse& info, std::ostream& out) {
  out << "store   " << info.store();
  if (!info.has_store_info()) {
    out << ": worlds end with the server\n";
    return;
  }
  const pb::StoreInfo& store = info.store_info();
  if (store.replayed() < 1) {
    out << ": restoring worlds, " << FormatFixed(100 * store.replayed(), 0) << " % done\n";
    return;
  }
  out << "  " << FormatBytes(static_cast<double>(store.bytes())) << ", " << store.record_count()
      << " records beside snapshots, " << store.blob_count() << " blobs; opened " << store.epoch()
      << (store.epoch() == 1 ? " time" : " times") << ", restored in "
      << FormatFixed(store.replay_seconds(), 1) << " s\n";
  if (!store.refuses_writes().empty()) out << "refuses writes: " << store.refuses_writes() << "\n";
}

void PrintServer(const std::string& health, const pb::GetServerInfoResponse& info,
                 Session& session) {
  std::ostream& out = session.streams.out;
  out << "server  " << session.connection().address() << "  " << health << "  version "
      << info.version() << ", up " << FormatFixed(info.uptime_s(), 0) << " s\n";
  PrintStore(info, out);
}

void PrintWorlds(const pb::ListWorldsResponse& worlds, Session& session) {
  std::ostream& out = session.streams.out;
  if (worlds.worlds().empty()) {
    out << "no worlds yet: `cwm ingest scan.pcd` makes one\n";
    return;
  }
  std::vector<TableRow> rows;
  for (const pb::World& world : worlds.worlds()) {
    rows.push_back({{world.name(), absl::StrCat(world.revision()),
                     absl::StrCat(world.object_count()), world.world_uid()}});
  }
  std::stable_sort(rows.begin(), rows.end(), [](const TableRow& a, const TableRow& b) {
    return NaturalLess(a.cells[0], b.cells[0]);
  });
  PrintTable({{"WORLD"}, {"REVISION", Align::kRight}, {"OBJECTS", Align::kRight}, {"UID"}}, rows,
             session.table_style(), out);
}

absl::Status Status(Session& session) {
  const client::Connection& connection = session.connection();
  const auto health = Health(session);
  if (!health.ok()) return health.status();
  const auto info = connection.Call(&pb::AdminService::Stub::GetServerInfo, connection.admin(),
                                    pb::GetServerInfoRequest());
  if (!info.ok()) return info.status();
  const auto worlds = connection.Call(&pb::WorldService::Stub::ListWorlds, connection.worlds(),
                                      pb::ListWorldsRequest());
  if (!worlds.ok() && !IsReplaying(worlds.status())) return worlds.status();
  if (session.form == OutputForm::kTable) {
    PrintServer(*health, *info, session);
    if (worlds.ok()) PrintWorlds(*worlds, session);
    return worlds.status();
  }
  // Combines three replies into one object.
  OrderedJson json = {{"address", connection.address()}, {"health", *health}};
  json["server_info"] = OrderedJson::parse(ToJson(*info, JsonStyle::kOneLine));
  if (worlds.ok()) {
    json["worlds"] = OrderedJson::parse(ToJson(*worlds, JsonStyle::kOneLine))["worlds"];
  }
  session.streams.out << json.dump(session.form == OutputForm::kJson ? 1 : -1) << "\n";
  return worlds.status();
}

void PrintInfo(const pb::GetServerInfoResponse& info, Session& session) {
  std::ostream& out = session.streams.out;
  out << "version " << info.version() << ", store " << info.store() << ", up "
      << FormatFixed(info.uptime_s(), 0) << " s\n\n";
  std::vector<TableRow> rows;
  for (const pb::EngineInfo& engine : info.engines()) {
    rows.push_back({{engine.name(), engine.version()}});
  }
  PrintTable({{"ENGINE"}, {"VERSION"}}, rows, session.table_style(), out);
  const pb::Limits& limits = info.limits();
  const pb::Retention& retention = info.retention();
  const auto bytes = [](std::int64_t size) { return FormatBytes(static_cast<double>(size)); };
  out << "\n";
  PrintTable({{"LIMIT"}, {"VALUE", Align::kRight}},
             {{{"message", bytes(limits.max_message_bytes())}},
              {{"chunk", bytes(limits.max_chunk_bytes())}},
              {{"cloud points", absl::StrCat(limits.max_cloud_points())}},
              {{"mesh triangles", absl::StrCat(limits.max_mesh_triangles())}},
              {{"rows in a batch", absl::StrCat(limits.max_batch_rows())}},
              {{"rows as messages", absl::StrCat(limits.max_rows_as_messages())}},
              {{"watchers", absl::StrCat(limits.max_watchers())}},
              {{"streams", absl::StrCat(limits.max_streams())}},
              {{"memory", bytes(limits.max_memory_bytes())}},
              {{"memory of worlds", bytes(limits.max_world_memory_bytes())}},
              {{"objects of a world", absl::StrCat(limits.max_objects())}},
              {{"metadata", bytes(limits.max_metadata_bytes())}},
              {{"exact snapshots kept", absl::StrCat(retention.exact_snapshots())}},
              {{"watch events kept", absl::StrCat(retention.watch_events())}},
              {{"watch events kept for", FormatFixed(retention.watch_seconds(), 0) + " s"}},
              {{"request ids kept for", FormatFixed(retention.request_id_seconds(), 0) + " s"}}},
             session.table_style(), out);
}

absl::Status Info(Session& session) {
  const client::Connection& connection = session.connection();
  const auto info = connection.Call(&pb::AdminService::Stub::GetServerInfo, connection.admin(),
                                    pb::GetServerInfoRequest());
  if (!info.ok()) return info.status();
  session.Print(*info, [&] { PrintInfo(*info, session); });
  return absl::OkStatus();
}

}  // namespace

void AddStatusCommands(CommandLine& line) {
  AddCommand(line,
             {"status",
              "whether the server serves, its store and its worlds",
              {"cwm status", "cwm status --addr localhost:50051 -o json"}},
             Status);
  AddCommand(line, {"info", "versions, engines, limits and retention of the server", {"cwm info"}},
             Info);
}

}  // namespace cwm::cli
