#include "clients/cpp/world_export.h"

#include "absl/strings/str_cat.h"

namespace cwm::client {

namespace pb = cwm::v1;

absl::StatusOr<ExportedWorld> ExportWorld(const Connection& connection,
                                          const pb::ExportWorldRequest& request) {
  grpc::ClientContext context;
  connection.Prepare(context);
  const auto reader = connection.worlds().ExportWorld(&context, request);
  ExportedWorld exported;
  pb::ExportWorldResponse chunk;
  while (reader->Read(&chunk)) exported.bytes += chunk.data();
  if (const grpc::Status status = reader->Finish(); !status.ok()) return FromGrpc(status);
  if (!chunk.done() || static_cast<std::int64_t>(exported.bytes.size()) != chunk.total_bytes()) {
    return absl::DataLossError(absl::StrCat("the export has ", chunk.total_bytes(), " bytes, ",
                                            exported.bytes.size(), " arrived"));
  }
  exported.world_uid = chunk.world_uid();
  exported.revision = chunk.revision();
  exported.warnings.assign(chunk.warnings().begin(), chunk.warnings().end());
  return exported;
}

}  // namespace cwm::client
