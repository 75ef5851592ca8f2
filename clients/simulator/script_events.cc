#include <numbers>
#include <utility>

#include "absl/strings/str_cat.h"
#include "clients/simulator/pose_yaml.h"
#include "clients/simulator/script_yaml.h"
#include "perception/simulation/hand.h"

namespace cwm::simulator {
namespace {

using perception::HandReach;
using perception::ObjectEvent;
using perception::SequenceScript;
using perception::TimeInterval;

constexpr double kMinOpening_m = 0.0, kMaxOpening_m = 0.2;

// A hand whose tips and elbow are given.
absl::StatusOr<Pose> ReadHandPose(const YamlNode& node) {
  if (node.Has("pose") == node.Has("tips_m")) return node.Error("must hold either pose or tips_m");
  if (node.Has("pose")) return ReadPose(node["pose"]);
  const auto tips = ReadVector(node["tips_m"]);
  if (!tips.ok()) return tips.status();
  const auto elbow = ReadVector(node["elbow_m"]);
  if (!elbow.ok()) return elbow.status();
  constexpr double kApart_m = 1e-6;  // at a smaller distance the direction is rounding
  if (!((*tips - *elbow).norm() > kApart_m))
    return node["elbow_m"].Error("must differ from tips_m");
  Pose X_WH = Pose::Identity();
  X_WH.linear() = BasisFromZ((*tips - *elbow).normalized());
  X_WH.translation() = *tips;
  return X_WH;
}

absl::Status ReadHand(const YamlNode& node, SequenceScript& script) {
  absl::Status status = node.CheckKeys({"name", "opening_m", "waypoints"});
  if (!status.ok()) return status;
  const auto name = ReadNewName(node["name"], HandNames(script));
  if (!name.ok()) return name.status();
  const auto opening = ReadNumberOr(node["opening_m"], 0.06);
  if (!opening.ok()) return opening.status();
  if (*opening < kMinOpening_m || *opening > kMaxOpening_m) {
    return node["opening_m"].Error(
        absl::StrCat("must be from ", kMinOpening_m, " to ", kMaxOpening_m));
  }
  const YamlNode list = node["waypoints"];
  const auto times_s = ReadTimes(list, script.duration_s);
  if (!times_s.ok()) return times_s.status();
  perception::SimulatedHand hand{.name = *name, .shape = perception::MakeHand(*opening)};
  for (std::size_t i = 0; i < list.size(); ++i) {
    status = list[i].CheckKeys({"time_s", "pose", "tips_m", "elbow_m"});
    if (!status.ok()) return status;
    const auto X_WH = ReadHandPose(list[i]);
    if (!X_WH.ok()) return X_WH.status();
    hand.waypoints.push_back({.time_s = (*times_s)[i], .X_WB = *X_WH});
  }
  script.hands.push_back(std::move(hand));
  return absl::OkStatus();
}

class EventReader {
 public:
  explicit EventReader(SequenceScript& script) : script_(script) {
    for (const perception::SimulatedObject& object : script.scene.objects) {
      names_.push_back(object.name);
    }
    end_s_.assign(names_.size(), -kMaxDuration_s);
  }

  absl::Status Read(const YamlNode& node) {
    if (absl::Status status = node.CheckKeys({"push", "take", "put", "carry"}); !status.ok()) {
      return status;
    }
    const int count = node.Has("push") + node.Has("take") + node.Has("put") + node.Has("carry");
    if (count != 1) return node.Error("must hold one of push, take, put and carry");
    if (node.Has("push")) return ReadPush(node["push"]);
    if (node.Has("take")) return ReadTake(node["take"]);
    if (node.Has("put")) return ReadPut(node["put"]);
    return ReadCarry(node["carry"]);
  }

 private:
  absl::Status ReadPush(const YamlNode& node) {
    absl::Status status =
        node.CheckKeys({"object", "from_s", "to_s", "by_m", "turn_deg", "to", "hand"});
    if (!status.ok()) return status;
    const auto object = ReadNameOf(node["object"], "object of the scene", names_);
    if (!object.ok()) return object.status();
    const auto during = ReadDuring(node);
    if (!during.ok()) return during.status();
    if (status = CheckStart(node, *object, during->begin_s, true); !status.ok()) return status;
    const auto X_WO = ReadGoal(node, *object, during->begin_s);
    if (!X_WO.ok()) return X_WO.status();
    const auto reach = ReadReach(node["hand"], *object, during->begin_s, false);
    if (!reach.ok()) return reach.status();
    if (reach->by_hand) {
      perception::PushByHand(*object, *during, *X_WO, reach->hand, script_);
    } else {
      Add({.object = *object,
           .begin_s = during->begin_s,
           .end_s = during->end_s,
           .what = perception::MoveEvent{.X_WO = *X_WO}});
    }
    end_s_[*object] = during->end_s;
    return absl::OkStatus();
  }

