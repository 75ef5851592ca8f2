#include "server/store/world_images.h"

#include <algorithm>
#include <memory>
#include <unordered_map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/world/robot_state.h"
#include "server/store/decode_fault.h"
#include "server/store/prepare_geometry.h"

namespace cwm::server {
namespace {

using collision::WorldObjectPtr;
using collision::WorldRobotPtr;

// chosen: objects that a thread places at a time, some milliseconds.
constexpr std::size_t kPlacedAtOnce = 256;
// chosen: the shares of progress after the steps, between those of a world that moves a lot, where
// placing takes most of the time (measured: two thirds for 10,000 objects and 65,536 moves), and of
// one with large meshes, where preparing does.
constexpr double kPrepared = 0.5, kPlaced = 0.9;

std::string PlaceOf(const WorldFold& fold) {
  return absl::StrCat("world '", fold.name(), "' (", fold.uid(), ")");
}

// All versions of the objects and robots of all worlds: each is decoded and placed once.
class Members {
 public:
  void AddWorld(const FoldedWorld& world, const FoldedState& oldest,
                const MemoryBudget::Payer& payer) {
    worlds_.push_back({.place = PlaceOf(world.fold), .payer = payer});
    for (const auto& [name, object] : oldest.objects) Add(object);
    for (const auto& [name, robot] : oldest.robots) AddRobot(robot);
    for (const FoldedEvent& event : world.events) {
      for (const FoldedObjectDelta& delta : event.objects) Add(delta.after);
      for (const FoldedRobotDelta& delta : event.robots) AddRobot(delta.after);
    }
  }

  void AddTo(GeometryPreparation& preparation) const {
    for (const ObjectEntry& entry : objects_) {
      preparation.Add(entry.folded->model, OwnerOf(entry));
    }
    for (const RobotEntry& entry : robots_) {
      preparation.AddRobot(entry.folded->files().sha256(), OwnerOf(entry));
    }
  }

  absl::Status PlaceAll(const GeometryPreparation& preparation, int threads) {
    ParallelFor(objects_.size(), kPlacedAtOnce, threads,
                [&](std::size_t i) { PlaceObject(preparation, objects_[i]); });
    ParallelFor(robots_.size(), kPlacedAtOnce, threads,
                [&](std::size_t i) { PlaceRobot(preparation, robots_[i]); });
    for (const ObjectEntry& entry : objects_) {
      if (!entry.status.ok()) return DamagedAt(OwnerOf(entry).place, entry.status);
    }
    for (const RobotEntry& entry : robots_) {
      if (!entry.status.ok()) return DamagedAt(OwnerOf(entry).place, entry.status);
    }
    return absl::OkStatus();
  }

  // nullptr for nullptr, and for an object or robot whose content is lost.
  WorldObjectPtr Find(const FoldedObjectPtr& object) const {
    return object == nullptr ? nullptr : objects_[index_.at(object.get())].placed;
  }
  WorldRobotPtr Find(const FoldedRobotPtr& robot) const {
    return robot == nullptr ? nullptr : robots_[index_.at(robot.get())].placed;
  }

 private:
  struct ObjectEntry {
    FoldedObjectPtr folded = {};
    std::size_t world = 0;
    WorldObjectPtr placed = {};
    absl::Status status = {};
  };
  struct RobotEntry {
    FoldedRobotPtr folded = {};
    std::size_t world = 0;
    WorldRobotPtr placed = {};
    absl::Status status = {};
  };

  GeometryPreparation::Owner OwnerOf(const ObjectEntry& entry) const {
    const GeometryPreparation::Owner& world = worlds_[entry.world];
    return {absl::StrCat(world.place, ": object '", entry.folded->object.name(), "'"), world.payer};
  }
  GeometryPreparation::Owner OwnerOf(const RobotEntry& entry) const {
    const GeometryPreparation::Owner& world = worlds_[entry.world];
    return {absl::StrCat(world.place, ": robot '", entry.folded->name(), "'"), world.payer};
  }

