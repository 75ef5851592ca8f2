// One upload of a robot: header, files in chunks, finish, then the work.
#pragma once

#include <grpcpp/grpcpp.h>

#include <map>
#include <optional>
#include <string>

#include "cwm/v1/robot.grpc.pb.h"
#include "proto/transfer/sha256.h"
#include "server/rpc/upload.h"
#include "server/rpc/upload_call.h"
#include "server/wire/robot_header.h"

namespace cwm::server {

// The work is the robots' queue's.
class LoadRobotCall final : public UploadCall<v1::LoadRobotRequest> {
 public:
  LoadRobotCall(grpc::CallbackServerContext* context, Runtime& runtime,
                v1::LoadRobotResponse* response);

 private:
  void OnMessage(bool ok) override;

  absl::Status Take(const v1::LoadRobotRequest& message);
  absl::Status TakeHeader(const v1::LoadRobotHeader& header);
  absl::Status TakeFile(const v1::RobotFile& file);
  absl::Status TakeChunk(const v1::RobotFileChunk& chunk);
  absl::Status TakeFinish();
  absl::Status CheckFileComplete(const FieldPath& path) const;
  absl::Status CheckEnd() const;
  void Enqueue();
  absl::Status Work();
  absl::StatusOr<collision::PutRobot> MakePut();
  absl::Status Reply(const World& world, const WriteOutcome& outcome, const std::string& name);

  v1::LoadRobotResponse* const response_;
  const CallContext call_;                            // its stop is stop_'s
  std::optional<RobotPlan> plan_;                     // once the header came
  std::map<std::string, Upload, std::less<>> files_;  // by name
  Upload* current_ = nullptr;                         // of the file that was begun last
  std::int64_t total_bytes_ = 0;                      // of all files that were begun
  Sha256 received_;        // of all that came but the request_id: a retry has the same
  bool finished_ = false;  // the finish message came
};

}  // namespace cwm::server
