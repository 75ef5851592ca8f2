// Queries under pair rules, compared with rules that are evaluated pair by pair.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

#include "collision/engines/engine.h"
#include "collision/query/robot_body.h"
#include "collision/robot/kinematics.h"
#include "tests/collision/query/random_world.h"
#include "tests/collision/robot/robot_text.h"

namespace cwm::collision {
namespace {

using testing::Ball;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::JointText;
using testing::Links;
using testing::NoMeshes;
using testing::Robot;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Change Allow(NamedThing a, NamedThing b) {
  return {.what = AllowCollision{.pair = {std::move(a), std::move(b)}},
          .expected_object_revision = {}};
}
Change Margin(NamedThing a, NamedThing b, double margin_m) {
  return {.what = SetPairMargin{.pair = {std::move(a), std::move(b)}, .margin_m = margin_m},
          .expected_object_revision = {}};
}

using SnapshotPtr = std::shared_ptr<const WorldSnapshot>;
SnapshotPtr With(const SnapshotPtr& world, const std::vector<Change>& changes) {
  return *Apply(world, changes);
}

// The meaning of a rule, written from its documentation.
bool IsNamed(const NamedThing& thing, const std::string& name, const std::string& link) {
  return thing.name == "*" ||
         (thing.name == name && !name.empty() && (thing.link.empty() || thing.link == link));
}
struct Part {
  std::string name, link;
};
bool IsAbout(const NamedPair& pair, const Part& x, const Part& y) {
  return (IsNamed(pair.a, x.name, x.link) && IsNamed(pair.b, y.name, y.link)) ||
         (IsNamed(pair.b, x.name, x.link) && IsNamed(pair.a, y.name, y.link));
}
int Names(const NamedPair& pair) {
  int count = 0;
  for (const NamedThing* thing : {&pair.a, &pair.b}) {
    count += thing->name != "*";
    count += !thing->link.empty();
  }
  return count;
}

// The margin of the pair; empty if it may collide.
std::optional<double> MarginByHand(const WorldSnapshot& world, const QueryOptions& options,
                                   const Part& x, const Part& y, double default_m) {
  const PairRule* best = nullptr;
  for (const PairRule& rule : world.pair_rules()) {
    if (!IsAbout(rule.pair, x, y)) continue;
    if (rule.allowed) return std::nullopt;
    if (!rule.margin_m) continue;
    const bool better = best == nullptr || Names(rule.pair) > Names(best->pair) ||
                        (Names(rule.pair) == Names(best->pair) && rule.pair < best->pair);
    if (better) best = &rule;
  }
  for (const NamedPair& pair : options.ignore_pairs) {
    if (IsAbout(pair, x, y)) return std::nullopt;
  }
  return best != nullptr ? *best->margin_m : default_m;
}

// Three balls of 0.1 m radius, 0.5 m apart along x: a fixed one and two on rotary joints.
std::shared_ptr<const RobotGeometry> BallArm() {
  const std::string arm = "<origin xyz=\"0.5 0 0\"/>";
  const std::string limits = "<axis xyz=\"0 0 1\"/><limit lower=\"-3\" upper=\"3\"/>";
  const auto description = ReadUrdf(Robot(Ball("a") + Links("bd") + Ball("c") + Ball("e") +
                                          JointText("shoulder", "revolute", "a", "b", limits) +
                                          JointText("upper", "fixed", "b", "c", arm) +
                                          JointText("elbow", "revolute", "c", "d", limits) +
                                          JointText("lower", "fixed", "d", "e", arm)),
                                    NoMeshes);
  return PrepareRobot(*MakeRobotModel(*description, nullptr), std::nullopt);
}

class Drawn {
 public:
  explicit Drawn(unsigned seed) : random_(seed) {}

  double Below(double most) { return std::uniform_real_distribution<>(0, most)(random_); }
  int Index(int count) { return static_cast<int>(random_() % static_cast<unsigned>(count)); }
  // A random item, which may or may not exist.
  NamedThing Thing() {
    const int which = Index(10);
    if (which == 0) return {"*"};
    if (which == 1) return {"arm"};
    if (which < 5) return {"arm", std::string(1, "abcde"[Index(5)])};
    if (which == 5) return {"nowhere"};
    return {"object" + std::to_string(Index(14))};
  }
  NamedPair Pair() { return {Thing(), Thing()}; }
  std::mt19937& random() { return random_; }