  absl::Status ReadTake(const YamlNode& node) {
    absl::Status status = node.CheckKeys({"object", "at_s", "hand"});
    if (!status.ok()) return status;
    const auto object = ReadNameOf(node["object"], "object of the scene", names_);
    if (!object.ok()) return object.status();
    const auto at_s = ReadTime(node["at_s"], script_.duration_s);
    if (!at_s.ok()) return at_s.status();
    if (status = CheckStart(node, *object, *at_s, true); !status.ok()) return status;
    const auto reach = ReadReach(node["hand"], *object, *at_s, true);
    if (!reach.ok()) return reach.status();
    if (reach->by_hand) {
      perception::TakeByHand(*object, *at_s, reach->hand, script_);
    } else {
      Add({.object = *object, .begin_s = *at_s, .end_s = *at_s, .what = perception::VanishEvent{}});
    }
    end_s_[*object] = script_.events.back().end_s;
    return absl::OkStatus();
  }

  absl::Status ReadPut(const YamlNode& node) {
    absl::Status status = node.CheckKeys({"object", "at_s", "pose", "hand"});
    if (!status.ok()) return status;
    const auto object = ReadNameOf(node["object"], "object of the scene", names_);
    if (!object.ok()) return object.status();
    const auto at_s = ReadTime(node["at_s"], script_.duration_s);
    if (!at_s.ok()) return at_s.status();
    Pose X_WO = script_.scene.objects[*object].X_WO;
    if (node["pose"].present()) {
      const auto given = ReadPose(node["pose"]);
      if (!given.ok()) return given.status();
      X_WO = *given;
    }
    const auto reach = ReadReach(node["hand"], *object, *at_s, true);
    if (!reach.ok()) return reach.status();
    const double begin_s = *at_s - (reach->by_hand ? reach->hand.travel_s : 0);
    if (status = CheckStart(node, *object, begin_s, false); !status.ok()) return status;
    if (reach->by_hand) {
      perception::PutByHand(*object, *at_s, X_WO, reach->hand, script_);
    } else {
      Add({.object = *object,
           .begin_s = *at_s,
           .end_s = *at_s,
           .what = perception::AppearEvent{.X_WO = X_WO}});
    }
    end_s_[*object] = *at_s;
    return absl::OkStatus();
  }

  absl::Status ReadCarry(const YamlNode& node) {
    absl::Status status = node.CheckKeys({"object", "from_s", "to_s", "robot", "link", "hand"});
    if (!status.ok()) return status;
    const auto object = ReadNameOf(node["object"], "object of the scene", names_);
    if (!object.ok()) return object.status();
    const auto during = ReadDuring(node);
    if (!during.ok()) return during.status();
    if (status = CheckStart(node, *object, during->begin_s, true); !status.ok()) return status;
    if (node.Has("hand") == node.Has("robot")) return node.Error("must hold either robot or hand");
    perception::CarryEvent carry;
    if (node.Has("hand")) {
      const auto hand = ReadNameOf(node["hand"], "hand of the script", HandNames(script_));
      if (!hand.ok()) return hand.status();
      carry.carrier = perception::HandRef{*hand};
    } else {
      const auto link = ReadLinkRef(node, script_);
      if (!link.ok()) return link.status();
      carry.carrier = *link;
    }
    Add({.object = *object, .begin_s = during->begin_s, .end_s = during->end_s, .what = carry});
    end_s_[*object] = during->end_s;
    return absl::OkStatus();
  }

  absl::StatusOr<TimeInterval> ReadDuring(const YamlNode& node) const {
    const auto begin = ReadTime(node["from_s"], script_.duration_s);
    if (!begin.ok()) return begin.status();
    const auto end = ReadTime(node["to_s"], script_.duration_s);
    if (!end.ok()) return end.status();
    if (*end <= *begin) return node["to_s"].Error("must be later than from_s");
    return TimeInterval{.begin_s = *begin, .end_s = *end};
  }

