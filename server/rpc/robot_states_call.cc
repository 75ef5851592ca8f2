#include "server/rpc/robot_states_call.h"

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "collision/xml/xml_element.h"
#include "server/core/error.h"
#include "server/core/live/robot_states.h"
#include "server/core/world_feed.h"
#include "server/wire/objects.h"
#include "server/wire/robot_states.h"

namespace cwm::server {
namespace {

// chosen: eight times as many as are kept, so that a client may send what it recorded meanwhile.
constexpr std::int64_t kMaxRows = 4'096;

const WriteHooks kWriteHooks{.durability = Durability::kObserved};

// Takes states under the writer's turn. What an attempt took that found no memory is part of the
// next one.
World::MakeChanges TakeStatesOf(World& world) {
  return [&world, taken = std::vector<collision::SetRobotState>()](
             const SnapshotPtr& latest) mutable -> absl::StatusOr<std::vector<collision::Change>> {
    std::ranges::move(world.robot_states().TakeAll(), std::back_inserter(taken));
    return RobotStates::ChangesOf(taken, *latest);
  };
}

// The robot that the header named is not in the world, or no longer.
absl::Status NoSuchRobot(const std::string& name) {
  return MakeError(
      absl::StatusCode::kNotFound,
      absl::StrCat("header.robot: there is no robot ", collision::Quoted(name), " in this world"),
      {.reason = "ROBOT_UNKNOWN", .metadata = {{"robot", name}}});
}

}  // namespace

void RobotStatePublication::Schedule() {
  const auto due = world_->robot_states().DueAt();
  if (!due.has_value() || world_->is_deleted() || is_scheduled_.exchange(true)) return;
  const Clock::duration delay = *due - Clock::now();
  if (delay <= Clock::duration::zero()) return Push();
  runtime_.timer.After(delay, [self = shared_from_this()] { self->Push(); });
}

// One of all streams of the world gets to write.
void RobotStatePublication::Push() {
  if (!world_->robot_states().ClaimDue(Clock::now())) {
    is_scheduled_ = false;
    return Schedule();
  }
  runtime_.writes.Push({.run =
                            [self = shared_from_this()](const absl::Status& admitted) {
                              self->is_scheduled_ = false;
                              if (admitted.ok()) self->Publish();
                              self->Schedule();
                            },
                        .client = client_,
                        .cost_s = 0,
                        .deadline = Clock::time_point::max()});
}

// The end of a stream needs no answer from this write, which precedes its own.
void RobotStatePublication::Publish() {
  world_->StartUpdate(TakeStatesOf(*world_), {}, kWriteHooks, [](const auto&) {});
}

absl::Status RobotStatesCall::Take(const v1::StreamRobotStatesRequest& message) {
  switch (message.what_case()) {
    case v1::StreamRobotStatesRequest::kHeader:
      return TakeHeader(message.header());
    case v1::StreamRobotStatesRequest::kStates:
      return TakeStates(message.states());
    case v1::StreamRobotStatesRequest::WHAT_NOT_SET:
      break;
  }
  return InvalidField("what", "is absent, must be one of header, states");
}

absl::Status RobotStatesCall::TakeHeader(const v1::RobotStatesHeader& header) {
  if (robot_ != nullptr) return InvalidField("header", "came twice, must come once");
  const FieldPath path = FieldPath::OfRequest("header");
  if (auto status = CheckName(header.robot(), path.Field("robot")); !status.ok()) return status;
  auto world = runtime_.application.worlds.Find(header.world(), header.world_uid());
  if (!world.ok()) return world.status();
  const SnapshotPtr snapshot = (*world)->Snapshot();
  collision::WorldRobotPtr robot = snapshot->FindRobot(header.robot());
  if (robot == nullptr) return NoSuchRobot(header.robot());
  auto told = ToldVariablesFromProto(header, robot->model(), path);
  if (!told.ok()) return told.status();
  world_ = *std::move(world);
  told_ = *std::move(told);
  robot_ = std::move(robot);
  publication_ = std::make_shared<RobotStatePublication>(runtime_, world_, call_.client);
  const auto wake = [weak = weak_from_this()] {
    const auto call = std::static_pointer_cast<RobotStatesCall>(weak.lock());
    if (call != nullptr) call->EndIfGone();
  };
  auto changes = world_->Watch({.from_revision = snapshot->revision()}, wake);
  if (!changes.ok()) return changes.status();
  changes_ = *std::move(changes);
  return CheckRobot();  // it may have gone before the watch began
}

absl::Status RobotStatesCall::CheckRobot() const {
  if (world_->is_deleted()) return WorldDeleted();
  const collision::WorldRobotPtr present = world_->Snapshot()->FindRobot(robot_->name);
  if (present == nullptr) return NoSuchRobot(robot_->name);
  if (present->IsSameAs(*robot_)) return absl::OkStatus();
  return MakeError(absl::StatusCode::kNotFound,
                   absl::StrCat("header.robot: ", collision::Quoted(robot_->name),
                                " was replaced by another one of its name, begin a new stream"),
                   {.reason = "ROBOT_UNKNOWN", .metadata = {{"robot", robot_->name}}});
}

void RobotStatesCall::EndIfGone() {
  if (absl::Status there = CheckRobot(); !there.ok()) End(std::move(there));
}

absl::Status RobotStatesCall::TakeStates(const v1::RobotStateRows& states) {
  if (robot_ == nullptr)
    return InvalidField("states", "came before the header, must come after it");
  if (absl::Status there = CheckRobot(); !there.ok()) return there;
  const collision::WorldRobotPtr present = world_->Snapshot()->FindRobot(robot_->name);
  if (present == nullptr) return NoSuchRobot(robot_->name);
  const auto stamped =
      StampedStatesFromProto(states, present, told_, kMaxRows, FieldPath::OfRequest("states"));
  if (!stamped.ok()) return stamped.status();
  const auto added = world_->robot_states().Add(*robot_, told_.variables, *stamped,
                                                std::chrono::system_clock::now());
  if (!added.ok()) return added.status();
  taken_count_ += added->taken;
  ignored_count_ += added->ignored;
  publication_->Schedule();
  return absl::OkStatus();
}

absl::Status RobotStatesCall::CheckEnd() const {
  return robot_ != nullptr ? absl::OkStatus()
                           : InvalidField("header", "is absent, must come first");
}

absl::Status RobotStatesCall::Work() {
  if (absl::Status there = CheckRobot(); !there.ok()) return there;
  // Even with nothing left to take: what another write took is visible before the answer.
  const auto written = world_->Update(TakeStatesOf(*world_), {}, kWriteHooks);
  if (!written.ok()) return written.status();
  response_.set_world_uid(world_->uid());
  response_.set_revision(written->revision.value);
  response_.set_state_count(taken_count_);
  response_.set_ignored_count(ignored_count_);
  return absl::OkStatus();
}

}  // namespace cwm::server
