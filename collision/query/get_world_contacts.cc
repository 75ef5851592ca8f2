#include "collision/query/get_world_contacts.h"

#include <algorithm>
#include <cmath>
#include <compare>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "collision/engines/exact_engine.h"
#include "collision/query/body_search.h"
#include "collision/query/interrupt.h"
#include "collision/query/object_ranks.h"
#include "collision/query/obstacle_pair_rules.h"
#include "collision/query/robot_body.h"
#include "collision/query/row_chunks.h"
#include "collision/query/world_filter.h"

namespace cwm::collision {
namespace {

// chosen: an object has a few neighbours, each of which takes some microseconds.
constexpr std::size_t kObstaclesPerChunk = 64;
// chosen: comparisons of boxes between two polls.
constexpr std::size_t kBoxesPerUnit = 64;

struct WorldContact {
  const Obstacle* a = nullptr;
  const Obstacle* b = nullptr;
  std::int32_t part_a = 0, part_b = 0;
  PairDistance answer;

  friend bool operator<(const WorldContact& x, const WorldContact& y) {
    if (x.answer.distance_m != y.answer.distance_m) {
      return x.answer.distance_m < y.answer.distance_m;
    }
    return std::tie(x.a->name, x.b->name, x.part_a, x.part_b) <
           std::tie(y.a->name, y.b->name, y.part_a, y.part_b);
  }
};

// Keeps the deepest contacts, at most `capacity`.
class DeepestContacts {
 public:
  explicit DeepestContacts(int capacity)
      : capacity_(static_cast<std::size_t>(std::max(0, capacity))) {}

  void Add(const WorldContact& contact) {
    contacts_.push_back(contact);
    if (contacts_.size() >= 2 * capacity_ + 1) Shrink();
  }
  void Add(const DeepestContacts& others) {
    has_dropped_ |= others.has_dropped_;
    for (const WorldContact& contact : others.contacts_) Add(contact);
  }
  void Clear() {
    contacts_.clear();
    has_dropped_ = false;
  }
  // The contacts in order.
  const std::vector<WorldContact>& Sort() {
    Shrink();
    std::sort(contacts_.begin(), contacts_.end());
    return contacts_;
  }
  bool has_dropped() const { return has_dropped_; }

 private:
  void Shrink() {
    if (contacts_.size() <= capacity_) return;
    has_dropped_ = true;
    const auto end = contacts_.begin() + static_cast<std::ptrdiff_t>(capacity_);
    std::nth_element(contacts_.begin(), end, contacts_.end());
    contacts_.erase(end, contacts_.end());
  }

  std::size_t capacity_;
  bool has_dropped_ = false;
  std::vector<WorldContact> contacts_;
};

const WorldObject* ObjectOf(const Obstacle& obstacle) {
  return obstacle.robot == nullptr ? static_cast<const WorldObject*>(&obstacle) : nullptr;
}

const Attachment* AttachmentOf(const Obstacle& obstacle) {
  const WorldObject* const object = ObjectOf(obstacle);
  return object != nullptr ? object->attachment.get() : nullptr;
}

bool IsSupportedBy(const Obstacle& obstacle, const Obstacle& support) {
  const WorldObject* const object = ObjectOf(obstacle);
  return object != nullptr && !object->supported_by.empty() && object->supported_by == support.name;
}

// True if both are attached to the same link.
bool AreOnOneLink(const Obstacle& a, const Obstacle& b) {
  const Attachment* const of_a = AttachmentOf(a);
  const Attachment* const of_b = AttachmentOf(b);
  return of_a != nullptr && of_b != nullptr && of_a->robot == of_b->robot &&
         of_a->link == of_b->link;
}

int LinkOf(const Obstacle& obstacle, std::size_t part) {
  return obstacle.robot != nullptr ? obstacle.robot->link_of_part[part] : 0;
}

std::size_t CountOf(const Obstacle& obstacle) { return obstacle.parts_W.size(); }

// By link of the robot: true if the object, which it carries, is not tested against the link.
// Empty if the robot does not carry the object.
std::vector<bool> CarryingLinks(const Obstacle& robot, const Obstacle& object) {
  const Attachment* const attachment = AttachmentOf(object);
  if (attachment == nullptr || robot.robot == nullptr || attachment->robot != robot.name) return {};
  const RobotModel& model = *robot.robot->model;
  std::vector<bool> carries(model.links.size(), false);
  const auto add = [&](const std::string& name) {
    if (const auto link = model.FindLink(name)) carries[static_cast<std::size_t>(*link)] = true;
  };
  add(attachment->link);
  for (const std::string& link : attachment->touch_links) add(link);
  return carries;
}

QueryOptions WithoutOnly(QueryOptions options) {
  options.only.clear();
  return options;
}

std::vector<PairRule> IgnoredOf(const QueryOptions& options) {
  std::vector<PairRule> ignored;
  for (const NamedPair& pair : options.ignore_pairs) {
    ignored.push_back({.pair = Ordered(pair), .allowed = true});
  }
  return ignored;
}

// The query and its result, shared by the threads.
struct ContactBatch {
  ContactBatch(const WorldSnapshot& of_world, const QueryOptions& given, std::stop_token stopped)
      : world(of_world),
        options(given),
        stop(std::move(stopped)),
        limit(given),
        kept(world, WithoutOnly(given)),
        named(world, given),
        ignored(IgnoredOf(given)),
        rules(world, ignored),
        result(given.max_contacts) {}

