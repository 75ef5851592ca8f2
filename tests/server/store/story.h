// A random story of a world: all kinds of writes, among them some that are refused.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "server/core/world.h"
#include "tests/server/store/many_shapes.h"
#include "tests/server/store/recorded_world.h"

namespace cwm::server {

class Story {
 public:
  Story(Journal& journal, unsigned seed)
      : source_(seed), arms_{KeptArm(journal), KeptArm(journal, "0.12")} {
    for (int i = 0; i < 6; ++i) small_.push_back(collision::Prepare(source_.SmallModel()));
    full_ = collision::Prepare(source_.FullModel());
  }

  // One write of one to three changes; many are refused, as clients' are. The world keeps large
  // geometry itself where a client's write would.
  void WriteTo(World& world) {
    if (source_.Integer(0, 9) == 0) return Scan(world);
    std::vector<collision::Change> changes;
    for (int i = source_.Integer(1, 3); i > 0; --i) changes.push_back(AnyChange());
    WriteOptions options;
    if (source_.Integer(0, 3) == 0) {
      options.request_id = "request-" + std::to_string(++requests_);
      options.request_digest = "digest-" + std::to_string(requests_);
    }
    const auto outcome = world.Apply(changes, options);
    ++(outcome.ok() ? written_ : refused_);
  }

  int written() const { return written_; }
  int refused() const { return refused_; }
  int requests() const { return requests_; }

 private:
  // A scan names a new object, reports sightings and tells its sensor's pose.
  void Scan(World& world) {
    const std::vector<Sighting> sightings = {
        {.name = AnyObject(), .reachable = source_.Integer(0, 1) == 1},
        {.name = AnyObject(), .is_new = true},
        {.name = AnyObject()}};
    WriteHooks hooks;
    hooks.durability = Durability::kObserved;
    hooks.facts = [&](const collision::WorldSnapshot& next) {
      WriteFacts facts{.seen_at = std::chrono::system_clock::time_point(
                           std::chrono::nanoseconds(1'700'000'000'123'456'789) +
                           std::chrono::seconds(source_.Integer(0, 50)))};
      for (const Sighting& sighting : sightings) {
        if (next.Find(sighting.name) != nullptr) facts.sightings.push_back(sighting);
      }
      facts.sensor_pose =
          NamedSensorPose{.sensor = source_.Integer(0, 1) == 0 ? "left" : "right",
                          .pose = {.X_WC = source_.AnyPose(), .given = source_.Integer(0, 1) == 1}};
      return facts;
    };
    const auto make = [&](const SnapshotPtr&) {
      collision::PutObject put{.name = world.ReserveName("object"),
                               .kind = collision::ObjectKind::kObject,
                               .owner = collision::Owner::kPerception,
                               .X_WO = source_.AnyPose(),
                               .geometry = small_[1],
                               .supported_by = AnyObject()};
      return std::vector<collision::Change>{{std::move(put), std::nullopt}};
    };
    ASSERT_TRUE(world.KeepGeometry({{small_[1]}}, Durability::kObserved).ok());
    ASSERT_TRUE(world.Update(make, {}, hooks).ok());
    ++written_;
  }

  std::string AnyObject() { return "box_" + std::to_string(source_.Integer(0, 9)); }
  std::string AnyRobot() { return source_.Integer(0, 1) == 0 ? "arm" : "spare"; }

  collision::Change AnyChange() {
    const auto change = [](auto what) { return collision::Change{std::move(what), std::nullopt}; };
    switch (source_.Integer(0, 12)) {
      case 0:
      case 1: {
        const int which = source_.Integer(0, 6);
        return change(collision::PutObject{
            .name = AnyObject(),
            .kind = static_cast<collision::ObjectKind>(source_.Integer(0, 4)),
            .owner = static_cast<collision::Owner>(source_.Integer(0, 1)),
            .state = static_cast<collision::ObjectState>(source_.Integer(0, 2)),
            .X_WO = source_.AnyPose(),
            .geometry = which == 6 ? full_ : small_[static_cast<std::size_t>(which)],
            .supported_by = AnyObject(),
            .margin_m = source_.Number(0, 0.1)});
      }
      case 2:
        return change(collision::RemoveObject{AnyObject()});
      case 3:
        return change(collision::AttachObject{.name = AnyObject(),
                                              .robot = AnyRobot(),
                                              .link = "tip",
                                              .X_LO = source_.AnyPose(),
                                              .touch_links = {"left", "right"}});
      case 4:
        return change(collision::DetachObject{AnyObject()});
      case 5: {
        const auto& arm = arms_[source_.Integer(0, 5) == 0 ? 1 : 0];
        return change(collision::testing::PutArm(AnyRobot(), arm));
      }
      case 6:
        if (source_.Integer(0, 4) > 0) return change(collision::RemoveObject{AnyObject()});
        return change(collision::RemoveRobot{AnyRobot()});
      case 7:
        return change(collision::testing::SetElbow(AnyRobot(), source_.Number(-1, 1)));
      case 8: {
        collision::AllowCollision allow{.pair = AnyPair(), .withdraw = source_.Integer(0, 2) == 0};
        if (source_.Integer(0, 1) == 0) {
          allow.expires = collision::ExpiryAfter(std::chrono::hours(source_.Integer(1, 20)));
        }
        return change(allow);
      }
      case 9:
        return change(collision::SetPairMargin{
            .pair = AnyPair(),
            .margin_m =
                source_.Integer(0, 2) == 0 ? std::nullopt : std::optional(source_.Number(0, 0.1))});
      default:
        return change(collision::MoveObject{AnyObject(), source_.AnyPose()});
    }
  }

  collision::NamedPair AnyPair() {
    return {.a = {.name = AnyObject()},
            .b = {.name = AnyRobot(), .link = source_.Integer(0, 1) == 0 ? "" : "tip"}};
  }

  ModelSource source_;
  std::vector<std::shared_ptr<const collision::RobotGeometry>> arms_;
  std::vector<std::shared_ptr<const collision::PreparedModel>> small_;
  std::shared_ptr<const collision::PreparedModel> full_;
  int written_ = 0, refused_ = 0, requests_ = 0;
};

}  // namespace cwm::server
