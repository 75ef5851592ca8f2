// A world's state as it is written in a store, while records are applied one after the other:
// messages, from which nothing is computed. Cheap, so that all of a log can be folded and only what
// survives is prepared.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "absl/status/statusor.h"
#include "cwm/store/v1/record.pb.h"
#include "server/core/limits.h"
#include "server/core/observations.h"

namespace cwm::server {

// chosen: the revisions that a world skips after a power cut, so that no revision that a reader may
// have seen is ever made again with other content. Far more than a log holds that is not yet on the
// disk. A record says how many it skips, so the number may change.
inline constexpr std::int64_t kRevisionsLostAtMost = 65'536;

// The model of an object, shared by all its versions that have it.
struct FoldedModel {
  store::v1::Model model = {};
  bool observed = false;            // its blobs may be lost
  std::int64_t prepared_bytes = 0;  // about so many when it is prepared
};
struct FoldedObject {
  store::v1::Object object = {};  // without its model
  std::shared_ptr<const FoldedModel> model = {};
};
using FoldedObjectPtr = std::shared_ptr<const FoldedObject>;
using FoldedRobotPtr = std::shared_ptr<const store::v1::Robot>;  // with its files

// As in Event: nullptr for what does not exist.
struct FoldedObjectDelta {
  FoldedObjectPtr before = {}, after = {};
};
struct FoldedRobotDelta {
  FoldedRobotPtr before = {}, after = {};
};
struct FoldedRuleDelta {
  std::optional<store::v1::PairRule> before = {};  // absent: there was none
  store::v1::PairRule after = {};                  // may be empty
};
struct FoldedEvent {
  std::int64_t before = 0;  // the revision to which it was applied
  std::int64_t revision = 0;
  std::int64_t when_ns = 0;
  bool drops_past = false;  // nobody may read what was before it
  std::vector<FoldedObjectDelta> objects = {};
  std::vector<FoldedRobotDelta> robots = {};
  std::vector<FoldedRuleDelta> rules = {};

  std::int64_t size() const {
    return static_cast<std::int64_t>(objects.size() + robots.size() + rules.size());
  }
  // About the bytes of prepared geometry that it took out of the world.
  std::int64_t superseded_bytes() const;
};

// The state between two records.
struct FoldedState {
  std::int64_t revision = 0;
  std::unordered_map<std::string, FoldedObjectPtr> objects = {};
  std::unordered_map<std::string, FoldedRobotPtr> robots = {};
  std::map<std::string, store::v1::PairRule> rules = {};  // by RuleKey

  void Apply(const FoldedEvent& event);
  // Undoes the last event that was applied.
  void Undo(const FoldedEvent& event);
  // Adds or replaces the rule of its pair; removes it if the rule is empty.
  void SetRule(const store::v1::PairRule& rule);
};

class WorldFold {
 public:
  // A world before its first record, which creates it.
  explicit WorldFold(const Retention& retention) : retention_(retention) {}
  // The world of a snapshot. DataLoss with the field if it is not valid.
  static absl::StatusOr<WorldFold> FromSnapshot(store::v1::WorldSnapshot snapshot,
                                                const Retention& retention);

  // Applies the next record. Returns its event; none if it makes no revision. DataLoss with the
  // field if it does not follow: a revision that is not the next after those that the record skips,
  // a name that does not exist, another world.
  absl::StatusOr<std::optional<FoldedEvent>> Apply(store::v1::Record record);

  store::v1::WorldSnapshot Snapshot() const;
  // The same without objects, and the objects one by one: for snapshots that are made in steps.
  store::v1::WorldSnapshot SnapshotWithoutObjects() const;
  std::vector<FoldedObjectPtr> ObjectsInOrder() const;

  const std::string& uid() const { return uid_; }
  const std::string& name() const { return name_; }
  const FoldedState& state() const { return state_; }
  // The latest time of a record, of the Unix epoch: not before that of any of them.
  std::int64_t newest_when_ns() const { return newest_when_ns_; }
  struct End {
    store::v1::Deletion deletion = {};
    std::int64_t when_ns = 0;
  };
  // Set after the record that deleted the world.
  const std::optional<End>& end() const { return end_; }
  // Oldest first, each id once: as many as the retention allows.
  std::vector<store::v1::AnsweredRequest> Requests() const;
  const std::map<std::string, std::int64_t>& last_numbers() const { return last_numbers_; }
  const std::map<std::string, store::v1::SensorPose>& sensor_poses() const { return sensor_poses_; }
  struct NamedObservation {
    std::string name = {};
    Observation observation = {};
  };
  // In the order in which they were made.
  std::vector<NamedObservation> Observations() const;

 private:
  struct NumberedObservation {
    Observation observation = {};
    std::uint64_t number = 0;
  };

  absl::Status CheckFollows(const store::v1::Record& record) const;
  absl::StatusOr<FoldedEvent> TakeChanges(store::v1::Record& record);
  absl::Status TakeObject(store::v1::ObjectChange& change, bool observed, FoldedEvent& event);
  absl::Status TakeRobot(store::v1::RobotChange& change, FoldedEvent& event);
  void TakeFacts(store::v1::Record& record);
  void KeepRequest(store::v1::AnsweredRequest request);

  Retention retention_;
  std::string uid_, name_;
  std::optional<End> end_;
  FoldedState state_;
  std::deque<store::v1::AnsweredRequest> requests_;  // oldest first
  std::map<std::string, std::int64_t> last_numbers_;
  std::map<std::string, store::v1::SensorPose> sensor_poses_;
  std::unordered_map<std::string, NumberedObservation> observations_;  // by object
  std::uint64_t last_observation_ = 0;
  std::int64_t newest_when_ns_ = 0;
};

void AddObject(const FoldedObject& object, store::v1::WorldSnapshot& snapshot);

// Identifies the pair of a rule; in the order of pairs.
std::string RuleKey(const store::v1::PairRule& rule);
// True for a rule that says nothing: it is removed.
bool IsEmptyRule(const store::v1::PairRule& rule);

}  // namespace cwm::server
