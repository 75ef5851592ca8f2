#include "collision/query/query.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "collision/geometry/validation.h"
#include "collision/query/body_search.h"
#include "tests/collision/geometry/unshared.h"
#include "tests/collision/query/random_world.h"

namespace cwm::collision {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// All pairs, computed one by one without a broad phase, in the order that breaks ties.
struct BrutePair {
  double distance_m;
  int object, body_part, object_part;
};

std::vector<BrutePair> BrutePairs(const WorldSnapshot& world, const QueryBody& body,
                                  const Pose& X_WB) {
  const Engine& exact = GetEngine(EngineKind::kExact);
  std::vector<BrutePair> pairs;
  for (std::size_t i = 0; i < world.objects().size(); ++i) {
    const WorldObject& object = *world.objects()[i];
    for (std::size_t b = 0; b < body.geometry->parts.size(); ++b) {
      for (std::size_t o = 0; o < object.geometry->parts.size(); ++o) {
        const PreparedPart& mine = body.geometry->parts[b];
        const PreparedPart& theirs = object.geometry->parts[o];
        const Pose X_WP = X_WB * mine.X_OP;
        const Pose X_WQ = object.X_WO * theirs.X_OP;
        const PairDistance answer =
            exact.Distance({KindOf(mine.shape), *mine.engines[0], X_WP},
                           {KindOf(theirs.shape), *theirs.engines[0], X_WQ}, kInfinity);
        pairs.push_back({answer.distance_m, int(i), int(b), int(o)});
      }
    }
  }
  return pairs;
}

// The nearest pair of each object, nearest object first.
std::vector<BrutePair> BruteNearest(const std::vector<BrutePair>& pairs) {
  std::vector<BrutePair> nearest;
  for (const BrutePair& pair : pairs) {
    if (nearest.empty() || nearest.back().object != pair.object) {
      nearest.push_back(pair);
    } else if (pair.distance_m < nearest.back().distance_m) {
      nearest.back() = pair;
    }
  }
  std::stable_sort(nearest.begin(), nearest.end(),
                   [](const auto& a, const auto& b) { return a.distance_m < b.distance_m; });
  return nearest;
}

class QueryTest : public ::testing::Test {
 protected:
  std::mt19937 random_{42};
  std::shared_ptr<const WorldSnapshot> world_ = RandomWorld(30, random_, /*with_meshes=*/true);
  QueryBody body_ = Gripper();
  std::vector<Pose> poses_ = RandomPoses(150, random_);
};

TEST_F(QueryTest, TheNearestObjectsAreThoseOfBruteForce) {
  for (const int max_results : {1, 3, 100}) {
    QueryOptions options;
    options.max_results = max_results;
    const PairColumns columns = *GetDistances(*world_, body_, poses_, options);
    ASSERT_EQ(columns.completed, poses_.size());
    ASSERT_EQ(columns.row_begin.size(), poses_.size() + 1);
    for (std::size_t row = 0; row < poses_.size(); ++row) {
      const auto expected = BruteNearest(BrutePairs(*world_, body_, poses_[row]));
      const std::size_t begin = columns.row_begin[row];
      ASSERT_EQ(columns.row_begin[row + 1] - begin,
                std::min<std::size_t>(max_results, expected.size()));
      for (std::size_t k = begin; k < columns.row_begin[row + 1]; ++k) {
        EXPECT_NEAR(columns.distance_m[k], expected[k - begin].distance_m, 1e-7);
        EXPECT_EQ(columns.object[k], expected[k - begin].object);
        EXPECT_EQ(columns.body_part[k], expected[k - begin].body_part);
        EXPECT_EQ(columns.object_part[k], expected[k - begin].object_part);
      }
    }
  }
}

TEST_F(QueryTest, ObjectsBeyondTheLimitAreNotReported) {
  QueryOptions options;
  options.max_results = 100;
  options.max_distance_m = 0.4;
  const PairColumns columns = *GetDistances(*world_, body_, poses_, options);
  for (std::size_t row = 0; row < poses_.size(); ++row) {
    auto expected = BruteNearest(BrutePairs(*world_, body_, poses_[row]));
    std::erase_if(expected, [](const BrutePair& p) { return p.distance_m > 0.4; });
    EXPECT_EQ(columns.row_begin[row + 1] - columns.row_begin[row], expected.size());
  }
}

TEST_F(QueryTest, WitnessesAndNormalGoFromTheBodyToTheObject) {
  const PairColumns columns = *GetDistances(*world_, body_, poses_, {});
  for (std::size_t k = 0; k < columns.distance_m.size(); ++k) {
    const Eigen::Map<const Vector3> body(&columns.point_body[3 * k]);
    const Eigen::Map<const Vector3> object(&columns.point_object[3 * k]);
    const Eigen::Map<const Vector3> normal(&columns.normal[3 * k]);
    EXPECT_LT((object - body - columns.distance_m[k] * normal).norm(), 1e-7);
    EXPECT_NEAR(normal.norm(), 1, 1e-9);
  }
}

TEST_F(QueryTest, AStateCollidesWhenSomePairIsNearerThanTheMargin) {
  for (const double margin_m : {0.0, 0.05}) {
    QueryOptions options;
    options.margin_m = margin_m;
    const CollisionColumns columns = *CheckCollisions(*world_, body_, poses_, options);
    ASSERT_EQ(columns.completed, poses_.size());
    int collisions = 0;
    for (std::size_t row = 0; row < poses_.size(); ++row) {
      const auto pairs = BrutePairs(*world_, body_, poses_[row]);
      const bool collides = std::any_of(
          pairs.begin(), pairs.end(), [&](const BrutePair& p) { return p.distance_m < margin_m; });
      EXPECT_EQ(columns.verdict[row], collides ? Verdict::kCollision : Verdict::kFree);
      EXPECT_EQ(columns.object[row] >= 0, collides);
      if (!collides) continue;
      ++collisions;
      const auto result = std::find_if(pairs.begin(), pairs.end(), [&](const BrutePair& p) {
        return p.object == columns.object[row] && p.body_part == columns.body_part[row] &&
               p.object_part == columns.object_part[row];
      });
      ASSERT_NE(result, pairs.end());
      EXPECT_LT(result->distance_m, margin_m);
    }
    EXPECT_GT(collisions, 5);
    EXPECT_LT(collisions, 145);
  }
}

TEST_F(QueryTest, TheMarginOfAnObjectAddsToThatOfTheRequest) {
  PutObject put;
  put.name = "ball";
  put.geometry = ModelOf({{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}});
  put.margin_m = 0.02;
  const auto world = WorldOf({{.what = put, .expected_object_revision = {}}});
  const QueryBody point = BodyFromShapes({{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}});
  const std::vector<Pose> at = {MakeTranslation(0.2495, 0, 0), MakeTranslation(0.2505, 0, 0)};
  QueryOptions options;
  options.margin_m = 0.03;  // together 0.05
  const CollisionColumns columns = *CheckCollisions(*world, point, at, options);
  EXPECT_THAT(columns.verdict, ElementsAre(Verdict::kCollision, Verdict::kFree));
  EXPECT_EQ(GetContacts(*world, point, at, options)->row_begin[2], 1u);
}

TEST(Query, TheMarginOfTheObjectThatAsksCountsAsMuchAsThatOfTheOther) {
  Change wide = PutOf("a", {{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}}, Pose::Identity());
  std::get<PutObject>(wide.what).margin_m = 0.05;
  const auto world = WorldOf({wide, PutOf("b", {{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}},
                                          MakeTranslation(0.23, 0, 0))});
  for (const char* name : {"a", "b"}) {
    const auto object = world->Find(name);
    const QueryBody body = BodyFromObject(*object);
    const std::vector<Pose> at = {object->X_WO};
    QueryOptions options;
    EXPECT_EQ(CheckCollisions(*world, body, at, options)->verdict[0], Verdict::kCollision) << name;
    EXPECT_EQ(GetContacts(*world, body, at, options)->row_begin[1], 1u) << name;
    EXPECT_NEAR(GetDistances(*world, body, at, options)->distance_m[0], 0.03, 1e-12) << name;
    options.margin_m = -0.03;  // the pair's margin is then 2 cm, the gap 3 cm
    EXPECT_EQ(CheckCollisions(*world, body, at, options)->verdict[0], Verdict::kFree) << name;
    EXPECT_EQ(GetContacts(*world, body, at, options)->row_begin[1], 0u) << name;
  }
}

TEST(Query, ARepresentationChoosesTheParts) {
  auto model = std::make_shared<HybridModel>();
  model->shapes.push_back({.X_OS = MakeTranslation(1, 0, 0),
                           .shape = Sphere{0.1},
                           .role = PartRole::kFitted,
                           .fit = {}});
  TriangleMesh moved = BoxMesh({0.2, 0.2, 0.2});
  for (Vector3& v : moved.vertices) v.x() += 2;
  model->surfaces.push_back({.surface = MakeMesh(moved), .point_count = 0});
  PutObject put;
  put.name = "hybrid";
  put.geometry = Prepare(model);
  const auto world = WorldOf({{.what = put, .expected_object_revision = {}}});
  const QueryBody probe = BodyFromShapes({{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}});
  const std::vector<Pose> at = {MakeTranslation(1.4, 0, 0)};
  QueryOptions options;
  EXPECT_NEAR(GetDistances(*world, probe, at, options)->distance_m[0], 0.2, 1e-9);
  options.representation = Representation::kSurfaces;
  const PairColumns surfaces = *GetDistances(*world, probe, at, options);
  EXPECT_NEAR(surfaces.distance_m[0], 0.4, 1e-9);
  EXPECT_THAT(surfaces.object_part, ElementsAre(1));
  options.representation = Representation::kShapes;
  EXPECT_NEAR(GetDistances(*world, probe, at, options)->distance_m[0], 0.2, 1e-9);
}

TEST(Query, EquallyNearObjectsAreNamedInTheOrderOfTheirNames) {
  std::vector<Change> changes;
  for (const char* name : {"d", "b", "a", "c"}) {
    const double side = (name[0] - 'a') % 2 == 0 ? 1 : -1;
    changes.push_back(
        PutOf(name, {{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}},
              MakeTranslation(side * (name[0] < 'c' ? 1 : 0), side * (name[0] < 'c' ? 0 : 1), 0)));
  }
  const auto world = WorldOf(changes);
  const QueryBody probe = BodyFromShapes({{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}});
  QueryOptions options;
  const std::vector<Pose> at = {Pose::Identity()};
  EXPECT_THAT(GetDistances(*world, probe, at, options)->object, ElementsAre(0));
  options.max_results = 4;
  EXPECT_THAT(GetDistances(*world, probe, at, options)->object, ElementsAre(0, 1, 2, 3));
}

TEST(Query, AClosedMeshContainsWithEveryEngine) {
  const TriangleMesh shared = BoxMesh({1, 1, 1});
  const QueryBody cup = BodyFromShapes({{.X_FS = Pose::Identity(), .shape = Cylinder{0.04, 0.1}}});
  const std::vector<Pose> at = {MakeTranslation(0.1, 0.2, 0.1)};
  for (const TriangleMesh& mesh : {shared, Unshared(shared)}) {
    const auto world = WorldOf({PutOf("cupboard", {{.shape = MakeMesh(mesh)}}, Pose::Identity())});
    for (const EngineChoice engine :
         {EngineChoice::kAuto, EngineChoice::kExact, EngineChoice::kFcl, EngineChoice::kBullet}) {
      QueryOptions options;
      options.engine = engine;
      const CollisionColumns result = *CheckCollisions(*world, cup, at, options);
      EXPECT_EQ(result.verdict[0], Verdict::kCollision);
      EXPECT_NE(result.accuracy[0], Accuracy::kSurfaceOnly);
      EXPECT_LT(GetDistances(*world, cup, at, options)->distance_m[0], 0);
    }
  }
}

TEST(Query, APairThatTheEngineCannotAnswerIsNamed) {
  const Shape cube = MakeMesh(BoxMesh({1, 1, 1}));
  const auto world =
      WorldOf({PutOf("m", {{.X_FS = Pose::Identity(), .shape = cube}}, Pose::Identity())});
  const QueryBody mesh = BodyFromShapes({{.X_FS = Pose::Identity(), .shape = cube}});
  const std::vector<Pose> at = {MakeTranslation(0, 0, 1.5)};
  QueryOptions options;
  options.engine = EngineChoice::kBullet;
  options.max_distance_m = 1;
  const std::vector<Pose> far_and_near = {MakeTranslation(0, 0, 9), at[0]};
  const auto refused = GetDistances(*world, mesh, far_and_near, options);
  EXPECT_EQ(refused.status().code(), absl::StatusCode::kUnimplemented);
  for (const char* part : {"row 1", "BULLET", "mesh", "'m'", "shapes[0]", "body part 0"}) {
    EXPECT_THAT(std::string(refused.status().message()), HasSubstr(part));
  }
  EXPECT_TRUE(GetContacts(*world, mesh, at, options).ok());  // out of reach: the pair is skipped
  const std::vector<Pose> touching = {MakeTranslation(0, 0, 0.9)};
  EXPECT_EQ(CheckCollisions(*world, mesh, touching, options).status().code(),
            absl::StatusCode::kUnimplemented);
}

TEST(Query, EveryEngineAnswersAboutAHalfSpace) {
  const auto world = WorldOf(
      {PutOf("floor", {{.X_FS = Pose::Identity(), .shape = HalfSpace{}}}, Pose::Identity())});
  const QueryBody box = BodyFromShapes({{.X_FS = Pose::Identity(), .shape = Box{{1, 1, 1}}}});
  const std::vector<Pose> at = {MakeTranslation(0, 0, 1), MakeTranslation(0, 0, 0.4)};
  for (const EngineChoice engine :
       {EngineChoice::kExact, EngineChoice::kFcl, EngineChoice::kBullet}) {
    QueryOptions options;
    options.engine = engine;
    const auto distances = GetDistances(*world, box, at, options);
    ASSERT_TRUE(distances.ok()) << distances.status();
    EXPECT_NEAR(distances->distance_m[0], 0.5, 1e-12);
    EXPECT_NEAR(distances->distance_m[1], -0.1, 1e-12);
    EXPECT_EQ(distances->accuracy[0], Accuracy::kExact);
    const CollisionColumns result = *CheckCollisions(*world, box, at, options);
    EXPECT_EQ(result.verdict[0], Verdict::kFree);
    EXPECT_EQ(result.verdict[1], Verdict::kCollision);
    EXPECT_EQ(result.accuracy[1], Accuracy::kExact);
  }
}

TEST(Query, YesAndNoOfASearchOfFclAreLabelledAsBestEffort) {
  const auto world = WorldOf(
      {PutOf("can", {{.X_FS = Pose::Identity(), .shape = Cylinder{0.5, 1}}}, Pose::Identity())});
  const QueryBody box = BodyFromShapes({{.X_FS = Pose::Identity(), .shape = Box{{1, 1, 1}}}});
  const std::vector<Pose> at = {MakeTranslation(1.1, 1.1, 0), MakeTranslation(0.99, 0, 0.9),
                                MakeTranslation(0.9, 0, 0)};
  QueryOptions options;
  options.engine = EngineChoice::kFcl;
  const CollisionColumns result = *CheckCollisions(*world, box, at, options);
  EXPECT_EQ(result.accuracy[0], Accuracy::kExact) << "by their boxes";
  EXPECT_EQ(result.accuracy[2], Accuracy::kDegraded);
  // With a margin the verdict is proven by a distance.
  options.margin_m = 0.01;
  EXPECT_EQ(CheckCollisions(*world, box, at, options)->accuracy[2], Accuracy::kExact);
  options = {};
  EXPECT_EQ(CheckCollisions(*world, box, at, options)->accuracy[2], Accuracy::kExact);
}

// A floor, a slope and a ceiling, checked with a half-space that faces down.
TEST(Query, HalfSpacesAreAskedOfEachOtherAndFailNoBatch) {
  const Shape half = HalfSpace{};
  const Quaternion down(0, 1, 0, 0);
  const auto world = WorldOf(
      {PutOf("ceiling", {{.X_FS = Pose::Identity(), .shape = half}}, MakePose({0, 0, 3}, down)),
       PutOf("floor", {{.X_FS = Pose::Identity(), .shape = half}}, Pose::Identity())});
  const QueryBody body = BodyFromShapes({{.X_FS = Pose::Identity(), .shape = half}});
  const std::vector<Pose> at = {MakePose({0, 0, 1}, down), MakePose({0, 0, -0.5}, down),
                                MakeTranslation(0, 0, -1)};
  for (const EngineChoice engine : {EngineChoice::kAuto, EngineChoice::kExact}) {
    QueryOptions options{.engine = engine, .max_results = 2, .ignore = {"ceiling"}};
    EXPECT_THAT(CheckCollisions(*world, body, at, options)->verdict,
                ElementsAre(Verdict::kFree, Verdict::kCollision, Verdict::kCollision));
    const PairColumns near = *GetDistances(*world, body, at, options);
    EXPECT_THAT(near.distance_m,
                ElementsAre(::testing::DoubleNear(1, 1e-12), ::testing::DoubleNear(-0.5, 1e-12),
                            -kMaxCoordinate_m));
    EXPECT_THAT(near.accuracy,
                ElementsAre(Accuracy::kExact, Accuracy::kExact, Accuracy::kDegraded));
    EXPECT_THAT(GetContacts(*world, body, at, options)->row_begin, ElementsAre(0, 0, 1, 2));
    options.ignore = {"floor"};
    EXPECT_THAT(CheckCollisions(*world, body, at, options)->verdict,
                ElementsAre(Verdict::kCollision, Verdict::kCollision, Verdict::kFree));
    options.margin_m = 4.1;
    EXPECT_THAT(CheckCollisions(*world, body, {&at[2], 1}, options)->verdict,
                ElementsAre(Verdict::kCollision));
  }
}

// A truncated cone that FCL and Bullet represent as a circumscribed prism of 64 sides.
TEST(Query, AStateWithinTheBoundOfAStandInIsUndecidedByFclAndBullet) {
  const Cone cup{0.04, 0.07, 0.12};
  const auto world =
      WorldOf({PutOf("cup", {{.X_FS = Pose::Identity(), .shape = cup}}, Pose::Identity())});
  const QueryBody ball = BodyFromShapes({{.X_FS = Pose::Identity(), .shape = Sphere{0.05}}});
  // Diagonal positions, where the bounding boxes overlap, towards an edge of the prism.
  const auto beside = [](double gap_m) {
    const double along_m = (0.07 + 0.05 + gap_m) / std::sqrt(2);
    return MakeTranslation(along_m, along_m, 0.06);
  };
  // The prism exceeds the cone by 0.07 (1 / cos(pi / 64) - 1) = 8.4e-5 m.
  const std::vector<Pose> at = {beside(-1e-3), beside(1e-4), beside(1e-3)};
  for (const EngineChoice engine : {EngineChoice::kFcl, EngineChoice::kBullet}) {
    QueryOptions options;
    options.engine = engine;
    const CollisionColumns result = *CheckCollisions(*world, ball, at, options);
    EXPECT_THAT(result.verdict,
                ElementsAre(Verdict::kCollision, Verdict::kUndecided, Verdict::kFree));
    EXPECT_THAT(result.object, ElementsAre(0, 0, -1));
    EXPECT_NE(result.accuracy[1], Accuracy::kExact);
  }
  const CollisionColumns exact = *CheckCollisions(*world, ball, at, {});
  EXPECT_THAT(exact.verdict, ElementsAre(Verdict::kCollision, Verdict::kFree, Verdict::kFree));
  EXPECT_THAT(exact.accuracy, ::testing::Each(Accuracy::kExact));
}

TEST_F(QueryTest, NoEngineDecidesWhatTheExactKernelsRefute) {
  for (const EngineChoice engine : {EngineChoice::kFcl, EngineChoice::kBullet}) {
    for (const double margin_m : {0.0, 0.03}) {
      QueryOptions options;
      options.engine = engine;
      options.margin_m = margin_m;
      const CollisionColumns result = *CheckCollisions(*world_, body_, poses_, options);
      int decided = 0;
      for (std::size_t row = 0; row < poses_.size(); ++row) {
        double nearest_m = kInfinity;
        for (const BrutePair& pair : BrutePairs(*world_, body_, poses_[row])) {
          nearest_m = std::min(nearest_m, pair.distance_m);
        }
        if (result.verdict[row] == Verdict::kUndecided) continue;
        ++decided;
        EXPECT_EQ(result.verdict[row], nearest_m < margin_m ? Verdict::kCollision : Verdict::kFree)
            << row << ' ' << nearest_m;
      }
      // FCL's distances to meshes within the margin's reach are undecided.
      EXPECT_GE(decided, margin_m == 0 ? 149 : 110);
    }
  }
}

TEST_F(QueryTest, TheSameQuestionGivesTheSameBytesWhateverTheOrderOfInsertion) {
  std::vector<Change> changes;
  for (const WorldObjectPtr& object : world_->objects()) {
    PutObject put;
    put.name = object->name;
    put.X_WO = object->X_WO;
    put.geometry = object->geometry;
    changes.push_back({.what = put, .expected_object_revision = {}});
  }
  QueryOptions options;
  options.max_results = 3;
  const PairColumns distances = *GetDistances(*world_, body_, poses_, options);
  const CollisionColumns verdicts = *CheckCollisions(*world_, body_, poses_, options);
  for (int round = 0; round < 3; ++round) {
    std::shuffle(changes.begin(), changes.end(), random_);
    auto world = std::make_shared<const WorldSnapshot>();
    for (const Change& change : changes) world = *Apply(world, {&change, 1});
    EXPECT_EQ(GetDistances(*world, body_, poses_, options)->distance_m, distances.distance_m);
    EXPECT_EQ(GetDistances(*world, body_, poses_, options)->object, distances.object);
    EXPECT_EQ(CheckCollisions(*world, body_, poses_, options)->object, verdicts.object);
  }
}

TEST(BodySearch, AsksPairsWithinReachAloneAndNarrowsAsToldTo) {
  const auto world = WorldOf({PutOf("pair",
                                    {{.X_FS = MakeTranslation(1, 0, 0), .shape = Sphere{0.1}},
                                     {.X_FS = MakeTranslation(3, 0, 0), .shape = Sphere{0.1}}},
                                    Pose::Identity())});
  const QueryBody probe = BodyFromShapes({{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}});
  BodySearch search(*world, probe, {}, {});
  const Pose X_WB = Pose::Identity();
  search.PlaceBody(PoseRows({&X_WB, 1}), 0);
  const auto visited = [&](double reach_m, double narrowed_m) {
    std::vector<int> parts;
    search.ForEachPair(*world->Find("pair"), BodySearch::From::kSurface, reach_m,
                       QueryKind::kDistance, [&](const auto& pair) {
                         parts.push_back(pair.id.object_part);
                         return narrowed_m;
                       });
    return parts;
  };
  EXPECT_THAT(visited(0.7, 0.7), IsEmpty());  // the boxes are 0.8 m and 2.8 m apart
  EXPECT_THAT(visited(0.9, 0.9), ElementsAre(0));
  EXPECT_THAT(visited(3, 3), ElementsAre(0, 1));
  EXPECT_THAT(visited(3, 1), ElementsAre(0));
  EXPECT_TRUE(search.Finish().ok());
}

TEST(Query, TheDepthOfSeveralPartsIsLabelledAsABound) {
  const auto world = WorldOf({PutOf("pair",
                                    {{.X_FS = MakeTranslation(-0.1, 0, 0), .shape = Sphere{0.1}},
                                     {.X_FS = MakeTranslation(0.1, 0, 0), .shape = Sphere{0.1}}},
                                    Pose::Identity())});
  const QueryBody probe = BodyFromShapes({{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}});
  const std::vector<Pose> at = {Pose::Identity()};
  const PairColumns columns = *GetDistances(*world, probe, at, {});
  EXPECT_NEAR(columns.distance_m[0], -0.1, 1e-12);
  EXPECT_THAT(columns.accuracy, ElementsAre(Accuracy::kBounded));
  // To leave sideways the probe must move sqrt(0.2^2 - 0.1^2), which the bound must include.
  EXPECT_GE(columns.bound_m[0], std::sqrt(0.03) - 0.1);
}

TEST_F(QueryTest, AStoppedQuestionIsCancelled) {
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(GetDistances(*world_, body_, poses_, {}, stop.get_token()).status().code(),
            absl::StatusCode::kCancelled);
  EXPECT_EQ(CheckCollisions(*world_, body_, poses_, {}, stop.get_token()).status().code(),
            absl::StatusCode::kCancelled);
  EXPECT_EQ(GetContacts(*world_, body_, poses_, {}, stop.get_token()).status().code(),
            absl::StatusCode::kCancelled);
  const std::vector<RayRow> rays(1, {{0, 0, 0}, {1, 0, 0}, 1});
  EXPECT_EQ(CastRays(*world_, rays, {}, stop.get_token()).status().code(),
            absl::StatusCode::kCancelled);
}

TEST_F(QueryTest, WhenTimeIsUpTheCompletedPrefixIsTheAnswer) {
  QueryOptions options;
  options.deadline = std::chrono::steady_clock::now() - std::chrono::seconds(1);
  const PairColumns none = *GetDistances(*world_, body_, poses_, options);
  EXPECT_EQ(none.completed, 0u);
  EXPECT_THAT(none.row_begin, ElementsAre(0u));
  const CollisionColumns verdicts = *CheckCollisions(*world_, body_, poses_, options);
  EXPECT_EQ(verdicts.completed, 0u);
  EXPECT_THAT(verdicts.verdict, ::testing::Each(Verdict::kNotComputed));
  EXPECT_THAT(verdicts.accuracy, ::testing::Each(Accuracy::kDegraded)) << "nothing is known";

  std::vector<Pose> many(200'000, poses_[0]);
  options.deadline = std::chrono::steady_clock::now() + std::chrono::milliseconds(20);
  const PairColumns part = *GetDistances(*world_, body_, many, options);
  const PairColumns whole = *GetDistances(*world_, body_, {poses_.data(), 1}, {});
  ASSERT_GT(part.completed, 0u);
  EXPECT_EQ(part.row_begin.size(), part.completed + 1);
  EXPECT_EQ(part.distance_m.size(), part.row_begin.back());
  EXPECT_EQ(part.distance_m.back(), whole.distance_m[0]);
}

TEST(Query, AnEmptyWorldAndAnEmptyBatchAreAnswered) {
  const WorldSnapshot empty;
  const std::vector<Pose> at = {Pose::Identity()};
  EXPECT_EQ(CheckCollisions(empty, Gripper(), at, {})->verdict[0], Verdict::kFree);
  EXPECT_THAT(GetDistances(empty, Gripper(), at, {})->row_begin, ElementsAre(0u, 0u));
  EXPECT_THAT(GetDistances(empty, Gripper(), std::span<const Pose>(), {})->row_begin,
              ElementsAre(0u));
  EXPECT_EQ(CastRays(empty, {}, {})->completed, 0u);
}

}  // namespace
}  // namespace cwm::collision