  // The events of an object come one after the other.
  absl::Status CheckStart(const YamlNode& node, std::size_t object, double begin_s,
                          bool must_be_there) const {
    if (begin_s < end_s_[object]) {
      return node.Error(absl::StrCat("begins at ", begin_s,
                                     " s, must not begin before the object's "
                                     "event before it ends, at ",
                                     end_s_[object], " s"));
    }
    bool has_events = false;
    for (const ObjectEvent& event : script_.events) has_events |= event.object == object;
    // Without events before, it is there for whatever needs it, and not there before it is put.
    const bool is_there =
        has_events ? perception::ObjectStateAt(script_, object, begin_s).is_present : must_be_there;
    if (is_there == must_be_there) return absl::OkStatus();
    return node.Error(absl::StrCat(names_[object], is_there ? " is still" : " is not", " there at ",
                                   begin_s, " s"));
  }

  absl::StatusOr<Pose> ReadGoal(const YamlNode& node, std::size_t object, double begin_s) const {
    if (node.Has("to") == node.Has("by_m")) return node.Error("must hold either by_m or to");
    if (node.Has("to")) {
      if (node.Has("turn_deg")) return node["turn_deg"].Error("must stand beside by_m");
      return ReadPose(node["to"]);
    }
    const auto by = ReadVector(node["by_m"]);
    if (!by.ok()) return by.status();
    const auto turn_deg = ReadNumberOr(node["turn_deg"], 0);
    if (!turn_deg.ok()) return turn_deg.status();
    const Pose start = perception::ObjectStateAt(script_, object, begin_s).X_WO;
    const Eigen::AngleAxisd turn(*turn_deg * std::numbers::pi / 180, Vector3::UnitZ());
    Pose X_WO = start;
    X_WO.linear() = turn * start.linear();
    X_WO.translation() += *by;
    return X_WO;
  }

  struct Reach {
    bool by_hand = false;
    HandReach hand = {};
  };

  // true, false, or a map with what differs from the usual hand.
  absl::StatusOr<Reach> ReadReach(const YamlNode& node, std::size_t object, double time_s,
                                  bool otherwise) const {
    Reach reach{.by_hand = otherwise};
    if (node.present() && !node.is_map()) {
      const auto flag = node.ReadFlag();
      if (!flag.ok()) return flag.status();
      reach.by_hand = *flag;
    }
    reach.hand.name =
        script_.hands.empty() ? "hand" : absl::StrCat("hand_", script_.hands.size() + 1);
    reach.hand.from_W = perception::ReachFrom(script_, object, time_s);
    if (!node.is_map()) return reach;
    reach.by_hand = true;
    if (absl::Status status = node.CheckKeys({"name", "from_m", "travel_s"}); !status.ok()) {
      return status;
    }
    if (node["name"].present()) {
      const auto name = ReadNewName(node["name"], HandNames(script_));
      if (!name.ok()) return name.status();
      reach.hand.name = *name;
    }
    if (node["from_m"].present()) {
      const auto from = ReadVector(node["from_m"]);
      if (!from.ok()) return from.status();
      reach.hand.from_W = *from;
    }
    if (node["travel_s"].present()) {
      const auto travel = ReadPositive(node["travel_s"]);
      if (!travel.ok()) return travel.status();
      reach.hand.travel_s = *travel;
    }
    return reach;
  }

  void Add(ObjectEvent event) { script_.events.push_back(std::move(event)); }

  SequenceScript& script_;
  std::vector<std::string> names_;
  std::vector<double> end_s_;  // by object: of its last event
};

}  // namespace

absl::Status ReadHands(const YamlNode& node, SequenceScript& script) {
  if (node.present() && !node.is_list()) return node.Error("must be a list of hands");
  for (std::size_t i = 0; i < node.size(); ++i) {
    if (absl::Status status = ReadHand(node[i], script); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status ReadEvents(const YamlNode& node, SequenceScript& script) {
  if (node.present() && !node.is_list()) return node.Error("must be a list of events");
  EventReader reader(script);
  for (std::size_t i = 0; i < node.size(); ++i) {
    if (absl::Status status = reader.Read(node[i]); !status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace cwm::simulator
