// Stamped states of robots that move, and the state of a robot at a stamp.
#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/world/world_robot.h"
#include "collision/world/world_snapshot.h"
#include "perception/live/frame_evidence.h"
#include "perception/live/robot_view.h"
#include "server/core/limits.h"

namespace cwm::server {

// The told variables of a robot at a time of the system clock.
struct StampedRobotState {
  perception::Stamp stamp = {};
  std::vector<double> values = {};  // one for each told variable, rad or m
  std::optional<Pose> X_WB = {};    // absent: the base is not told
};

// The state of a robot at a stamp.
struct RobotStateAt {
  perception::StateSource source = perception::StateSource::kMissing;
  // Set if the state is missing: ROBOT_STATE_STALE if the states around the stamp are too old or
  // too far apart, ROBOT_STATE_MISSING if there are none as old as the stamp, or none at all.
  std::string reason = {};
  // By how much the stamp is later than the newest state: 0 if interpolated. Set also if missing,
  // unless there is no state at all.
  std::chrono::nanoseconds late = {};
  // Empty if the state is missing. Variables that nobody tells have the robot's present values.
  std::vector<double> values = {};        // one for each variable of the model, rad or m
  std::vector<double> speeds_per_s = {};  // of the values
  Pose X_WB = Pose::Identity();
  perception::SpatialVelocity V_WB = {};
};

// The poses and velocities of the links at the stamp. The state must not be missing.
std::vector<perception::LinkAtStamp> LinksAt(const collision::RobotModel& model,
                                             const RobotStateAt& state);

// The robots of one world whose states are told. Streams that tell different variables of a robot
// are kept apart; one that tells a variable of an earlier stream takes its place. Thread safe; its
// lock is a leaf.
class RobotStates {
 public:
  // chosen: sensors lag by up to 0.2 s, and a state each 4 ms fills both limits.
  static constexpr std::chrono::seconds kKeptTime{2};
  static constexpr std::size_t kMaxCount = 512;  // of one robot and stream
  // chosen: clocks that are not synchronised at all are told.
  static constexpr std::chrono::seconds kMaxFuture{1};
  // chosen: at 1 m/s and 10 m/s^2 a link is 2 mm from its extrapolated place.
  static constexpr std::chrono::milliseconds kMaxExtrapolation{20};
  // chosen: a robot may turn around in between two states that are farther apart.
  static constexpr std::chrono::milliseconds kMaxGap{200};
  // chosen: a stream that was silent for so long no longer tells its variables, and its stamps may
  // begin anew.
  static constexpr std::chrono::seconds kSilentTime{10};
  // chosen: how often the newest states become those of the world without frames, and for how long
  // after a frame they are left to the next one.
  static constexpr std::chrono::milliseconds kPublishPeriod{33};
  static constexpr std::chrono::milliseconds kLeftToFrames{200};

  struct Added {
    int taken = 0;
    int ignored = 0;  // of stamps that are known, or older than all that are kept
  };
  // Takes all states, in any order of their stamps, or none. `variables` are indices of the robot's
  // model. A robot that replaced another one of its name begins without states. InvalidArgument for
  // "states.stamps[i]" more than kMaxFuture after `now` or kKeptTime before the newest, and for
  // "states.rows" of another width.
  absl::StatusOr<Added> Add(const collision::WorldRobot& robot, std::span<const int> variables,
                            std::span<const StampedRobotState> states, perception::Stamp now);

  // Interpolates between the two states around the stamp, linearly, continuous joints by the
  // shorter way. A later stamp is extrapolated for at most kMaxExtrapolation; if a single state is
  // known, it is held for so long.
  RobotStateAt StateAt(const collision::WorldRobot& robot, perception::Stamp stamp) const;
  // True if states of the robot were told within kSilentTime before the stamp.
  bool IsTold(const collision::WorldRobot& robot, perception::Stamp stamp) const;

  // True if states of a robot come, and none for this stamp or later has come yet: the next one is
  // about to.
  bool Awaits(perception::Stamp stamp) const;

  // The robot was removed or replaced.
  void Forget(const std::string& robot);

  // A frame's write is about to take the states: none is due for a while. False if it would find
  // none.
  bool LeaveToFrame(Clock::time_point now);
  // A write without a frame is about to take them: true once in kPublishPeriod, not before DueAt.
  bool ClaimDue(Clock::time_point now);
  // The newest states that were not taken yet, as changes of the world. Call only under the
  // writer's turn (World::MakeChanges): a later write then never has an older state.
  std::vector<collision::SetRobotState> TakeAll();
  // Leaves out states of robots that the world does not have.
  static std::vector<collision::Change> ChangesOf(std::span<const collision::SetRobotState> states,
                                                  const collision::WorldSnapshot& world);
  // When a write without a frame may claim the states; empty if all were taken.
  std::optional<Clock::time_point> DueAt() const;

 private:
  // The states of one stream, in the order of their stamps.
  struct Track {
    std::vector<int> variables = {};
    std::deque<StampedRobotState> states = {};  // never empty after an Add
    perception::Stamp arrived = {};             // when the last ones came
    bool is_taken = true;                       // the newest one
  };
  struct Robot {
    collision::Revision create_revision = {};
    std::shared_ptr<const collision::RobotGeometry> robot = {};
    std::vector<Track> tracks = {};
  };

  const Robot* Find(const collision::WorldRobot& robot) const;
  static Track& TrackOf(Robot& robot, std::span<const int> variables);
  bool HasUntaken() const;
  Clock::time_point NextWrite() const;

  mutable std::mutex mutex_;
  std::map<std::string, Robot, std::less<>> robots_;
  Clock::time_point frame_took_ = {};
  Clock::time_point write_claimed_ = {};
};

}  // namespace cwm::server
