#include "collision/world/world_snapshot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

namespace cwm::collision {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using SnapshotPtr = std::shared_ptr<const WorldSnapshot>;

std::shared_ptr<const PreparedModel> ModelOf(Shape shape) {
  auto model = std::make_shared<HybridModel>();
  model->shapes.push_back(
      {.X_OS = Pose::Identity(), .shape = std::move(shape), .role = PartRole::kFitted, .fit = {}});
  return Prepare(std::move(model));
}

PutObject Put(const std::string& name, Shape shape, const Pose& X_WO = Pose::Identity()) {
  PutObject put;
  put.name = name;
  put.X_WO = X_WO;
  put.geometry = ModelOf(std::move(shape));
  return put;
}

Change MakeChange(PutObject put) {
  return {.what = std::move(put), .expected_object_revision = {}};
}
Change Move(const std::string& name, double x_m) {
  return {.what = MoveObject{name, MakeTranslation(x_m, 0, 0)}, .expected_object_revision = {}};
}
Change Remove(const std::string& name) {
  return {.what = RemoveObject{name}, .expected_object_revision = {}};
}

SnapshotPtr MustApply(const SnapshotPtr& base, const std::vector<Change>& changes) {
  auto next = Apply(base, changes);
  EXPECT_TRUE(next.ok()) << next.status();
  return next.ok() ? *next : base;
}

SnapshotPtr Empty() { return std::make_shared<const WorldSnapshot>(); }

std::vector<std::string> Names(const WorldSnapshot& world) {
  std::vector<std::string> names;
  for (const auto& object : world.objects()) names.push_back(object->name);
  return names;
}

TEST(Apply, OrdersObjectsByNameAndCountsOneRevision) {
  const auto world =
      MustApply(Empty(), {MakeChange(Put("cup", Sphere{0.1})), MakeChange(Put("box", Sphere{0.1})),
                          MakeChange(Put("a/b.c-d_1", Sphere{0.1}))});
  EXPECT_EQ(world->revision(), Revision{1});
  EXPECT_THAT(Names(*world), ElementsAre("a/b.c-d_1", "box", "cup"));
  EXPECT_EQ(world->Find("cup")->name, "cup");
  EXPECT_EQ(world->Find("cu"), nullptr);
  EXPECT_EQ(world->Find("cupp"), nullptr);
}

TEST(Apply, LeavesTheBaseAsItWas) {
  const auto before = MustApply(Empty(), {MakeChange(Put("cup", Sphere{0.1}))});
  const auto object = before->Find("cup");
  MustApply(before, {Move("cup", 3), MakeChange(Put("new", Sphere{1}))});
  EXPECT_THAT(Names(*before), ElementsAre("cup"));
  EXPECT_EQ(before->Find("cup"), object);
  EXPECT_EQ(object->X_WO.translation(), Vector3::Zero());
}

TEST(Apply, AMoveChangesThePoseRevisionAloneAndSharesTheGeometry) {
  const auto before =
      MustApply(Empty(), {MakeChange(Put("cup", Sphere{0.1})), MakeChange(Put("pot", Sphere{1}))});
  const auto after = MustApply(before, {Move("cup", 3)});
  const auto cup = after->Find("cup");
  EXPECT_EQ(cup->geometry, before->Find("cup")->geometry);
  EXPECT_EQ(cup->Uid(), before->Find("cup")->Uid());
  EXPECT_EQ(cup->create_revision, Revision{1});
  EXPECT_EQ(cup->geometry_revision, Revision{1});
  EXPECT_EQ(cup->pose_revision, Revision{2});
  EXPECT_NEAR(cup->bounds_W.min().x(), 2.9, 1e-12);
  EXPECT_EQ(after->Find("pot"), before->Find("pot"));  // the same pointer
}

TEST(Apply, AReplacedModelChangesTheGeometryRevisionAlone) {
  const auto before = MustApply(Empty(), {MakeChange(Put("cup", Sphere{0.1}))});
  const auto after = MustApply(before, {MakeChange(Put("cup", Sphere{0.2}))});
  EXPECT_EQ(after->Find("cup")->geometry_revision, Revision{2});
  EXPECT_EQ(after->Find("cup")->pose_revision, Revision{1});
  EXPECT_EQ(after->Find("cup")->Uid(), before->Find("cup")->Uid());
  EXPECT_NEAR(after->Find("cup")->bounds_W.max().x(), 0.2, 1e-12);
}

TEST(Apply, WhatHasNoEffectReturnsTheBaseItself) {
  const auto world = MustApply(Empty(), {MakeChange(Put("cup", Sphere{0.1}))});
  EXPECT_EQ(MustApply(world, {}), world);
  EXPECT_EQ(MustApply(world, {Move("cup", 0)}), world);
  EXPECT_EQ(MustApply(world, {MakeChange(Put("cup", Sphere{0.1}))}),
            world);  // equal, prepared again
  EXPECT_EQ(MustApply(world, {Move("cup", 1), Move("cup", 0)}), world);
  EXPECT_EQ(MustApply(world, {MakeChange(Put("new", Sphere{1})), Remove("new")}), world);
}

TEST(Apply, APutThatDiffersInOneAttributeHasAnEffect) {
  const auto world = MustApply(Empty(), {MakeChange(Put("cup", Sphere{0.1}))});
  for (const auto& alter : std::vector<std::function<void(PutObject&)>>{
           [](PutObject& p) { p.margin_m = 0.01; }, [](PutObject& p) { p.supported_by = "table"; },
           [](PutObject& p) { p.state = ObjectState::kOccluded; },
           [](PutObject& p) { p.owner = Owner::kPerception; },
           [](PutObject& p) { p.kind = ObjectKind::kObject; }}) {
    PutObject put = Put("cup", Sphere{0.1});
    alter(put);
    const auto next = MustApply(world, {MakeChange(put)});
    EXPECT_NE(next, world);
    EXPECT_EQ(next->Find("cup")->latest_revision(), Revision{1});
  }
}

TEST(Apply, ANameThatIsRemovedAndPutAgainIsAnotherObject) {
  const auto first = MustApply(Empty(), {MakeChange(Put("cup", Sphere{0.1}))});
  const auto again = MustApply(first, {Remove("cup"), MakeChange(Put("cup", Sphere{0.1}))});
  EXPECT_NE(again, first);
  EXPECT_NE(again->Find("cup")->Uid(), first->Find("cup")->Uid());
  EXPECT_EQ(again->Find("cup")->create_revision, Revision{2});
}

TEST(Apply, RefusesTheWholeListAndNamesTheBadChange) {
  const auto world = MustApply(Empty(), {MakeChange(Put("cup", Sphere{0.1}))});
  const std::vector<Change> changes = {MakeChange(Put("new", Sphere{1})), Move("cup", 1),
                                       Move("nil", 1)};
  const auto next = Apply(world, changes);
  EXPECT_EQ(next.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(next.status().message()), HasSubstr("changes[2]"));
  EXPECT_THAT(std::string(next.status().message()), HasSubstr("'nil'"));
  EXPECT_THAT(Names(*world), ElementsAre("cup"));
  const std::optional<ApplyFault> fault = FaultOf(next.status());
  ASSERT_TRUE(fault.has_value());
  EXPECT_EQ(fault->change, 2u);
  EXPECT_EQ(fault->field, "");
  EXPECT_THAT(fault->rule, HasSubstr("'nil'"));
}

TEST(Apply, ARefusalCarriesChangeFieldAndRule) {
  PutObject put = Put("new", Sphere{1});
  put.margin_m = -1;
  const auto refused =
      Apply(Empty(), std::vector{MakeChange(Put("a", Sphere{1})), MakeChange(put)});
  const std::optional<ApplyFault> fault = FaultOf(refused.status());
  ASSERT_TRUE(fault.has_value());
  EXPECT_EQ(fault->change, 1u);
  EXPECT_EQ(fault->field, "margin_m");
  EXPECT_EQ(fault->rule, "is -1, must be finite and not negative");
  EXPECT_EQ(FaultOf(absl::NotFoundError("elsewhere")), std::nullopt);
}

TEST(Apply, SeesEarlierChangesOfTheSameList) {
  EXPECT_EQ(Apply(Empty(), std::vector{MakeChange(Put("a", Sphere{1})), Remove("a"), Move("a", 1)})
                .status()
                .code(),
            absl::StatusCode::kNotFound);
  const auto world = MustApply(Empty(), {MakeChange(Put("a", Sphere{1})), Move("a", 2)});
  EXPECT_EQ(world->Find("a")->X_WO.translation().x(), 2);
}

TEST(Apply, ARevisionThatDoesNotMatchAborts) {
  const auto world = MustApply(Empty(), {MakeChange(Put("cup", Sphere{0.1}))});
  const auto moved = MustApply(world, {Move("cup", 1)});
  Change change = Move("cup", 2);
  change.expected_object_revision = Revision{1};
  const auto refused = Apply(moved, std::vector{change});
  EXPECT_EQ(refused.status().code(), absl::StatusCode::kAborted);
  EXPECT_THAT(std::string(refused.status().message()), HasSubstr("changes[0]"));
  change.expected_object_revision = Revision{2};
  EXPECT_EQ(MustApply(moved, {change})->revision(), Revision{3});
  Change on_missing = MakeChange(Put("none", Sphere{1}));
  on_missing.expected_object_revision = Revision{1};
  EXPECT_EQ(Apply(moved, std::vector{on_missing}).status().code(), absl::StatusCode::kAborted);
}

TEST(Apply, RefusesWhatNoWorldMayHold) {
  const auto refused = [](PutObject put) {
    return Apply(Empty(), std::vector{MakeChange(std::move(put))}).status().code() ==
           absl::StatusCode::kInvalidArgument;
  };
  EXPECT_TRUE(refused(Put("", Sphere{1})));
  EXPECT_TRUE(refused(Put("a b", Sphere{1})));
  EXPECT_TRUE(refused(Put("caf\xc3\xa9", Sphere{1})));
  EXPECT_TRUE(refused(Put(std::string(129, 'a'), Sphere{1})));
  EXPECT_FALSE(refused(Put(std::string(128, 'a'), Sphere{1})));
  EXPECT_TRUE(refused(Put("a", Sphere{1}, MakeTranslation(std::nan(""), 0, 0))));
  EXPECT_TRUE(refused(Put("a", Sphere{1}, MakeTranslation(1e30, 0, 0))));
  Pose sheared = Pose::Identity();
  sheared.linear()(0, 1) = 0.1;
  EXPECT_TRUE(refused(Put("a", Sphere{1}, sheared)));
  PutObject negative_margin = Put("a", Sphere{1});
  negative_margin.margin_m = -1;
  EXPECT_TRUE(refused(negative_margin));
  PutObject no_geometry = Put("a", Sphere{1});
  no_geometry.geometry = nullptr;
  EXPECT_TRUE(refused(no_geometry));
}

TEST(Difference, NamesWhatWasAddedMovedReplacedAndRemoved) {
  const auto before =
      MustApply(Empty(), {MakeChange(Put("gone", Sphere{1})), MakeChange(Put("moved", Sphere{1})),
                          MakeChange(Put("same", Sphere{1})), MakeChange(Put("twin", Sphere{1}))});
  const auto after =
      MustApply(before, {Remove("gone"), Move("moved", 2), MakeChange(Put("new", Sphere{1})),
                         Remove("twin"), MakeChange(Put("twin", Sphere{1}))});
  const auto deltas = Difference(*before, *after);
  ASSERT_EQ(deltas.size(), 5u);
  EXPECT_EQ(deltas[0].before->name, "gone");
  EXPECT_EQ(deltas[0].after, nullptr);
  EXPECT_EQ(deltas[1].before, before->Find("moved"));
  EXPECT_EQ(deltas[1].after, after->Find("moved"));
  EXPECT_EQ(deltas[2].before, nullptr);
  EXPECT_EQ(deltas[2].after->name, "new");
  EXPECT_EQ(deltas[3].before, before->Find("twin"));
  EXPECT_EQ(deltas[3].after, nullptr);
  EXPECT_EQ(deltas[4].before, nullptr);
  EXPECT_EQ(deltas[4].after, after->Find("twin"));
  EXPECT_TRUE(Difference(*after, *after).empty());
}

TEST(WorldObject, BoundsOfATiltedSlabAreTight) {
  // A slab of 2 m x 1 m x 0.02 m tilted by one degree; FCL's bounding sphere makes it 2.236 m high.
  const double tilt_rad = std::numbers::pi / 180;
  const Pose X_WO = MakePose({0, 0, 0}, Quaternion(Eigen::AngleAxisd(tilt_rad, Vector3::UnitX())));
  const auto world = MustApply(Empty(), {MakeChange(Put("slab", Box{{2, 1, 0.02}}, X_WO))});
  const double expected_m = std::sin(tilt_rad) * 1 + std::cos(tilt_rad) * 0.02;
  EXPECT_NEAR(world->Find("slab")->bounds_W.sizes().z(), expected_m, 1e-12);
  EXPECT_LT(expected_m, 0.038);
}

TEST(Prepare, MakesAPartOfEachShapeSurfaceAndHandle) {
  const Mesh triangle =
      MakeMesh({.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, .triangles = {{0, 1, 2}}});
  auto model = std::make_shared<HybridModel>();
  model->shapes.push_back({.X_OS = MakeTranslation(1, 0, 0),
                           .shape = Sphere{0.5},
                           .role = PartRole::kFitted,
                           .fit = {}});
  model->surfaces = {{.surface = MakeMesh({}), .point_count = 0},
                     {.surface = triangle, .point_count = 3}};
  Handle with_surface;
  with_surface.surface = triangle;
  Handle bare;
  bare.bounds = {.X_FS = MakeTranslation(0, 2, 0), .shape = Box{{0.1, 0.2, 0.3}}};
  model->handles = {with_surface, bare};
  const auto prepared = Prepare(model);
  ASSERT_EQ(prepared->parts.size(), 4u);
  EXPECT_EQ(prepared->parts[0].source, PartSource::kShape);
  EXPECT_NEAR(prepared->parts[0].bounds_O.min().x(), 0.5, 1e-12);
  EXPECT_EQ(prepared->parts[1].source, PartSource::kSurface);
  EXPECT_EQ(prepared->parts[1].index, 1);  // the empty surface makes no part
  EXPECT_EQ(prepared->parts[2].source, PartSource::kHandle);
  EXPECT_EQ(KindOf(prepared->parts[2].shape), ShapeKind::kMesh);
  EXPECT_EQ(prepared->parts[3].index, 1);
  EXPECT_EQ(KindOf(prepared->parts[3].shape), ShapeKind::kBox);
  for (const auto& part : prepared->parts) {
    for (int i = 0; i < kEngineCount; ++i) EXPECT_NE(part.engines[i], nullptr);
  }
}

// `count` objects, added in an order that is not that of their names.
SnapshotPtr Crowd(int count) {
  const auto model = ModelOf(Sphere{0.01});
  std::vector<Change> changes;
  for (int i = 0; i < count; ++i) {
    PutObject put;
    put.name = "object" + std::to_string(7919 * i % 100003);
    const int column = i % 20, row = i / 20 % 20, layer = i / 400;
    put.X_WO = MakeTranslation(0.1 * column, 0.1 * row, 0.1 * layer);
    put.geometry = model;
    changes.push_back(MakeChange(std::move(put)));
  }
  return MustApply(Empty(), changes);
}

TEST(Snapshot, FindsObjectsByNameAndByRank) {
  const auto world = Crowd(500);
  ASSERT_EQ(world->objects().size(), 500u);
  std::size_t rank = 0;
  for (const WorldObjectPtr& object : world->objects()) {
    EXPECT_EQ(world->objects()[rank], object);
    EXPECT_EQ(world->objects().RankOf(object->name), rank);
    EXPECT_EQ(world->Find(object->name), object);
    ++rank;
  }
  EXPECT_EQ(rank, 500u);
  EXPECT_EQ(world->objects().RankOf("none"), std::nullopt);
  const auto names = Names(*world);
  EXPECT_TRUE(std::is_sorted(names.begin(), names.end()));
}

TEST(Snapshot, AnswersForEverAsItDidWhileOthersAreMadeFromIt) {
  const auto first = Crowd(300);
  const auto names = Names(*first);
  auto latest = first;
  for (int i = 0; i < 300; ++i) {
    const std::string& name = names[std::size_t{37} * i % names.size()];
    latest =
        MustApply(latest, {i % 3 == 0 && latest->Find(name) != nullptr
                               ? Remove(name)
                               : MakeChange(Put(name, Sphere{0.01}, MakeTranslation(9, 9, 9)))});
  }
  EXPECT_EQ(Names(*first), names);
  std::size_t found = 0;
  first->bounds().ForEachWithin({Vector3(-1, -1, -1), Vector3(3, 3, 3)}, 0,
                                [&](const Obstacle&) { ++found; });
  EXPECT_EQ(found, 300u);
}

TEST(Snapshot, DifferenceAgreesWithComparingAllNames) {
  const auto before = Crowd(200);
  auto after = before;
  const auto names = Names(*before);
  for (int i = 0; i < 60; ++i) {
    const std::string& name = names[std::size_t{61} * i % names.size()];
    if (i % 3 == 0) after = MustApply(after, {Remove(name)});
    if (i % 3 == 1) after = MustApply(after, {Move(name, i)});
    if (i % 3 == 2)
      after = MustApply(after, {MakeChange(Put("new" + std::to_string(i), Sphere{1}))});
  }
  std::vector<std::string> expected, result;
  for (const WorldObjectPtr& object : before->objects()) {
    if (after->Find(object->name) != object) expected.push_back(object->name);
  }
  for (const WorldObjectPtr& object : after->objects()) {
    if (before->Find(object->name) == nullptr) expected.push_back(object->name);
  }
  std::sort(expected.begin(), expected.end());
  for (const ObjectDelta& delta : Difference(*before, *after)) {
    result.push_back((delta.before != nullptr ? delta.before : delta.after)->name);
  }
  EXPECT_EQ(result, expected);
}

// The margin is at least the largest one, and at most that rounded up to single precision.
void ExpectMaxMargin(const WorldSnapshot& world, double expected_m) {
  EXPECT_GE(world.objects().max_margin_m(), expected_m);
  EXPECT_LE(world.objects().max_margin_m(), expected_m * (1 + 0x1p-23));
}

TEST(Snapshot, KnowsTheWidestMarginOfItsObjects) {
  PutObject wide = Put("wide", Sphere{1}), narrow = Put("narrow", Sphere{1});
  wide.margin_m = 0.3;
  narrow.margin_m = 0.1;
  const auto both = MustApply(Crowd(50), {MakeChange(wide), MakeChange(narrow)});
  ExpectMaxMargin(*both, 0.3);
  ExpectMaxMargin(*MustApply(both, {Remove("wide")}), 0.1);
  PutObject shrunk = wide, also_wide = narrow;
  shrunk.margin_m = 0.2;
  ExpectMaxMargin(*MustApply(both, {MakeChange(shrunk)}), 0.2);
  also_wide.margin_m = 0.3;
  const auto two = MustApply(both, {MakeChange(also_wide)});
  const auto one = MustApply(two, {Remove("wide")});
  ExpectMaxMargin(*one, 0.3);  // another object has it too
  ExpectMaxMargin(*MustApply(one, {Remove("narrow")}), 0);
  ExpectMaxMargin(*Empty(), 0);
}

TEST(Snapshot, KnowsTheWidestMarginAfterAnyChanges) {
  std::mt19937 random(4);
  SnapshotPtr world = Crowd(60);
  std::vector<std::pair<SnapshotPtr, double>> kept;
  const auto max_margin_m = [](const WorldSnapshot& of) {
    double max_margin_m = 0;
    for (const auto& object : of.objects()) max_margin_m = std::max(max_margin_m, object->margin_m);
    return max_margin_m;
  };
  PutObject put = Put("", Sphere{1});
  for (int i = 0; i < 2'000; ++i) {
    put.name = "of" + std::to_string(random() % 80);
    put.margin_m = 0.01 * static_cast<double>(random() % 8);
    const bool goes = random() % 3 == 0 && world->Find(put.name) != nullptr;
    world = MustApply(world, {goes ? Remove(put.name) : MakeChange(put)});
    ExpectMaxMargin(*world, max_margin_m(*world));
    if (i % 100 == 0) kept.emplace_back(world, max_margin_m(*world));
  }
  for (const auto& [before, expected_m] : kept) ExpectMaxMargin(*before, expected_m);
}

}  // namespace
}  // namespace cwm::collision
