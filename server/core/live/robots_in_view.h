// The robots of a world at the stamp of a frame, and the pixels that show them.
#pragma once

#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "perception/live/robot_view.h"
#include "server/core/live/body_table.h"
#include "server/core/live/robot_states.h"

namespace cwm::server {

// The shapes that images of a robot need, made once for its geometry.
struct RobotShape {
  std::shared_ptr<const perception::RobotSurface> surface;
  std::shared_ptr<const perception::LinkTree> tree;
  perception::ReachSphere reach_B;  // in the root link's frame
};

// Thread safe. Forgets robots that are gone. The shapes of a robot that is new take up to a second:
// they are made on a thread of their own, so that no frame waits for them.
class RobotShapes {
 public:
  // Null while they are being made.
  std::shared_ptr<const RobotShape> Of(
      const std::shared_ptr<const collision::RobotGeometry>& robot);

 private:
  struct Entry {
    std::weak_ptr<const collision::RobotGeometry> robot;
    std::shared_future<std::shared_ptr<const RobotShape>> shape;
  };
  std::mutex mutex_;
  std::vector<Entry> entries_;
};

// One robot at a stamp.
struct RobotAtFrame {
  collision::WorldRobotPtr robot;
  bool is_told = false;  // somebody tells its states
  RobotStateAt state;
  std::vector<perception::LinkAtStamp> links;  // one per link; as the world says if it is missing
};

// All robots of the snapshot at the stamp. A robot whose states nobody tells stands as the world
// says, if somebody set its state since it was loaded or if it has no joints; else its state is
// missing.
std::vector<RobotAtFrame> RobotsAt(const collision::WorldSnapshot& snapshot,
                                   const RobotStates& states, perception::Stamp stamp);

// Says why the state of the robot is missing.
std::string MissingStateText(const RobotAtFrame& at);

// The known bodies with those that robots carry at the stamp's place.
std::vector<perception::KnownBody> BodiesAt(const BodyTable& table,
                                            std::span<const RobotAtFrame> robots);

// The links of the robots whose states are known and whose shapes are made.
std::vector<perception::RobotLinks> LinksInView(std::span<const RobotAtFrame> robots,
                                                RobotShapes& shapes);

struct RobotsSeen {
  perception::RobotMask mask = {};
  std::vector<std::string> at_fault = {};  // robots whose links are not where they are said to be
  bool is_prepared = true;                 // false: shapes of robots are still being made
  // The greatest time by which the stamp is later than a robot's newest state; 0 if all states are
  // interpolated. Empty: no states are told.
  std::optional<double> state_age_ms = {};
  // ROBOT_STATE_MISSING, ROBOT_STATE_STALE or ROBOT_STATE_WRONG, and the words; empty if all is
  // well.
  std::string reason = {};
  std::string message = {};
};

// Finds the robots in the frames of one sensor. Not thread safe.
class RobotsInView {
 public:
  // `bodies` are those of BodiesAt.
  RobotsSeen Mask(const perception::RobotFrame& frame, std::chrono::nanoseconds exposure,
                  const BodyTable& table, std::span<const perception::KnownBody> bodies,
                  std::span<const RobotAtFrame> robots, RobotShapes& shapes);

 private:
  struct View {
    std::shared_ptr<const collision::RobotGeometry> robot;
    std::shared_ptr<const RobotShape> shape;  // null while it is being made
    std::unique_ptr<perception::RobotView> view;
  };
  View& ViewOf(const collision::WorldRobot& robot, RobotShapes& shapes);

  std::map<std::string, View, std::less<>> views_;  // by the robot's name
};

}  // namespace cwm::server
