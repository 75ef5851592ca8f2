// The upload of a robot: header, files in chunks, finish, then the work.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "cwm/v1/robot.pb.h"
#include "proto/transfer/sha256.h"
#include "server/rpc/upload.h"
#include "server/rpc/upload_call.h"
#include "server/wire/robot_header.h"

namespace cwm::server {

class LoadRobotCall final : public UploadCall<v1::LoadRobotRequest, v1::LoadRobotResponse> {
 public:
  using UploadCall::UploadCall;

 private:
  absl::Status Take(const v1::LoadRobotRequest& message) override;
  absl::Status TakeHeader(const v1::LoadRobotHeader& header);
  absl::Status TakeFile(const v1::RobotFile& file);
  absl::Status TakeChunk(const v1::RobotFileChunk& chunk);
  absl::Status TakeFinish();
  absl::Status CheckFileComplete(const FieldPath& path) const;
  absl::Status CheckEnd() const override;
  absl::Status Work() override;
  WorkQueue& Queue() override { return runtime_.robots; }
  double Cost_s() const override;
  absl::StatusOr<collision::PutRobot> MakePut();
  absl::Status Reply(const World& world, const WriteOutcome& outcome, const std::string& name);

  std::optional<RobotPlan> plan_;                     // set by the header
  MemoryCharge header_;                               // for the plan's texts
  std::map<std::string, Upload, std::less<>> files_;  // by name
  Upload* current_ = nullptr;                         // of the file that was begun last
  std::int64_t total_bytes_ = 0;                      // of all files that were begun
  Sha256 received_;        // of all received data but the request_id: the same for a retry
  bool finished_ = false;  // the finish message was received
};

}  // namespace cwm::server