  void Add(const FoldedObjectPtr& object) {
    if (object == nullptr || !index_.emplace(object.get(), objects_.size()).second) return;
    objects_.push_back({.folded = object, .world = worlds_.size() - 1});
  }
  void AddRobot(const FoldedRobotPtr& robot) {
    if (robot == nullptr || !index_.emplace(robot.get(), robots_.size()).second) return;
    robots_.push_back({.folded = robot, .world = worlds_.size() - 1});
  }

  static void PlaceObject(const GeometryPreparation& preparation, ObjectEntry& entry) {
    absl::StatusOr<collision::WorldObject> object = DecodeObject(entry.folded->object);
    entry.status = object.status();
    if (!object.ok()) return;
    object->geometry = preparation.Find(*entry.folded->model);
    if (object->geometry != nullptr) entry.placed = collision::Place(*std::move(object));
  }

  static void PlaceRobot(const GeometryPreparation& preparation, RobotEntry& entry) {
    absl::StatusOr<collision::WorldRobot> robot = DecodeRobot(*entry.folded);
    entry.status = robot.status();
    if (!robot.ok()) return;
    robot->robot = preparation.FindRobot(entry.folded->files().sha256());
    if (robot->robot == nullptr) return;
    if (!collision::IsState(*robot->robot->model, robot->state)) {
      entry.status = Broken("state", "must have one finite value for each variable of the robot");
      return;
    }
    entry.placed = collision::Place(*std::move(robot));
  }

  std::vector<GeometryPreparation::Owner> worlds_;
  std::vector<ObjectEntry> objects_;
  std::vector<RobotEntry> robots_;
  std::unordered_map<const void*, std::size_t> index_;  // into one of both
};

// Makes the image of one world.
class ImageMaker {
 public:
  ImageMaker(const Members& members, const ImageOptions& options)
      : members_(members), options_(options) {}

  absl::StatusOr<MadeWorld> Make(const FoldedWorld& world, FoldedState oldest) const {
    MadeWorld made;
    for (const auto& [name, object] : world.fold.state().objects) {
      if (members_.Find(object) == nullptr) made.lost_objects.push_back(name);
    }
    std::ranges::sort(made.lost_objects);
    AddLostRobots(world.fold.state(), made);
    made.has_losses = HasLosses(world, oldest);
    WorldImage& image = made.image;
    image.name = world.fold.name();
    image.uid = world.fold.uid();
    const absl::Status status =
        made.has_losses ? SetBase(world.fold.state(), image) : AddHistory(world, oldest, image);
    if (!status.ok()) return status;
    const absl::Status rest = AddRest(world.fold, image);
    if (!rest.ok()) return rest;
    return made;
  }

 private:
  void AddLostRobots(const FoldedState& state, MadeWorld& made) const {
    for (const auto& [name, robot] : state.robots) {
      if (members_.Find(robot) == nullptr) made.lost_robots.push_back(name);
    }
    std::ranges::sort(made.lost_robots);
    for (const auto& [name, object] : state.objects) {
      if (members_.Find(object) == nullptr || !IsOnLostRobot(object->object, state)) continue;
      made.detached_objects.push_back(object->object);
      made.detached_objects.back().clear_attachment();
    }
    const auto name_of = [](const auto& object) -> const std::string& { return object.name(); };
    std::ranges::sort(made.detached_objects, {}, name_of);
  }

  bool IsOnLostRobot(const store::v1::Object& object, const FoldedState& state) const {
    if (!object.has_attachment()) return false;
    const auto robot = state.robots.find(object.attachment().robot());
    return robot != state.robots.end() && members_.Find(robot->second) == nullptr;
  }

  // The object as it is when what it was attached to is lost.
  static WorldObjectPtr Detached(const collision::WorldObject& object) {
    auto detached = std::make_shared<collision::WorldObject>(object);
    detached->attachment = nullptr;
    return detached;
  }

  bool HasLosses(const FoldedWorld& world, const FoldedState& oldest) const {
    for (const auto& [name, object] : oldest.objects) {
      if (members_.Find(object) == nullptr) return true;
    }
    for (const auto& [name, robot] : oldest.robots) {
      if (members_.Find(robot) == nullptr) return true;
    }
    for (const FoldedEvent& event : world.events) {
      for (const FoldedObjectDelta& delta : event.objects) {
        if (delta.after != nullptr && members_.Find(delta.after) == nullptr) return true;
      }
      for (const FoldedRobotDelta& delta : event.robots) {
        if (delta.after != nullptr && members_.Find(delta.after) == nullptr) return true;
      }
    }
    return false;
  }

