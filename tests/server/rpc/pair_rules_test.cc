// Pair rules over a real socket: changes, queries, watches, expiry.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

using ::testing::ElementsAre;

v1::NamedPair PairOf(const std::string& a, const std::string& b) {
  v1::NamedPair pair;
  pair.mutable_a()->set_name(a);
  pair.mutable_b()->set_name(b);
  return pair;
}
v1::Change Allow(const std::string& a, const std::string& b) {
  v1::Change change;
  *change.mutable_allow()->mutable_pair() = PairOf(a, b);
  return change;
}
v1::Change Margin(const std::string& a, const std::string& b, double margin_m) {
  v1::Change change;
  *change.mutable_margin()->mutable_pair() = PairOf(a, b);
  change.mutable_margin()->set_margin_m(margin_m);
  return change;
}

// Boxes with edges of 0.2 m at x = 0 and x = 2; the query's body is a sphere of radius 0.1 m.
class PairRulesTest : public RunningServer {
 protected:
  PairRulesTest() {
    PutBox("left", 0);
    PutBox("right", 2);
  }
  grpc::Status Apply(const v1::Change& change, std::int64_t* revision = nullptr) {
    Call call;
    v1::ApplyChangesRequest request;
    *request.add_changes() = change;
    v1::ApplyChangesResponse response;
    const auto status = world_->ApplyChanges(&call, request, &response);
    if (revision != nullptr) *revision = response.revision();
    return status;
  }
  // The latest world, or the world at a revision.
  v1::GetWorldResponse World(std::int64_t revision = 0) {
    Call call;
    v1::GetWorldRequest request;
    if (revision > 0) request.mutable_at_revision()->set_exact(revision);
    v1::GetWorldResponse response;
    EXPECT_TRUE(world_->GetWorld(&call, request, &response).ok());
    return response;
  }
  // Verdicts at the left box, 0.05 m beside it, and far from both.
  std::vector<int> Verdicts(const v1::QueryOptions& options) {
    Call call;
    v1::CheckCollisionsRequest request;
    *request.mutable_subject() = SphereAt({0, 0.25, 1});
    *request.mutable_options() = options;
    v1::CheckCollisionsResponse response;
    const auto status = query_->CheckCollisions(&call, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return {response.verdicts().begin(), response.verdicts().end()};
  }
  static constexpr int kFree = v1::VERDICT_FREE, kHit = v1::VERDICT_COLLISION;
};

TEST_F(PairRulesTest, OfTheWorldHoldForEveryQuery) {
  EXPECT_THAT(Verdicts({}), ElementsAre(kHit, kFree, kFree));
  std::int64_t revision = 0;
  ASSERT_TRUE(Apply(Margin("*", "left", 0.06), &revision).ok());
  EXPECT_EQ(revision, 3);
  EXPECT_THAT(Verdicts({}), ElementsAre(kHit, kHit, kFree));
  ASSERT_TRUE(Apply(Allow("left", "*"), &revision).ok());
  EXPECT_EQ(revision, 4);
  EXPECT_THAT(Verdicts({}), ElementsAre(kFree, kFree, kFree));
  ASSERT_TRUE(Apply(Allow("*", "left"), &revision).ok());
  EXPECT_EQ(revision, 4);  // changes nothing
  const v1::GetWorldResponse world = World();
  EXPECT_EQ(world.revision(), 4);
  ASSERT_EQ(world.pair_rules_size(), 1);
  EXPECT_TRUE(world.pair_rules(0).allowed());
  EXPECT_EQ(world.pair_rules(0).margin_m(), 0.06);
  // The world at an earlier revision.
  v1::QueryOptions before;
  before.mutable_at_revision()->set_exact(3);
  EXPECT_THAT(Verdicts(before), ElementsAre(kHit, kHit, kFree));
  EXPECT_TRUE(World(2).pair_rules().empty());
  ASSERT_EQ(World(3).pair_rules_size(), 1);
  EXPECT_FALSE(World(3).pair_rules(0).allowed());
  EXPECT_EQ(World(3).revision(), 3);
  v1::GetWorldRequest future;
  future.mutable_at_revision()->set_exact(99);
  v1::GetWorldResponse response;
  Call call;
  EXPECT_EQ(world_->GetWorld(&call, future, &response).error_code(),
            grpc::StatusCode::OUT_OF_RANGE);
}

TEST_F(PairRulesTest, OfAQueryHoldForItAlone) {
  v1::QueryOptions ignoring;
  *ignoring.add_ignore_pairs() = PairOf("*", "left");
  EXPECT_THAT(Verdicts(ignoring), ElementsAre(kFree, kFree, kFree));
  v1::QueryOptions overlaid;
  *overlaid.add_overlay() = Margin("left", "*", 0.06);
  EXPECT_THAT(Verdicts(overlaid), ElementsAre(kHit, kHit, kFree));
  *overlaid.add_overlay() = Allow("*", "*");
  EXPECT_THAT(Verdicts(overlaid), ElementsAre(kFree, kFree, kFree));
  EXPECT_THAT(Verdicts({}), ElementsAre(kHit, kFree, kFree));
  EXPECT_EQ(World().revision(), 2);
}

TEST_F(PairRulesTest, AnObjectThatAsksIsKnownByItsName) {
  const auto distances = [&](const v1::QueryOptions& options) {
    Call call;
    v1::GetDistancesRequest request;
    request.mutable_subject()->mutable_object()->set_name("left");
    *request.mutable_options() = options;
    v1::GetDistancesResponse response;
    EXPECT_TRUE(query_->GetDistances(&call, request, &response).ok());
    return response.objects_size();
  };
  EXPECT_EQ(distances({}), 1);
  v1::QueryOptions options;
  *options.add_ignore_pairs() = PairOf("right", "left");
  EXPECT_EQ(distances(options), 0);
}

TEST_F(PairRulesTest, RefusalsNameTheField) {
  const auto field = [&](const v1::Change& change) { return FieldIn(Apply(change)); };
  EXPECT_EQ(field(Allow("left", "")), "changes[0].allow.pair.b.name");
  EXPECT_EQ(field(Margin("left", "right", -1)), "changes[0].margin.margin_m");
  v1::Change change = Allow("left", "right");
  change.set_expected_object_revision(2);
  EXPECT_EQ(field(change), "changes[0].expected_object_revision");
  change = Allow("left", "right");
  change.mutable_allow()->mutable_expires_after();
  EXPECT_EQ(field(change), "changes[0].allow.expires_after");
  Call call;
  v1::CheckCollisionsRequest request;
  *request.mutable_subject() = SphereAt({0});
  *request.mutable_options()->add_overlay() = Allow("*", "no such/ name!");
  v1::CheckCollisionsResponse response;
  EXPECT_EQ(FieldIn(query_->CheckCollisions(&call, request, &response)),
            "options.overlay[0].allow.pair.b.name");
  EXPECT_EQ(World().pair_rules_size(), 0);
  // A rule alone does not create a world.
  v1::ApplyChangesRequest elsewhere;
  elsewhere.set_world("elsewhere");
  *elsewhere.add_changes() = Allow("a", "b");
  Call second;
  v1::ApplyChangesResponse applied;
  EXPECT_EQ(ReasonIn(world_->ApplyChanges(&second, elsewhere, &applied)), "WORLD_UNKNOWN");
}

TEST_F(PairRulesTest, WatchesShowThemAndTheirExpiry) {
  ASSERT_TRUE(Apply(Margin("a", "b", 0.5)).ok());
  for (const v1::WatchMode mode : {v1::WATCH_MODE_LOSSLESS, v1::WATCH_MODE_COALESCED}) {
    Call call;
    v1::WatchWorldRequest request;
    request.set_mode(mode);
    const auto watch = world_->WatchWorld(&call, request);
    const auto next = [&] { return NextMessage(watch.get()); };
    const v1::WatchWorldResponse initial = next();
    EXPECT_EQ(initial.initial_state().objects_size(), 2);
    ASSERT_EQ(initial.initial_state().pair_rules_size(), 1);
    EXPECT_EQ(initial.initial_state().pair_rules(0).margin_m(), 0.5);
    v1::Change change = Allow("c", "*");
    change.mutable_allow()->mutable_expires_after()->set_nanos(200'000'000);
    std::int64_t revision = 0;
    ASSERT_TRUE(Apply(change, &revision).ok());
    const v1::WatchWorldResponse allowed = next();
    EXPECT_EQ(allowed.revision(), revision);
    ASSERT_EQ(allowed.events().pair_rules_size(), 1);
    EXPECT_TRUE(allowed.events().pair_rules(0).allowed());
    EXPECT_TRUE(allowed.events().pair_rules(0).has_expires());
    const v1::WatchWorldResponse over = next();
    EXPECT_EQ(over.revision(), revision + 1);
    ASSERT_EQ(over.events().pair_rules_size(), 1);
    EXPECT_EQ(over.events().pair_rules(0).pair().b().name(), "c");
    EXPECT_FALSE(over.events().pair_rules(0).allowed());
    EXPECT_EQ(World().pair_rules_size(), 1);
    call.TryCancel();
  }
}

TEST_F(PairRulesTest, ARetryDoesNotAllowForLonger) {
  v1::ApplyChangesRequest request;
  *request.add_changes() = Allow("a", "b");
  request.mutable_changes(0)->mutable_allow()->mutable_expires_after()->set_seconds(3'600);
  request.set_request_id("once");
  const auto apply = [&] {
    Call call;
    v1::ApplyChangesResponse response;
    EXPECT_TRUE(world_->ApplyChanges(&call, request, &response).ok());
    return response.revision();
  };
  EXPECT_EQ(apply(), 3);
  const auto expires = World().pair_rules(0).expires();
  EXPECT_EQ(apply(), 3);
  EXPECT_EQ(World().pair_rules(0).expires().nanos(), expires.nanos());
}

// An allowance with an hour left does not keep the server from stopping.
TEST_F(PairRulesTest, WhatIsToExpireDoesNotKeepTheServer) {
  v1::Change change = Allow("a", "b");
  change.mutable_allow()->mutable_expires_after()->set_seconds(3'600);
  ASSERT_TRUE(Apply(change).ok());
  const auto begin = std::chrono::steady_clock::now();
  server_->Stop(std::chrono::seconds(20));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
}

}  // namespace
}  // namespace cwm::server
