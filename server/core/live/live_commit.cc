#include "server/core/live/live_commit.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/core/live/robot_states.h"

namespace cwm::server {
namespace {

using collision::Change;
using collision::ObjectKind;
using collision::WorldObject;
using collision::WorldObjectPtr;
using collision::WorldSnapshot;
using perception::TrackChange;

bool IsMover(const WorldObject& object) {
  return object.kind == ObjectKind::kMover && object.owner == collision::Owner::kPerception;
}

// The object as the frame saw it, if it still is; otherwise nullptr.
WorldObjectPtr Unchanged(const WorldObjectPtr& seen, const WorldSnapshot& latest) {
  if (seen == nullptr || seen->owner == collision::Owner::kUser) return nullptr;
  WorldObjectPtr now = latest.Find(seen->name);
  if (now == nullptr || !now->IsSameAs(*seen) || now->attachment != nullptr) return nullptr;
  if (now->latest_revision() != seen->latest_revision()) return nullptr;
  return now;
}

Change MoveChange(const WorldObject& object, const Pose& X_WO) {
  if (object.state == collision::ObjectState::kConfirmed) {
    return {collision::MoveObject{.name = object.name, .X_WO = X_WO}, std::nullopt};
  }
  return {collision::PutObject{.name = object.name,
                               .kind = object.kind,
                               .owner = object.owner,
                               .state = collision::ObjectState::kConfirmed,
                               .X_WO = X_WO,
                               .geometry = object.geometry,
                               .supported_by = object.supported_by,
                               .margin_m = object.margin_m},
          std::nullopt};
}

// The name "mover_<n>" with the least n that is not in `taken` and that nothing else in the world
// has.
std::string FreeMoverName(const std::set<std::string>& taken, const WorldSnapshot& latest) {
  for (std::int64_t n = 1;; ++n) {
    std::string name = absl::StrCat("mover_", n);
    if (taken.contains(name) || latest.FindRobot(name) != nullptr) continue;
    const WorldObjectPtr object = latest.Find(name);
    if (object == nullptr || IsMover(*object)) return name;
  }
}

bool IsSamePiece(const WorldObject& object, const collision::PutObject& put) {
  if (!object.X_WO.isApprox(put.X_WO, 0)) return false;
  const auto& before = object.model().shapes;
  const auto& after = put.geometry->model->shapes;
  return std::ranges::equal(before, after, [](const ShapePart& a, const ShapePart& b) {
    return a.X_OS.translation() == b.X_OS.translation() &&
           std::get<Box>(a.shape).size_m == std::get<Box>(b.shape).size_m;
  });
}

// The piece about the centre of its boxes.
collision::PutObject PieceObject(const perception::MoverPiece& piece) {
  Aabb bounds_W;
  for (const Aabb& box : piece.boxes_W) bounds_W.extend(box);
  const Vector3 p_WO = bounds_W.center();
  auto model = std::make_shared<HybridModel>();
  for (const Aabb& box : piece.boxes_W) {
    model->shapes.push_back({.X_OS = Pose(Eigen::Translation3d(box.center() - p_WO)),
                             .shape = Box{.size_m = box.sizes()}});
  }
  return {.name = {},
          .kind = ObjectKind::kMover,
          .owner = collision::Owner::kPerception,
          .X_WO = Pose(Eigen::Translation3d(p_WO)),
          .geometry = collision::Prepare(std::move(model)),
          .supported_by = {}};
}

}  // namespace

MoverObjects::Plan MoverObjects::PlanOf(const std::string& sensor,
                                        std::span<const perception::MoverPiece> pieces) {
  Plan plan{.sensor = sensor};
  for (const perception::MoverPiece& piece : pieces) {
    if (!piece.boxes_W.empty()) plan.puts.push_back(PieceObject(piece));
  }
  return plan;
}

std::vector<Change> MoverObjects::Changes(const Plan& plan, const WorldSnapshot& latest) {
  std::set<std::string> taken;
  for (const auto& [sensor, names] : names_) {
    if (sensor != plan.sensor) taken.insert(names.begin(), names.end());
  }
  // Whatever mover no other sensor has is this one's, also if a user took its name meanwhile.
  std::vector<std::string> own = names_[plan.sensor];
  std::erase_if(own, [&](const std::string& name) {
    const WorldObjectPtr object = latest.Find(name);
    return object == nullptr || !IsMover(*object);
  });
  std::vector<Change> changes;
  for (std::size_t i = 0; i < plan.puts.size(); ++i) {
    collision::PutObject put = plan.puts[i];
    put.name = i < own.size() ? own[i] : FreeMoverName(taken, latest);
    taken.insert(put.name);
    const WorldObjectPtr before = latest.Find(put.name);
    if (before != nullptr && IsSamePiece(*before, put)) {
      put.geometry = before->geometry;  // no effect, but its name is told
    }
    changes.push_back({std::move(put), std::nullopt});
  }
  for (std::size_t i = plan.puts.size(); i < own.size(); ++i) {
    if (taken.contains(own[i])) continue;  // a new piece took the name
    changes.push_back({collision::RemoveObject{own[i]}, std::nullopt});
  }
  return changes;
}

void MoverObjects::Set(const std::string& sensor, std::vector<std::string> names) {
  if (names.empty()) {
    names_.erase(sensor);
  } else {
    names_[sensor] = std::move(names);
  }
}

std::vector<Change> RemoveMovers(const WorldSnapshot& latest) {
  std::vector<Change> changes;
  for (const WorldObjectPtr& object : latest.objects()) {
    if (!IsMover(*object)) continue;
    changes.push_back({collision::RemoveObject{object->name}, std::nullopt});
  }
  return changes;
}

absl::StatusOr<LiveWritten> Commit(World& world, const LiveWrite& write, MoverObjects& movers) {
  std::optional<MoverObjects::Plan> plan;
  for (const TrackChange& change : write.changes) {
    if (change.kind != TrackChange::Kind::kMovers) continue;
    plan = MoverObjects::PlanOf(write.sensor, change.pieces);
  }
  LiveWritten written;
  std::vector<std::string> mover_names;
  std::vector<collision::SetRobotState> robot_states;
  const auto make = [&](const SnapshotPtr& latest) -> absl::StatusOr<std::vector<Change>> {
    written = {};
    mover_names.clear();
    std::vector<Change> changes;
    for (const TrackChange& change : write.changes) {
      if (change.kind == TrackChange::Kind::kMovers) continue;
      const WorldObjectPtr object = Unchanged(write.bodies->Find(change.body), *latest);
      if (object == nullptr) continue;
      if (change.kind == TrackChange::Kind::kMove) {
        written.changes.moved.push_back(object->name);
        changes.push_back(MoveChange(*object, change.X_WB));
      } else {
        written.changes.removed.push_back(object->name);
        written.removed.push_back(object);
        changes.push_back({collision::RemoveObject{object->name}, std::nullopt});
      }
    }
    if (plan.has_value()) {
      for (Change& change : movers.Changes(*plan, *latest)) {
        if (std::holds_alternative<collision::PutObject>(change.what)) {
          mover_names.push_back(NameOf(change));
        }
        written.changes.movers.push_back(NameOf(change));
        changes.push_back(std::move(change));
      }
    }
    if (write.takes_robot_states) {
      std::ranges::move(world.robot_states().TakeAll(), std::back_inserter(robot_states));
    }
    std::ranges::move(RobotStates::ChangesOf(robot_states, *latest), std::back_inserter(changes));
    return changes;
  };
  const auto outcome = world.Update(make, {}, {.durability = Durability::kObserved});
  if (!outcome.ok()) return outcome.status();
  if (plan.has_value()) movers.Set(write.sensor, std::move(mover_names));
  written.revision = outcome->revision;
  return written;
}

}  // namespace cwm::server