  absl::StatusOr<collision::PairRules> RulesOf(const FoldedState& state) const {
    collision::PairRules rules;
    if (state.rules.size() > collision::kMaxPairRules) {
      return Broken("rules", absl::StrCat("are ", state.rules.size(), ", must be at most ",
                                          collision::kMaxPairRules));
    }
    for (const auto& [key, rule] : state.rules) {
      absl::StatusOr<collision::PairRule> decoded = DecodeRule(rule, options_.rules_clock);
      if (!decoded.ok()) return Within("rules", decoded.status());
      collision::SetRule(rules, *std::move(decoded));
    }
    return rules;
  }

  absl::Status SetBase(const FoldedState& state, WorldImage& image) const {
    std::vector<WorldObjectPtr> objects;
    for (const auto& [name, object] : state.objects) {
      WorldObjectPtr placed = members_.Find(object);
      if (placed == nullptr) continue;
      const bool is_detached = IsOnLostRobot(object->object, state);
      objects.push_back(is_detached ? Detached(*placed) : std::move(placed));
    }
    std::vector<WorldRobotPtr> robots;
    for (const auto& [name, robot] : state.robots) {
      if (auto placed = members_.Find(robot)) robots.push_back(std::move(placed));
    }
    const auto by_name = [](const auto& member) -> const std::string& { return member->name; };
    std::ranges::sort(objects, {}, by_name);
    std::ranges::sort(robots, {}, by_name);
    absl::StatusOr<collision::PairRules> rules = RulesOf(state);
    if (!rules.ok()) return rules.status();
    image.base = std::make_shared<const collision::WorldSnapshot>(
        collision::Revision{state.revision}, objects, std::move(robots), *std::move(rules));
    image.oldest_watch = image.base->revision();
    return absl::OkStatus();
  }

  absl::StatusOr<EventPtr> MakeEvent(const FoldedEvent& folded, Clock::time_point& newest) const {
    auto event = std::make_shared<Event>();
    event->revision.value = folded.revision;
    // Ages do not decrease although the wall clock may have been set back.
    event->when = newest = std::max(newest, SteadyTimeOf(folded.when_ns, options_.now));
    event->deltas.reserve(folded.objects.size());
    for (const auto& [before, after] : folded.objects) {
      event->deltas.push_back({.before = members_.Find(before), .after = members_.Find(after)});
    }
    for (const auto& [before, after] : folded.robots) {
      event->robot_deltas.push_back(
          {.before = members_.Find(before), .after = members_.Find(after)});
    }
    for (const FoldedRuleDelta& delta : folded.rules) {
      absl::StatusOr<collision::PairRule> after = DecodeRule(delta.after, options_.rules_clock);
      if (!after.ok()) return Within("rules", after.status());
      collision::PairRuleDelta made{.before = {.pair = after->pair}, .after = *after};
      if (delta.before) {
        auto before = DecodeRule(*delta.before, options_.rules_clock);
        if (!before.ok()) return Within("rules", before.status());
        made.before = *std::move(before);
      }
      event->rule_deltas.push_back(std::move(made));
    }
    return event;
  }

  static SnapshotPtr Next(const collision::WorldSnapshot& previous, const Event& event) {
    std::shared_ptr<collision::PairRules> rules;
    if (!event.rule_deltas.empty()) {
      rules = std::make_shared<collision::PairRules>(previous.pair_rules());
      for (const collision::PairRuleDelta& delta : event.rule_deltas) SetRule(*rules, delta.after);
    }
    return std::make_shared<const collision::WorldSnapshot>(
        previous.After(event.revision, event.deltas, event.robot_deltas, std::move(rules)));
  }

