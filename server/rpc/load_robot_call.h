// One upload of a robot: header, files in chunks, finish, then the work.
#pragma once

#include <grpcpp/grpcpp.h>

#include <map>
#include <optional>
#include <stop_token>
#include <string>

#include "cwm/v1/robot.grpc.pb.h"
#include "proto/transfer/sha256.h"
#include "server/rpc/call.h"
#include "server/rpc/received.h"
#include "server/rpc/upload.h"
#include "server/wire/robot_header.h"

namespace cwm::server {

// Deletes itself when gRPC is done with it. Reads happen one at a time; once the last has come, the
// task of the robots' queue owns the call.
class LoadRobotCall final : public grpc::ServerReadReactor<Received<v1::LoadRobotRequest>> {
 public:
  LoadRobotCall(grpc::CallbackServerContext* context, Runtime& runtime,
                v1::LoadRobotResponse* response);

 private:
  void OnReadDone(bool ok) override;
  void OnCancel() override { stop_.request_stop(); }
  void OnDone() override { delete this; }

  absl::Status Take(const Received<v1::LoadRobotRequest>& received);
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

  Runtime& runtime_;
  v1::LoadRobotResponse* const response_;
  std::stop_source stop_;
  const CallContext call_;  // its stop is stop_'s
  Received<v1::LoadRobotRequest> message_;
  std::optional<RobotPlan> plan_;                     // once the header came
  std::map<std::string, Upload, std::less<>> files_;  // by name
  Upload* current_ = nullptr;                         // of the file that was begun last
  std::int64_t total_bytes_ = 0;                      // of all files that were begun
  Sha256 received_;        // of all that came but the request_id: a retry has the same
  bool finished_ = false;  // the finish message came
};

}  // namespace cwm::server
