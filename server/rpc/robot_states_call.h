// A stream of a robot's states: header, then rows of stamped states until the client ends it.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <utility>

#include "cwm/v1/robot.pb.h"
#include "server/core/watch.h"
#include "server/core/world.h"
#include "server/rpc/upload_call.h"

namespace cwm::server {

// Makes the newest states of a world's robots those of the world, thirty times a second, unless
// frames of sensors do (RobotStates::ClaimDue). Thread safe.
class RobotStatePublication : public std::enable_shared_from_this<RobotStatePublication> {
 public:
  RobotStatePublication(Runtime& runtime, std::shared_ptr<World> world, ClientId client)
      : runtime_(runtime), world_(std::move(world)), client_(client) {}

  // Publishes what is due, now or as soon as it is. Waits for nothing.
  void Schedule();

 private:
  void Push();
  void Publish();

  Runtime& runtime_;
  const std::shared_ptr<World> world_;
  const ClientId client_;
  std::atomic<bool> is_scheduled_ = false;
};

// States are taken as they come.
class RobotStatesCall final
    : public UploadCall<v1::StreamRobotStatesRequest, v1::StreamRobotStatesResponse> {
 public:
  using UploadCall::UploadCall;

 private:
  absl::Status Take(const v1::StreamRobotStatesRequest& message) override;
  absl::Status TakeHeader(const v1::RobotStatesHeader& header);
  absl::Status TakeStates(const v1::RobotStateRows& states);
  absl::Status CheckEnd() const override;
  absl::Status Work() override;
  WorkQueue& Queue() override { return runtime_.writes; }
  double Cost_s() const override { return 0; }

  // Ends the call if the robot or its world is gone. Called by writers whenever the world changes.
  void EndIfGone();
  absl::Status CheckRobot() const;

  // Set by the header.
  std::shared_ptr<World> world_;
  collision::WorldRobotPtr robot_;  // as it was then
  collision::JointGroup told_;
  std::unique_ptr<WatchCursor> changes_;  // calls EndIfGone
  std::shared_ptr<RobotStatePublication> publication_;

  std::int64_t taken_count_ = 0;
  std::int64_t ignored_count_ = 0;
};

}  // namespace cwm::server