  // Only the newest events get a snapshot each.
  absl::Status AddHistory(const FoldedWorld& world, FoldedState& state, WorldImage& image) const {
    const auto max_steps =
        static_cast<std::size_t>(std::max<std::int64_t>(0, options_.retention.exact_snapshots - 1));
    const std::size_t count = world.events.size();
    const std::size_t earlier = count > max_steps ? count - max_steps : 0;
    const collision::Revision oldest_watch{state.revision};
    Clock::time_point newest = Clock::time_point::min();
    for (std::size_t i = 0; i < count; ++i) {
      if (i == earlier) {
        if (absl::Status status = SetBase(state, image); !status.ok()) return status;
      }
      absl::StatusOr<EventPtr> event = MakeEvent(world.events[i], newest);
      if (!event.ok()) return event.status();
      if (i < earlier) {
        state.Apply(world.events[i]);
        image.earlier.push_back(*std::move(event));
        continue;
      }
      const SnapshotPtr& previous = image.steps.empty() ? image.base : image.steps.back().next;
      SnapshotPtr next = Next(*previous, **event);
      image.steps.push_back({.event = *std::move(event), .next = std::move(next)});
    }
    if (image.base == nullptr) {
      if (absl::Status status = SetBase(state, image); !status.ok()) return status;
    }
    image.oldest_watch = oldest_watch;
    return absl::OkStatus();
  }

  absl::Status AddRest(const WorldFold& fold, WorldImage& image) const {
    const Clock::time_point oldest = options_.now.steady - options_.retention.request_id_time;
    Clock::time_point newest = Clock::time_point::min();
    for (const store::v1::AnsweredRequest& request : fold.Requests()) {
      newest = std::max(newest, SteadyTimeOf(request.when_ns(), options_.now));
      if (newest < oldest) continue;
      image.requests.push_back({.request = DecodeRequest(request.request()),
                                .revision = {request.revision()},
                                .when = newest});
    }
    image.last_numbers = fold.last_numbers();
    for (const auto& [sensor, pose] : fold.sensor_poses()) {
      absl::StatusOr<NamedSensorPose> decoded = DecodeSensorPose(pose);
      if (!decoded.ok()) return Within("sensor_poses", decoded.status());
      image.sensor_poses[sensor] = decoded->pose;
    }
    for (WorldFold::NamedObservation& each : fold.Observations()) {
      image.observations.push_back({.name = std::move(each.name), .observation = each.observation});
    }
    return absl::OkStatus();
  }

  const Members& members_;
  const ImageOptions& options_;
};

}  // namespace

absl::StatusOr<MadeWorlds> MakeWorlds(const Store& store, std::vector<FoldedWorld> worlds,
                                      const ImageOptions& options) {
  const auto report = [&](double share) {
    if (options.progress) options.progress(share);
  };
  Members members;
  std::vector<FoldedState> oldest;
  std::vector<std::optional<MemoryBudget::Payer>> payers;
  for (const FoldedWorld& world : worlds) {
    payers.emplace_back();
    if (options.memory != nullptr) {
      payers.back() = MemoryBudget::World(options.memory->NextWorldNumber(), world.fold.name());
    }
    FoldedState state = world.fold.state();
    for (auto event = world.events.rbegin(); event != world.events.rend(); ++event) {
      state.Undo(*event);
    }
    members.AddWorld(world, state, payers.back().value_or(MemoryBudget::Payer()));
    oldest.push_back(std::move(state));
  }
  GeometryPreparation preparation(store, options.robot_limits, options.accepted, options.memory);
  members.AddTo(preparation);
  absl::Status status =
      preparation.Run(options.threads, [&](double share) { report(kPrepared * share); });
  if (!status.ok()) return status;
  status = members.PlaceAll(preparation, options.threads);
  if (!status.ok()) return status;
  report(kPlaced);
  std::vector<absl::StatusOr<MadeWorld>> made(worlds.size(), absl::StatusOr<MadeWorld>());
  const ImageMaker maker(members, options);
  ParallelFor(worlds.size(), 1, options.threads,
              [&](std::size_t i) { made[i] = maker.Make(worlds[i], std::move(oldest[i])); });
  MadeWorlds result{.worlds = {}, .geometry_count = preparation.count()};
  for (std::size_t i = 0; i < worlds.size(); ++i) {
    if (!made[i].ok()) return DamagedAt(PlaceOf(worlds[i].fold), made[i].status());
    made[i]->image.payer = payers[i];
    result.worlds.push_back(*std::move(made[i]));
  }
  report(1);
  return result;
}

}  // namespace cwm::server