 private:
  std::mt19937 random_;
};

// A world of objects with margins and fits, and rules.
SnapshotPtr RuledWorld(Drawn& draw, int rules) {
  std::vector<Change> changes;
  const auto plain = RandomWorld(12, draw.random(), /*with_meshes=*/true);
  for (const WorldObjectPtr& object : plain->objects()) {
    auto model = std::make_shared<HybridModel>(object->model());
    for (ShapePart& part : model->shapes) {
      if (draw.Index(2) == 0)
        part.fit = FitQuality{.rms_m = draw.Below(0.01), .parameter_sigma = {}};
    }
    PutObject put;
    put.name = object->name;
    put.X_WO = object->X_WO;
    put.geometry = Prepare(std::move(model));
    put.margin_m = draw.Index(2) == 0 ? draw.Below(0.05) : 0;
    changes.push_back({.what = std::move(put), .expected_object_revision = {}});
  }
  for (int i = 0; i < rules; ++i) {
    NamedPair pair = draw.Pair();
    if (draw.Index(2) == 0) {
      const bool all = pair.a.name == "*" && pair.b.name == "*";
      if (!all) changes.push_back(Allow(pair.a, pair.b));
    } else {
      changes.push_back(Margin(pair.a, pair.b, draw.Below(0.3)));
    }
  }
  return WorldOf(changes);
}

// The parts of a body at a row, and their names.
struct ByHand {
  const WorldSnapshot& world;
  const QueryBody& body;
  const QueryOptions& options;
  std::vector<Part> names;
  std::vector<Pose> X_WF;

  double Deviation_m(const PreparedPart& part) const { return options.margin_sigma * part.sigma_m; }
  Part NameOf(std::size_t part) const {
    return names[body.frame_of_part.empty() ? 0
                                            : static_cast<std::size_t>(body.frame_of_part[part])];
  }
  Pose PoseOf(std::size_t part) const {
    const std::size_t frame =
        body.frame_of_part.empty() ? 0 : static_cast<std::size_t>(body.frame_of_part[part]);
    return X_WF[frame] * body.geometry->parts[part].X_OP;
  }
  static double Distance_m(const PreparedPart& a, const Pose& X_WA, const PreparedPart& b,
                           const Pose& X_WB) {
    return GetEngine(EngineKind::kExact)
        .Distance({KindOf(a.shape), *a.engines[0], X_WA}, {KindOf(b.shape), *b.engines[0], X_WB},
                  kInfinity)
        .distance_m;
  }

