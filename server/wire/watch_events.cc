#include "server/wire/watch_events.h"

#include <algorithm>
#include <limits>

#include "collision/world/attachment.h"
#include "server/wire/pair_rules.h"
#include "server/wire/poses.h"
#include "server/wire/robots.h"
#include "server/wire/times.h"

namespace cwm::server {
namespace {

// chosen: gRPC clients receive at most 4 MiB by default; a quarter of it leaves room for one more
// object (Limits::max_object_bytes, and what replies derive from it).
constexpr std::size_t kPieceBytes = 1 << 20;
// derived: names of at most 128 bytes, twice, with a time of about 12, facts of at most 20 and a
// link, and the framing stay within kPieceBytes, unless links have very long names.
constexpr std::size_t kMaxObserved = 3'000;

v1::Object ObjectMessage(const collision::WorldObject& object, const WatchContext& context) {
  return ObjectToProto(object, context.view, context.world.observations().Get(object.name),
                       context.store);
}

bool OnlyMoved(const collision::WorldObject& before, const collision::WorldObject& after) {
  return before.IsSameAs(after) && before.geometry_revision == after.geometry_revision &&
         before.pose_revision != after.pose_revision && before.kind == after.kind &&
         before.owner == after.owner && before.state == after.state &&
         before.supported_by == after.supported_by && before.margin_m == after.margin_m &&
         SameAttachment(before.attachment.get(), after.attachment.get());
}

void SetEvent(const collision::ObjectDelta& delta, const WatchContext& context,
              v1::ObjectEvent* event) {
  if (delta.after == nullptr) {
    event->set_remove(delta.before->name);
  } else if (delta.before != nullptr && OnlyMoved(*delta.before, *delta.after)) {
    event->mutable_move()->set_name(delta.after->name);
    *event->mutable_move()->mutable_x_world_object() = PoseToProto(delta.after->X_WO);
    event->set_pose_revision(delta.after->pose_revision.value);
    const Observation observation = context.world.observations().Get(delta.after->name);
    if (observation.facts.has_value()) {
      event->set_motion(SensorFactsToProto(*observation.facts).motion());
    }
  } else {
    *event->mutable_put() = ObjectMessage(*delta.after, context);
  }
}

void SetEvent(const collision::RobotDelta& delta, v1::RobotEvent* event) {
  if (delta.after == nullptr) {
    event->set_remove(delta.before->name);
  } else if (delta.before != nullptr && delta.before->IsSameAs(*delta.after)) {
    *event->mutable_state() = ToStateEvent(*delta.after);
  } else {
    *event->mutable_put() = RobotToProto(*delta.after);
  }
}

v1::WatchWorldResponse Message(collision::Revision revision, const World& world) {
  v1::WatchWorldResponse message;
  message.set_world_uid(world.uid());
  message.set_revision(revision.value);
  return message;
}

}  // namespace

v1::WatchWorldResponse InitialStatePiece(const collision::WorldSnapshot& snapshot,
                                         const WatchContext& context, std::size_t* next) {
  v1::WatchWorldResponse message = Message(snapshot.revision(), context.world);
  v1::WatchWorldResponse::InitialState* state = message.mutable_initial_state();
  const std::size_t objects = snapshot.objects().size();
  const std::size_t robots = objects + snapshot.robots().size();
  const std::size_t all = robots + snapshot.pair_rules().size();
  std::size_t bytes = 0;
  for (; *next < all && bytes < kPieceBytes; ++*next) {
    if (*next < objects) {
      v1::Object* object = state->add_objects();
      *object = ObjectMessage(*snapshot.objects()[*next], context);
      bytes += object->ByteSizeLong();
    } else if (*next < robots) {
      v1::Robot* robot = state->add_robots();
      *robot = RobotToProto(*snapshot.robots()[*next - objects]);
      bytes += robot->ByteSizeLong();
    } else {
      v1::PairRule* rule = state->add_pair_rules();
      *rule = PairRuleToProto(snapshot.pair_rules()[*next - robots]);
      bytes += rule->ByteSizeLong();
    }
  }
  state->set_initial_state_done(*next == all);
  return message;
}

v1::WatchWorldResponse EventsPiece(const WatchStep& step, const WatchContext& context,
                                   std::size_t* next) {
  v1::WatchWorldResponse message = Message(step.revision, context.world);
  v1::WatchWorldResponse::Events* events = message.mutable_events();
  const std::size_t objects = step.deltas.size();
  const std::size_t robots = objects + step.robot_deltas.size();
  const std::size_t all = robots + step.rule_deltas.size();
  std::size_t bytes = 0;
  for (; *next < all && bytes < kPieceBytes; ++*next) {
    if (*next < objects) {
      v1::ObjectEvent* event = events->add_events();
      SetEvent(step.deltas[*next], context, event);
      bytes += event->ByteSizeLong();
    } else if (*next < robots) {
      v1::RobotEvent* event = events->add_robot_events();
      SetEvent(step.robot_deltas[*next - objects], event);
      bytes += event->ByteSizeLong();
    } else {
      v1::PairRule* rule = events->add_pair_rules();
      *rule = PairRuleToProto(step.rule_deltas[*next - robots].after);
      bytes += rule->ByteSizeLong();
    }
  }
  events->set_more(*next < all);
  return message;
}

v1::WatchWorldResponse BookmarkMessage(collision::Revision revision, const World& world,
                                       std::uint64_t* observed) {
  v1::WatchWorldResponse message = Message(revision, world);
  v1::WatchWorldResponse::Bookmark& bookmark = *message.mutable_bookmark();
  // Both lists are of one sequence of numbers: the message goes as far as the shorter one.
  const auto sightings = world.observations().NewerThan(*observed, kMaxObserved);
  const auto facts = world.observations().FactsNewerThan(*observed, kMaxObserved);
  std::uint64_t end = std::numeric_limits<std::uint64_t>::max();
  if (sightings.size() == kMaxObserved) end = std::min(end, sightings.back().number);
  if (facts.size() == kMaxObserved) end = std::min(end, facts.back().number);
  for (const Observations::Numbered& one : sightings) {
    if (one.number > end) break;
    (*bookmark.mutable_last_observed())[one.name] = TimePointToProto(one.last);
    *observed = std::max(*observed, one.number);
  }
  for (const Observations::NumberedFacts& one : facts) {
    if (one.number > end) break;
    v1::SensorFacts& message_facts = (*bookmark.mutable_facts())[one.name];
    if (one.facts.has_value()) message_facts = SensorFactsToProto(*one.facts);
    *observed = std::max(*observed, one.number);
  }
  return message;
}

}  // namespace cwm::server
