// The world as it is, then everything that happens to it, across lost connections and restarts of
// the server.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "cwm/namespace.h"
#include "cwm/objects.h"
#include "cwm/robots.h"

namespace cwm::CWM_API {

// Added, or its geometry or another field changed.
struct ObjectPut {
  Object object;
};
// Only its pose changed.
struct ObjectMoved {
  std::string name;
  Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();
  std::int64_t pose_revision = 0;
  Motion motion = Motion::kNotFollowed;
};
struct ObjectRemoved {
  std::string name;
};
struct RobotPut {
  Robot robot;
};
// Only its base or its state changed.
struct RobotMoved {
  std::string name;
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  Eigen::VectorXd state = {};
  std::int64_t state_revision = 0;
};
struct RobotRemoved {
  std::string name;
};
// The rule as it is now; one that allows nothing and sets no margin was removed.
struct RuleSet {
  PairRule rule;
};

using Event = std::variant<ObjectPut, ObjectMoved, ObjectRemoved, RobotPut, RobotMoved,
                           RobotRemoved, RuleSet>;

// All of the world at the revision. It comes first, and again if the watch had to begin anew.
struct Snapshot {
  std::string world_uid;
  std::int64_t revision = 0;
  std::vector<Object> objects = {};
  std::vector<Robot> robots = {};
  std::vector<PairRule> rules = {};
  std::string anew = {};  // why it had to; empty for the first
};

// All that happened since, up to the revision: apply it at once.
struct Changes {
  std::string world_uid;
  std::int64_t revision = 0;
  std::vector<Event> events = {};
};

// The facts of running sensors about an object; see Object.
struct SensorFacts {
  Motion motion = Motion::kNotFollowed;
  Visibility visibility = Visibility::kNotFollowed;
  std::optional<bool> identity_certain = {};
  std::string carried_by = {};
};

// All up to the revision was told.
struct Bookmark {
  std::string world_uid;
  std::int64_t revision = 0;
  std::map<std::string, Time> last_observed = {};  // objects that scans saw again
  std::map<std::string, SensorFacts> facts = {};   // that changed, by object
};

using WatchEvent = std::variant<Snapshot, Changes, Bookmark>;

struct WatchOptions {
  // Only what comes after this revision of the world of that uid, as events have them. A uid is
  // needed but for revision 0. If the name has another world by now, the watch begins anew.
  std::optional<std::int64_t> from_revision = {};
  std::string world_uid = {};
  bool coalesced = false;  // of a burst only the newest state of each object
  ObjectView view = ObjectView::kShapes;
  std::optional<double> give_up_after_s = {};  // looking for a lost server; absent: never
};

// Made by World::Watch.
//
//   while (const auto event = watch.Next()) { ... }
class Watcher {
 public:
  class Call;
  explicit Watcher(std::unique_ptr<Call> call);
  ~Watcher();
  Watcher(Watcher&&) noexcept;
  Watcher& operator=(Watcher&&) noexcept;

  // Waits for the next event; none after Close. Throws Error: kNotFound if the world is deleted,
  // kUnavailable if no server was found for give_up_after_s.
  std::optional<WatchEvent> Next();
  // Ends the watch; from any thread, also while Next waits in another.
  void Close();

 private:
  std::unique_ptr<Call> call_;
};

}  // namespace cwm::CWM_API