  struct Seen {
    double distance_m, margin_m;
    int object;  // may be kSelfObject
    int body_part, object_part;
  };
  std::vector<Seen> Pairs() const {
    std::vector<Seen> seen;
    for (const auto& [first, second] : body.self_pairs) {
      const auto a = static_cast<std::size_t>(first), b = static_cast<std::size_t>(second);
      const PreparedPart &one = body.geometry->parts[a], &other = body.geometry->parts[b];
      const auto margin_m = MarginByHand(world, options, NameOf(a), NameOf(b), options.margin_m);
      if (!margin_m) continue;
      seen.push_back({Distance_m(one, PoseOf(a), other, PoseOf(b)),
                      *margin_m + Deviation_m(one) + Deviation_m(other), kSelfObject, first,
                      second});
    }
    for (std::size_t i = 0; i < world.objects().size(); ++i) {
      const WorldObject& object = *world.objects()[i];
      if (object.name == body.self) continue;
      for (std::size_t b = 0; b < body.geometry->parts.size(); ++b) {
        const double default_m = object.margin_m + body.margin_m + options.margin_m;
        const auto margin_m = MarginByHand(world, options, NameOf(b), {object.name, ""}, default_m);
        if (!margin_m) continue;
        const PreparedPart& mine = body.geometry->parts[b];
        for (std::size_t o = 0; o < object.parts_W.size(); ++o) {
          const PreparedPart& theirs = object.geometry->parts[o];
          seen.push_back({Distance_m(mine, PoseOf(b), theirs, object.parts_W[o].X_WP),
                          *margin_m + Deviation_m(mine) + Deviation_m(theirs), static_cast<int>(i),
                          static_cast<int>(b), static_cast<int>(o)});
        }
      }
    }
    return seen;
  }
};

// Compares the answers for a row with the expected ones.
void CompareRow(const ByHand& hand, const CollisionColumns& verdicts, const PairColumns& distances,
                const PairColumns& contacts, std::size_t row) {
  const std::vector<ByHand::Seen> pairs = hand.Pairs();
  const auto collides = [](const ByHand::Seen& pair) { return pair.distance_m < pair.margin_m; };
  const bool collision = std::ranges::any_of(pairs, collides);
  EXPECT_EQ(verdicts.verdict[row], collision ? Verdict::kCollision : Verdict::kFree);
  if (verdicts.verdict[row] == Verdict::kCollision) {
    EXPECT_TRUE(std::ranges::any_of(pairs, [&](const ByHand::Seen& pair) {
      return collides(pair) && pair.object == verdicts.object[row] &&
             pair.body_part == verdicts.body_part[row] &&
             pair.object_part == verdicts.object_part[row];
    }));
  }
  double nearest_m = kInfinity;
  for (const ByHand::Seen& pair : pairs) nearest_m = std::min(nearest_m, pair.distance_m);
  const std::uint32_t at = distances.row_begin[row];
  if (pairs.empty()) {
    EXPECT_EQ(distances.row_begin[row + 1], at);
  } else {
    ASSERT_GT(distances.row_begin[row + 1], at);
    EXPECT_NEAR(distances.distance_m[at], nearest_m, 1e-9);
  }
  std::vector<std::array<int, 3>> expected, result;
  for (const ByHand::Seen& pair : pairs) {
    if (collides(pair)) expected.push_back({pair.object, pair.body_part, pair.object_part});
  }
  for (std::uint32_t k = contacts.row_begin[row]; k < contacts.row_begin[row + 1]; ++k) {
    result.push_back({contacts.object[k], contacts.body_part[k], contacts.object_part[k]});
  }
  std::ranges::sort(expected);
  std::ranges::sort(result);
  result.erase(std::unique(result.begin(), result.end()), result.end());
  EXPECT_EQ(result, expected);
}

void CompareAll(const WorldSnapshot& world, const QueryBody& body, std::vector<Part> names,
                const BodyRows& rows, QueryOptions options) {
  options.max_contacts = 1'000;
  const auto verdicts = CheckCollisions(world, body, rows, options);
  const auto distances = GetDistances(world, body, rows, options);
  const auto contacts = GetContacts(world, body, rows, options);
  ASSERT_TRUE(verdicts.ok() && distances.ok() && contacts.ok());
  for (std::size_t row = 0; row < rows.size(); ++row) {
    ByHand hand{world, body, options, names, {}};
    hand.X_WF.resize(static_cast<std::size_t>(body.frame_count), Pose::Identity());
    rows.Place(row, hand.X_WF);
    CompareRow(hand, *verdicts, *distances, *contacts, row);
  }
}

QueryOptions DrawnOptions(Drawn& draw) {
  QueryOptions options;
  options.margin_m = draw.Index(2) == 0 ? draw.Below(0.05) : 0;
  options.margin_sigma = draw.Index(2) == 0 ? draw.Below(3) : 0;
  for (int i = draw.Index(3); i > 0; --i) options.ignore_pairs.push_back(draw.Pair());
  return options;
}

TEST(PairRulesOfQueries, OfARobotAreThoseOfEachPairReadByHand) {
  const auto robot = BallArm();
  std::vector<Part> names;
  for (const ModelLink& link : robot->model->links) names.push_back({"arm", link.name});
  for (unsigned seed = 0; seed < 60; ++seed) {
    Drawn draw(seed);
    const SnapshotPtr world = RuledWorld(draw, draw.Index(12));
    WorldRobot arm;
    arm.name = "arm";
    arm.robot = robot;
    std::vector<double> states;
    for (int i = 0; i < 20; ++i) states.push_back(draw.Below(6) - 3);
    const JointRows rows(*robot->model, robot->model->all,
                         {.X_WB = RandomPose(draw.random(), 0.5),
                          .base = DefaultVariables(*robot->model),
                          .rows = states});
    CompareAll(*world, BodyFromRobot(arm, RobotScope::kBoth), names, rows, DrawnOptions(draw));
  }
}

TEST(PairRulesOfQueries, OfShapesAndOfAnObjectAreThoseOfEachPairReadByHand) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    Drawn draw(seed);
    const SnapshotPtr world = RuledWorld(draw, draw.Index(12));
    const std::vector<Pose> poses = RandomPoses(10, draw.random());
    CompareAll(*world, Gripper(), {{"", ""}}, PoseRows(poses), DrawnOptions(draw));
    const WorldObject& object = *world->objects()[0];
    CompareAll(*world, BodyFromObject(object), {{object.name, ""}}, PoseRows(poses),
               DrawnOptions(draw));
  }
}

QueryBody BallBody() { return BodyFromShapes({{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}}); }