  const WorldSnapshot& world;
  const QueryOptions& options;
  const std::stop_token stop;
  TimeLimit limit;
  const WorldFilter kept;   // what counts at all
  const WorldFilter named;  // of that, what QueryOptions::only names, which is all if it is empty
  const std::vector<PairRule> ignored;
  const ObstaclePairRules rules;
  std::mutex mutex;
  DeepestContacts result;  // guarded by `mutex`
};

// The pair of obstacles that is being tested.
struct ObstaclePair {
  const Obstacle& a;
  const Obstacle& b;  // the same for the self pairs of a robot
  ObstaclePairTable rules = {};
  std::vector<bool> carrying_links =
      {};               // of the robot that carries the other; empty: neither does
  double margin_m = 0;  // without paddings, deviations and rules
  bool has_paddings = false;
};

class ContactWorker : public ChunkWorker {
 public:
  explicit ContactWorker(ContactBatch& batch)
      : batch_(batch),
        interrupt_(batch.stop, batch.limit),
        max_margin_m_(batch.world.max_margin_m() + batch.options.margin_m),
        found_(batch.options.max_contacts) {}

  // Tests each obstacle of the chunk against those that no other chunk tests it against.
  ChunkResult Process(const RowChunk& chunk) override {
    std::size_t k = 0;
    for (; k < chunk.count && status_.ok() && !interrupt_.CountWork(1); ++k) {
      TestObstacle(batch_.world.ObstacleAt(chunk.first + k));
      if (has_ended()) break;
    }
    {
      const std::lock_guard lock(batch_.mutex);
      batch_.result.Add(found_);
    }
    found_.Clear();
    if (interrupt_.reason() == Interrupt::Reason::kStopped) {
      status_ = absl::CancelledError("the question was cancelled");
    }
    return {k, status_};
  }

 private:
  bool has_ended() const {
    return !status_.ok() || interrupt_.reason() != Interrupt::Reason::kNone;
  }

  void TestObstacle(const Obstacle& one) {
    if (batch_.named.Skips(one) || batch_.kept.Skips(one) || one.bounds_W.isEmpty()) {
      return;
    }
    if (one.robot != nullptr) TestRobot(one);
    const std::span<const double> paddings_m = PaddingsOf_m(one);
    const double own_m =
        one.margin_m + (paddings_m.empty() ? 0 : std::ranges::max(paddings_m)) + max_margin_m_;
    const double sigma_m = batch_.options.margin_sigma *
                           (one.geometry->max_sigma_m + batch_.world.objects().max_sigma_m());
    const double reach_m = std::max({0.0, own_m, batch_.rules.max_margin_m()}) + sigma_m;
    batch_.world.bounds().ForEachWithin(one.bounds_W, reach_m, [&](const Obstacle& other) {
      if (&one == &other || batch_.kept.Skips(other)) return !interrupt_.CountWork(1);
      // Of two named obstacles, the first by name tests the pair.
      const bool is_mine = batch_.named.Skips(other) || one.name < other.name;
      if (is_mine) TestPair(one, other);
      return !has_ended() && !interrupt_.CountWork(1);
    });
  }

