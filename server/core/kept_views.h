// The views of a world that were interpreted, so that a scan of a view that did not change is not
// interpreted again. Not a part of any revision, and not kept over a restart.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "collision/world/world_snapshot.h"
#include "perception/cloud/point_cloud.h"
#include "perception/live/still_view.h"
#include "perception/scene_interpretation.h"
#include "server/core/ingest.h"
#include "server/core/memory_budget.h"
#include "server/core/write_facts.h"

namespace cwm::server {

// What the interpretation of a scan follows from, besides its points and the world.
struct ViewConditions {
  SensorPose pose = {};
  bool in_world_frame = false;
  IngestMode mode = IngestMode::kUpdate;
  Vector3 viewpoint_C = Vector3::Zero();
  perception::InterpretOptions options = {};
  int width = 0, height = 0;
  bool seen_from_origin = true;

  // Numbers are compared to the bit.
  friend bool operator==(const ViewConditions& a, const ViewConditions& b);
};

// One scan as it was interpreted. Immutable.
struct KeptView {
  std::string sensor;
  ViewConditions conditions = {};
  // Of an organised cloud that a pinhole camera saw from its origin.
  std::optional<perception::StillView> image = {};
  // Of any other cloud, which is known again only if it is equal to the bit.
  std::vector<Eigen::Vector3f> points = {}, normals = {};

  // The reply. `report` has the warnings about the scan, and no stages.
  Pose X_WC = Pose::Identity();
  perception::InterpretReport report = {};
  std::vector<std::uint32_t> labels = {};  // one per point
  // The objects behind the labels; nullptr for those of the world, which have a name.
  std::vector<std::string> support_names = {}, object_names = {};
  std::vector<collision::WorldObjectPtr> provisional = {};  // one per name, supports first
  std::vector<std::optional<bool>> support_reachable = {};
  std::vector<std::string> seen = {}, occluded = {};  // names; the scan showed those of `seen`

  // All objects of the world that are or may be in the view, by name, as they were after the scan.
  std::vector<std::weak_ptr<const collision::WorldObject>> in_view = {};

  std::int64_t bytes() const;
};
using KeptViewPtr = std::shared_ptr<const KeptView>;

// The newest view of each sensor of one world. Thread safe.
class KeptViews {
 public:
  // chosen: a robot has few cameras that scan, and a view of 640 x 480 takes 2.5 MB.
  static constexpr std::size_t kMaxViews = 8;
  // chosen: larger clouds than any depth camera takes would fill the memory of a world.
  static constexpr std::size_t kMaxPoints = 2'000'000;

  // Views are charged to the world, for as long as they are kept.
  explicit KeptViews(MemoryCharge charge) : charge_(std::move(charge)) {}

  // Replaces the view of its sensor. Keeps nothing if there is no memory. The views that were used
  // least recently go first. No view grows too old: what counts is that the world and the scan are
  // as they were.
  void Keep(KeptViewPtr view);
  KeptViewPtr Find(const std::string& sensor);  // nullptr: none; counts as a use
  void Clear();

 private:
  std::mutex mutex_;              // before the locks of the account
  std::list<KeptViewPtr> views_;  // the one that was used last comes first
  MemoryCharge charge_;
};

}  // namespace cwm::server