// A ball of 0.1 m at the origin and one at x = 0.5 m.
SnapshotPtr TwoBalls() {
  return WorldOf(
      {PutOf("near", {{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}}, Pose::Identity()),
       PutOf("off", {{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}},
             MakeTranslation(0.5, 0, 0))});
}

TEST(PairRulesOfQueries, AnAllowedPairIsSeenByNoQuestion) {
  const auto world = With(TwoBalls(), {Allow({"*"}, {"near"})});
  const std::vector<Pose> poses = {
      MakeTranslation(0.1, 0, 0)};  // 0.3 m from the other ball's centre
  EXPECT_THAT(CheckCollisions(*world, BallBody(), poses, {})->verdict, ElementsAre(Verdict::kFree));
  EXPECT_THAT(GetDistances(*world, BallBody(), poses, {})->distance_m,
              ElementsAre(::testing::DoubleNear(0.2, 1e-9)));
  EXPECT_THAT(GetContacts(*world, BallBody(), poses, {})->distance_m, IsEmpty());
}

TEST(PairRulesOfQueries, AMarginReplacesThoseOfBothAndOfTheRequest) {
  const std::vector<Pose> poses = {MakeTranslation(-0.25, 0, 0)};  // 0.05 m from the first
  const auto verdict = [&](const SnapshotPtr& world, double request_m) {
    return CheckCollisions(*world, BallBody(), poses, {.margin_m = request_m})->verdict[0];
  };
  EXPECT_EQ(verdict(TwoBalls(), 0.06), Verdict::kCollision);
  EXPECT_EQ(verdict(With(TwoBalls(), {Margin({"*"}, {"near"}, 0.04)}), 0.06), Verdict::kFree);
  const auto wide = With(TwoBalls(), {Margin({"*"}, {"near"}, 0.06)});
  EXPECT_EQ(verdict(wide, 0), Verdict::kCollision);
  EXPECT_THAT(GetContacts(*wide, BallBody(), poses, {})->distance_m,
              ElementsAre(::testing::DoubleNear(0.05, 1e-9)));
}

TEST(PairRulesOfQueries, TheMorePreciseMarginHolds) {
  const auto world = With(TwoBalls(), {Margin({"*"}, {"*"}, 0.5), Margin({"*"}, {"near"}, 0.04)});
  const std::vector<Pose> poses = {MakeTranslation(-0.25, 0, 0)};
  // Margin 0.04 for the near ball; 0.5 for the other, which is 0.55 m away.
  EXPECT_THAT(CheckCollisions(*world, BallBody(), poses, {})->verdict, ElementsAre(Verdict::kFree));
  const auto of_two =
      With(TwoBalls(), {Margin({"near"}, {"off"}, 0.2), Margin({"near"}, {"*"}, 0.4)});
  // "near" is the body, 0.3 m from "off": the rule with both names applies.
  EXPECT_THAT(CheckCollisions(*of_two, BodyFromObject(*of_two->Find("near")),
                              std::vector<Pose>{Pose::Identity()}, {})
                  ->verdict,
              ElementsAre(Verdict::kFree));
}

TEST(PairRulesOfQueries, DeviationsOfAFitAreMarginsToo) {
  auto model = std::make_shared<HybridModel>();
  model->shapes.push_back({.X_OS = Pose::Identity(),
                           .shape = Sphere{0.1},
                           .fit = FitQuality{.rms_m = 1, .parameter_sigma = {0, 0, 0.003, 0.002}}});
  PutObject put;
  put.name = "ball";
  put.geometry = Prepare(std::move(model));
  const auto world = WorldOf({{.what = put, .expected_object_revision = {}}});
  const std::vector<Pose> poses = {MakeTranslation(0.21, 0, 0)};  // 0.01 m away: two deviations
  const auto verdict = [&](const SnapshotPtr& of, double sigmas) {
    return CheckCollisions(*of, BallBody(), poses, {.margin_sigma = sigmas})->verdict[0];
  };
  EXPECT_EQ(verdict(world, 0), Verdict::kFree);
  EXPECT_EQ(verdict(world, 1.99), Verdict::kFree);
  EXPECT_EQ(verdict(world, 2.01), Verdict::kCollision);
  // The standard deviations are added to the margin of a rule.
  const auto ruled = With(world, {Margin({"*"}, {"ball"}, 0.005)});
  EXPECT_EQ(verdict(ruled, 0.99), Verdict::kFree);
  EXPECT_EQ(verdict(ruled, 1.01), Verdict::kCollision);
}

}  // namespace
}  // namespace cwm::collision