  void TestPair(const Obstacle& one, const Obstacle& other) {
    if (AreOnOneLink(one, other)) return;
    const bool in_order = one.name < other.name;
    ObstaclePair pair{.a = in_order ? one : other, .b = in_order ? other : one};
    pair.rules = batch_.rules.Of(pair.a, pair.b);
    pair.carrying_links =
        pair.a.robot != nullptr ? CarryingLinks(pair.a, pair.b) : CarryingLinks(pair.b, pair.a);
    const bool stands = IsSupportedBy(pair.a, pair.b) || IsSupportedBy(pair.b, pair.a);
    pair.margin_m = stands ? -batch_.options.support_tolerance_m
                           : pair.a.margin_m + pair.b.margin_m + batch_.options.margin_m;
    // A robot and what it carries are one body, whose links have no paddings.
    pair.has_paddings = !stands && pair.carrying_links.empty();
    const double reach_m = MaxMargin_m(pair);
    const std::vector<std::size_t> near_b = PartsNear(pair.b, pair.a.bounds_W, reach_m);
    for (std::size_t a = 0; a < CountOf(pair.a) && !near_b.empty(); ++a) {
      if (CountBoxes(near_b.size()) || has_ended()) return;
      if (SquaredDistance_m2(pair.a.parts_W[a].bounds_W, pair.b.bounds_W) > reach_m * reach_m) {
        continue;
      }
      for (const std::size_t b : near_b) {
        TestParts(pair, a, b);
        if (has_ended()) return;
      }
    }
  }

  // Tests the self pairs of a robot.
  void TestRobot(const Obstacle& robot) {
    QueryBody body = BodyFromRobot(*robot.robot, RobotScope::kSelf);
    body.self = robot.name;
    body = WithCheckedPairs(std::move(body), batch_.world.pair_rules(), RobotScope::kSelf);
    ObstaclePair pair{.a = robot, .b = robot};
    pair.rules = batch_.rules.Of(robot, robot);
    pair.margin_m = batch_.options.margin_m;
    for (const PartPair& parts : body.self_pairs) {
      const auto [first, second] = std::minmax(parts.first, parts.second);
      if (CountBoxes(1)) return;
      TestParts(pair, static_cast<std::size_t>(first), static_cast<std::size_t>(second));
      if (has_ended()) return;
    }
  }

  bool CountBoxes(std::size_t boxes) {
    boxes_ += boxes;
    if (boxes_ < kBoxesPerUnit) return false;
    const auto units = static_cast<int>(boxes_ / kBoxesPerUnit);
    boxes_ %= kBoxesPerUnit;
    return interrupt_.CountWork(units);
  }

  // An upper bound of the margins of the pair's parts, at least 0.
  double MaxMargin_m(const ObstaclePair& pair) const {
    double max_m = std::max(0.0, pair.margin_m);
    for (const Obstacle* each : {&pair.a, &pair.b}) {
      const std::span<const double> paddings_m = PaddingsOf_m(*each);
      if (pair.has_paddings && !paddings_m.empty()) max_m += std::ranges::max(paddings_m);
    }
    return std::max(max_m, batch_.rules.max_margin_m()) +
           batch_.options.margin_sigma *
               (pair.a.geometry->max_sigma_m + pair.b.geometry->max_sigma_m);
  }

