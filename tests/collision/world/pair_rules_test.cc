#include "collision/world/pair_rules.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "collision/world/world_snapshot.h"

namespace cwm::collision {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using SnapshotPtr = std::shared_ptr<const WorldSnapshot>;

const SteadyTime kNoon{std::chrono::hours(500'000)};

SnapshotPtr Empty() { return std::make_shared<const WorldSnapshot>(); }

NamedPair PairOf(NamedThing a, NamedThing b) { return {std::move(a), std::move(b)}; }
Change MakeChange(AllowCollision allow) {
  return {.what = std::move(allow), .expected_object_revision = {}};
}
Change MakeChange(SetPairMargin set) {
  return {.what = std::move(set), .expected_object_revision = {}};
}
Change Allow(const std::string& a, const std::string& b, std::optional<SteadyTime> due = {}) {
  AllowCollision allow{.pair = PairOf({a}, {b})};
  if (due.has_value()) allow.expires = Expiry{.due = *due, .wall_time = {}};
  return MakeChange(std::move(allow));
}
Change Withdraw(const std::string& a, const std::string& b) {
  return MakeChange(AllowCollision{.pair = PairOf({a}, {b}), .withdraw = true});
}
Change Margin(const std::string& a, const std::string& b, std::optional<double> margin_m) {
  return MakeChange(SetPairMargin{.pair = PairOf({a}, {b}), .margin_m = margin_m});
}
Change Expire(SteadyTime now) { return {.what = ExpireRules{now}, .expected_object_revision = {}}; }

SnapshotPtr MustApply(const SnapshotPtr& base, const std::vector<Change>& changes) {
  auto next = Apply(base, changes);
  EXPECT_TRUE(next.ok()) << next.status();
  return next.ok() ? *next : base;
}

std::vector<std::string> Text(const PairRules& rules) {
  std::vector<std::string> lines;
  for (const PairRule& rule : rules) {
    std::string line = rule.pair.a.name + (rule.pair.a.link.empty() ? "" : ":" + rule.pair.a.link) +
                       "," + rule.pair.b.name +
                       (rule.pair.b.link.empty() ? "" : ":" + rule.pair.b.link);
    if (rule.allowed) line += " allowed";
    if (rule.expires) line += " expires";
    if (rule.margin_m) line += " " + std::to_string(*rule.margin_m).substr(0, 4);
    lines.push_back(line);
  }
  return lines;
}

TEST(PairRules, AreOrderedByNamesHoweverAPairIsSaid) {
  const auto world = MustApply(
      Empty(), {Allow("cup", "arm"), Margin("arm", "cup", 0.25), Allow("*", "bin"),
                MakeChange(AllowCollision{.pair = PairOf({"arm", "tip"}, {"arm", "base"})})});
  EXPECT_EQ(world->revision(), Revision{1});
  EXPECT_THAT(Text(world->pair_rules()),
              ElementsAre("*,bin allowed", "arm,cup allowed 0.25", "arm:base,arm:tip allowed"));
}

TEST(PairRules, WhatChangesNothingMakesNoRevision) {
  const auto world = MustApply(Empty(), {Allow("cup", "arm", kNoon), Margin("a", "b", 0.1)});
  EXPECT_EQ(MustApply(world, {Allow("arm", "cup", kNoon), Margin("b", "a", 0.1)}), world);
  EXPECT_EQ(MustApply(world, {Withdraw("no", "body"), Margin("no", "body", std::nullopt)}), world);
  EXPECT_EQ(MustApply(world, {Allow("x", "y"), Withdraw("y", "x")}), world);
  EXPECT_EQ(MustApply(world, {Expire(kNoon - std::chrono::seconds(1))}), world);
  EXPECT_NE(MustApply(world, {Allow("arm", "cup")}), world);  // now without expiry
}

TEST(PairRules, EndByWithdrawalUnsettingAndExpiry) {
  auto world = MustApply(Empty(), {Allow("a", "b", kNoon), Margin("a", "b", 0.5), Allow("c", "d"),
                                   Allow("e", "f", kNoon + std::chrono::hours(1))});
  EXPECT_EQ(NextExpiry(world->pair_rules()), kNoon);
  world = MustApply(world, {Expire(kNoon)});
  EXPECT_THAT(Text(world->pair_rules()),
              ElementsAre("a,b 0.50", "c,d allowed", "e,f allowed expires"));
  world = MustApply(world, {Margin("a", "b", std::nullopt), Withdraw("f", "e")});
  EXPECT_THAT(Text(world->pair_rules()), ElementsAre("c,d allowed"));
  EXPECT_EQ(NextExpiry(world->pair_rules()), std::nullopt);
  EXPECT_THAT(MustApply(world, {Withdraw("c", "d")})->pair_rules(), IsEmpty());
}

TEST(PairRules, AreSharedByRevisionsThatDoNotChangeThemAndOutliveTheirThings) {
  PutObject put;
  put.name = "cup";
  auto model = std::make_shared<HybridModel>();
  model->shapes.push_back({.X_OS = Pose::Identity(), .shape = Sphere{1}});
  put.geometry = Prepare(std::move(model));
  const auto before = MustApply(Empty(), {Allow("cup", "arm")});
  const auto with = MustApply(before, {{.what = put, .expected_object_revision = {}}});
  EXPECT_EQ(&with->pair_rules(), &before->pair_rules());
  const auto gone =
      MustApply(with, {{.what = RemoveObject{"cup"}, .expected_object_revision = {}}});
  EXPECT_EQ(&gone->pair_rules(), &before->pair_rules());
  EXPECT_THAT(RuleDifference(with->pair_rules(), gone->pair_rules()), IsEmpty());
}

TEST(PairRules, RefusalsNameTheFieldAndLeaveNothingBehind) {
  const auto base = MustApply(Empty(), {Allow("cup", "arm")});
  const auto fault = [&](const Change& change) {
    const auto status = Apply(base, std::vector<Change>{Allow("x", "y"), change}).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
    const auto result = FaultOf(status).value_or(ApplyFault{});
    EXPECT_EQ(result.change, 1u);
    return result.field;
  };
  EXPECT_EQ(fault(Allow("", "arm")), "pair.a.name");
  EXPECT_EQ(fault(Allow("arm", "a cup")), "pair.b.name");
  EXPECT_EQ(fault(Allow("arm", "a\ncup")), "pair.b.name");
  EXPECT_EQ(fault(MakeChange(AllowCollision{.pair = PairOf({"*", "tip"}, {"cup"})})),
            "pair.a.link");
  EXPECT_EQ(
      fault(MakeChange(SetPairMargin{.pair = PairOf({"arm", "a\nb"}, {"cup"}), .margin_m = 1})),
      "pair.a.link");
  EXPECT_EQ(fault(Margin("a", "b", -0.1)), "margin_m");
  EXPECT_EQ(fault(Margin("a", "b", std::nan(""))), "margin_m");
  EXPECT_EQ(fault(Margin("a", "b", std::numeric_limits<double>::infinity())), "margin_m");
  EXPECT_EQ(fault(MakeChange(AllowCollision{
                .pair = PairOf({"a"}, {"b"}), .withdraw = true, .expires = Expiry{}})),
            "expires_after");
  Change expecting = Allow("a", "b");
  expecting.expected_object_revision = Revision{1};
  EXPECT_EQ(fault(expecting), "expected_object_revision");
}

TEST(PairRules, ThereMayBeAsManyAsItSaysAndNoMore) {
  std::vector<Change> changes;
  for (std::size_t i = 0; i < kMaxPairRules; ++i) {
    changes.push_back(Margin("a", "b" + std::to_string(i), 0.1));
  }
  const auto full = MustApply(Empty(), changes);
  EXPECT_THAT(full->pair_rules(), SizeIs(kMaxPairRules));
  const auto status = Apply(full, std::vector<Change>{Allow("c", "d")}).status();
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
  EXPECT_THAT(status.message(), HasSubstr("4096"));
  MustApply(full, {Allow("a", "b7"), Margin("a", "b9", std::nullopt), Allow("c", "d")});
}

TEST(PairRules, DifferenceTellsWhatSetRuleRepeats) {
  std::mt19937 random(3);
  const auto name = [&] { return std::string(1, static_cast<char>('a' + random() % 4)); };
  auto world = Empty();
  for (int i = 0; i < 300; ++i) {
    std::vector<Change> changes;
    for (int k = 0; k < 3; ++k) {
      switch (random() % 4) {
        case 0:
          changes.push_back(Withdraw(name(), name()));
          break;
        case 1:
          changes.push_back(Margin(name(), name(), std::nullopt));
          break;
        case 2:
          changes.push_back(Allow(name(), name()));
          break;
        default:
          changes.push_back(Margin(name(), name(), static_cast<double>(random() % 3)));
      }
    }
    const auto next = MustApply(world, changes);
    PairRules forward = world->pair_rules(), back = next->pair_rules();
    for (const PairRuleDelta& delta : RuleDifference(world->pair_rules(), next->pair_rules())) {
      EXPECT_FALSE(delta.before == delta.after);
      SetRule(forward, delta.after);
      SetRule(back, delta.before);
    }
    EXPECT_EQ(forward, next->pair_rules());
    EXPECT_EQ(back, world->pair_rules());
    world = next;
  }
}

}  // namespace
}  // namespace cwm::collision
