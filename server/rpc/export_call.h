// Exports a world as a file of another tool, in chunks.
#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cwm/v1/world.grpc.pb.h"
#include "server/export/planning_scene.h"
#include "server/rpc/chunked_read.h"
#include "server/rpc/exported_worlds.h"

namespace cwm::server {

class ExportWorldCall final : public ChunkedRead<v1::ExportWorldResponse> {
 public:
  ExportWorldCall(grpc::CallbackServerContext* context, Runtime& runtime,
                  const grpc::ByteBuffer* request);

 private:
  absl::Status Prepare(const CallContext& call) override;
  void ReleaseBytes() override;
  void Complete(v1::ExportWorldResponse& message) override;

  // Makes the file: sets text, warnings and, if there are several files, their names.
  absl::Status Format(const collision::WorldSnapshot& snapshot, const std::string& world,
                      const CancellationCheck& check_cancelled);
  absl::Status FormatScene(const collision::WorldSnapshot& snapshot, PlanningScene scene,
                           const CancellationCheck& check_cancelled);
  absl::Status FormatDrawing(const collision::WorldSnapshot& snapshot, const std::string& world,
                             const CancellationCheck& check_cancelled);
  absl::Status FormatModel(PlanningScene scene, const CancellationCheck& check_cancelled);

  v1::ExportWorldRequest request_;
  std::optional<QuotaShare> quota_share_;  // in the quota of streams
  std::shared_ptr<const ExportedWorld> file_;
  // Used while the file is made.
  std::string text_;
  std::vector<std::string> warnings_;
  std::vector<ExportedWorld::Part> named_;
};

}  // namespace cwm::server