  std::vector<std::size_t> PartsNear(const Obstacle& obstacle, const Aabb& other_W,
                                     double reach_m) {
    std::vector<std::size_t> near;
    if (CountBoxes(CountOf(obstacle))) return near;
    for (std::size_t k = 0; k < CountOf(obstacle); ++k) {
      if (batch_.kept.SkipsPart(obstacle, k)) continue;
      const double squared_m2 = SquaredDistance_m2(obstacle.parts_W[k].bounds_W, other_W);
      if (squared_m2 <= reach_m * reach_m) near.push_back(k);
    }
    return near;
  }

  bool IsNamed(const Obstacle& obstacle, std::size_t part) const {
    return !batch_.named.Skips(obstacle) && !batch_.named.SkipsPart(obstacle, part);
  }

  // The margin of two parts; empty if they are not tested against each other.
  std::optional<double> MarginOf(const ObstaclePair& pair, std::size_t a, std::size_t b) const {
    if (batch_.kept.SkipsPart(pair.a, a) || batch_.kept.SkipsPart(pair.b, b)) return std::nullopt;
    if (!IsNamed(pair.a, a) && !IsNamed(pair.b, b)) return std::nullopt;
    const int link_a = LinkOf(pair.a, a), link_b = LinkOf(pair.b, b);
    if (!pair.carrying_links.empty()) {
      const int link = pair.a.robot != nullptr ? link_a : link_b;
      if (pair.carrying_links[static_cast<std::size_t>(link)]) return std::nullopt;
    }
    double margin_m = pair.margin_m;
    if (pair.has_paddings) {
      margin_m += MarginOf_m(pair.a, a) - pair.a.margin_m + MarginOf_m(pair.b, b) - pair.b.margin_m;
    }
    if (!pair.rules.empty()) {
      const EffectiveRule rule = pair.rules.At(link_a, link_b).Effective();
      if (rule.allowed) return std::nullopt;
      margin_m = rule.Margin_m(margin_m);
    }
    return margin_m + batch_.options.margin_sigma *
                          (pair.a.geometry->parts[a].sigma_m + pair.b.geometry->parts[b].sigma_m);
  }

  void TestParts(const ObstaclePair& pair, std::size_t a, std::size_t b) {
    const PlacedPart &placed_a = pair.a.parts_W[a], &placed_b = pair.b.parts_W[b];
    const std::optional<double> margin_m = MarginOf(pair, a, b);
    if (!margin_m) return;
    const double near_m = std::max(0.0, *margin_m);
    if (SquaredDistance_m2(placed_a.bounds_W, placed_b.bounds_W) > near_m * near_m) return;
    const PreparedPart &part_a = pair.a.geometry->parts[a], &part_b = pair.b.geometry->parts[b];
    const ShapeKind kind_a = KindOf(part_a.shape), kind_b = KindOf(part_b.shape);
    const Engine* const engine =
        ChosenEngine(batch_.options.engine, kind_a, kind_b, QueryKind::kDistance);
    if (engine == nullptr) return ReportUnsupported(pair, a, b);
    const auto slot = static_cast<std::size_t>(engine->kind());
    scratch_.clear();
    engine->Contacts({kind_a, *part_a.engines[static_cast<int>(slot)], placed_a.X_WP},
                     {kind_b, *part_b.engines[static_cast<int>(slot)], placed_b.X_WP}, *margin_m, 1,
                     scratch_, &interrupt_);
    if (interrupt_.CountWork(1 + WeightOf(part_a.shape) + WeightOf(part_b.shape))) return;
    if (scratch_.empty()) return;
    WorldContact contact{.a = &pair.a,
                         .b = &pair.b,
                         .part_a = static_cast<std::int32_t>(a),
                         .part_b = static_cast<std::int32_t>(b),
                         .answer = scratch_.front()};
    LabelCaps(contact);
    LabelHidden(pair, contact.answer);
    found_.Add(contact);
    batch_.limit.Count(1);
  }

  // Bounds a distance by what closed holes of meshes leave open.
  void LabelCaps(WorldContact& contact) {
    const auto part_of = [](const Obstacle& obstacle, std::int32_t k) -> const PreparedPart& {
      return obstacle.geometry->parts[static_cast<std::size_t>(k)];
    };
    const PreparedPart& a = part_of(*contact.a, contact.part_a);
    const PreparedPart& b = part_of(*contact.b, contact.part_b);
    if (!HasCaps(a.shape) && !HasCaps(b.shape)) return;
    constexpr int kExactSlot = static_cast<int>(EngineKind::kExact);
    const auto pose_of = [](const Obstacle& obstacle, std::int32_t k) -> const Pose& {
      return obstacle.parts_W[static_cast<std::size_t>(k)].X_WP;
    };
    const double reach_m = std::abs(contact.answer.distance_m) + contact.answer.bound_m;
    const CapError error =
        CapErrorOf({KindOf(a.shape), *a.engines[kExactSlot], pose_of(*contact.a, contact.part_a)},
                   {KindOf(b.shape), *b.engines[kExactSlot], pose_of(*contact.b, contact.part_b)},
                   reach_m, &interrupt_);
    contact.answer = WithCapError(contact.answer, error);
  }

  // Bounds a distance by how far the two may extend where no sensor saw them.
  static void LabelHidden(const ObstaclePair& pair, PairDistance& answer) {
    const double hidden_m = pair.a.geometry->max_hidden_m + pair.b.geometry->max_hidden_m;
    if (hidden_m <= 0) return;
    answer.accuracy = std::max(answer.accuracy, Accuracy::kBounded);
    answer.bound_m = std::max(answer.bound_m, hidden_m);
  }

  void ReportUnsupported(const ObstaclePair& pair, std::size_t a, std::size_t b) {
    // absl as packaged by Debian accepts std::string, but not std::string_view.
    const auto text = [](std::string_view name) { return std::string(name); };
    const auto name_of = [&](const Obstacle& obstacle, std::size_t k) {
      const PreparedPart& part = obstacle.geometry->parts[k];
      return absl::StrCat(text(cwm::NameOf(KindOf(part.shape))), " ('", obstacle.name, "', ",
                          text(NameOf(part.source)), "[", part.index, "])");
    };
    status_ = absl::UnimplementedError(absl::StrCat(
        "engine ", text(NameOf(batch_.options.engine)), " does not answer distance of ",
        name_of(pair.a, a), " and ", name_of(pair.b, b)));
  }

  ContactBatch& batch_;
  Interrupt interrupt_;
  const double max_margin_m_;  // of anything, with the request's margin
  std::size_t boxes_ = 0;
  DeepestContacts found_;
  std::vector<PairDistance> scratch_;
  absl::Status status_;
};

void Append(const Vector3& v, std::vector<double>& column) {
  column.insert(column.end(), {v.x(), v.y(), v.z()});
}

}  // namespace

absl::StatusOr<WorldContactColumns> GetWorldContacts(const WorldSnapshot& world,
                                                     const QueryOptions& options,
                                                     std::stop_token stop) {
  ContactBatch batch(world, options, std::move(stop));
  const std::size_t count = world.objects().size() + world.robots().size();
  const auto completed = ProcessChunks(EqualChunks(count, kObstaclesPerChunk), options.threads,
                                       [&] { return std::make_unique<ContactWorker>(batch); });
  if (!completed.ok()) return completed.status();
  WorldContactColumns columns;
  ObjectRanks ranks(world);
  for (const WorldContact& contact : batch.result.Sort()) {
    columns.object_a.push_back(ranks.IndexOf(contact.a));
    columns.object_b.push_back(ranks.IndexOf(contact.b));
    columns.part_a.push_back(contact.part_a);
    columns.part_b.push_back(contact.part_b);
    columns.distance_m.push_back(contact.answer.distance_m);
    Append(contact.answer.point_a, columns.point_a);
    Append(contact.answer.point_b, columns.point_b);
    Append(contact.answer.normal, columns.normal);
    columns.accuracy.push_back(contact.answer.accuracy);
    columns.bound_m.push_back(contact.answer.bound_m);
  }
  columns.is_complete = *completed == count && !batch.result.has_dropped();
  return columns;
}

}  // namespace cwm::collision
