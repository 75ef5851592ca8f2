#include "server/wire/pair_rules.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "server/wire/objects.h"
#include "server/wire/queries.h"
#include "server/wire/watch_events.h"
#include "tests/server/wire/wire_test_values.h"

namespace cwm::server {
namespace {

using collision::PairRule;
using std::chrono::seconds;

v1::NamedPair HandAndCup() {
  v1::NamedPair pair;
  pair.mutable_a()->set_name("panda");
  pair.mutable_a()->set_link("panda_hand");
  pair.mutable_b()->set_name("cup");
  return pair;
}

const collision::NamedPair kCupAndHand = {{"cup"}, {"panda", "panda_hand"}};

TEST(WirePairRules, AnAllowanceExpiresSoLongFromNow) {
  v1::AllowCollision proto;
  *proto.mutable_pair() = HandAndCup();
  const auto for_ever = AllowCollisionFromProto(proto, FieldPath());
  ASSERT_TRUE(for_ever.ok()) << for_ever.status();
  EXPECT_EQ(Ordered(for_ever->pair), kCupAndHand);
  EXPECT_FALSE(for_ever->expires.has_value());
  proto.mutable_expires_after()->set_seconds(std::int64_t{24} * 3600 * 30);
  constexpr std::chrono::hours kMonth{24 * 30};
  const collision::Expiry earliest = collision::ExpiryAfter(kMonth);
  const auto allow = AllowCollisionFromProto(proto, FieldPath());
  const collision::Expiry latest = collision::ExpiryAfter(kMonth);
  ASSERT_TRUE(allow.ok()) << allow.status();
  EXPECT_GE(allow->expires->due, earliest.due);
  EXPECT_LE(allow->expires->due, latest.due);
  EXPECT_GE(allow->expires->wall_time, earliest.wall_time);
  EXPECT_LE(allow->expires->wall_time, latest.wall_time);
}

TEST(WirePairRules, ChangesAreNamedByTheirFields) {
  const GeometryStore store(std::int64_t{1} << 20);
  struct Case {
    std::function<void(v1::Change&)> spoil;
    std::string field;
  };
  for (const Case& c : std::vector<Case>{
           {[](auto& m) { m.mutable_allow(); }, "changes[0].allow.pair.a.name"},
           {[](auto& m) {
              *m.mutable_allow()->mutable_pair() = HandAndCup();
              m.mutable_allow()->mutable_pair()->mutable_b()->set_name("a cup");
            },
            "changes[0].allow.pair.b.name"},
           {[](auto& m) {
              *m.mutable_allow()->mutable_pair() = HandAndCup();
              m.mutable_allow()->mutable_pair()->mutable_a()->set_name("*");
            },
            "changes[0].allow.pair.a.link"},
           {[](auto& m) {
              *m.mutable_allow()->mutable_pair() = HandAndCup();
              m.mutable_allow()->mutable_expires_after();
            },
            "changes[0].allow.expires_after"},
           {[](auto& m) {
              *m.mutable_allow()->mutable_pair() = HandAndCup();
              m.mutable_allow()->mutable_expires_after()->set_seconds(-1);
            },
            "changes[0].allow.expires_after"},
           {[](auto& m) {
              *m.mutable_allow()->mutable_pair() = HandAndCup();
              m.mutable_allow()->set_withdraw(true);
              m.mutable_allow()->mutable_expires_after()->set_seconds(1);
            },
            "changes[0].allow.expires_after"},
           {[](auto& m) { m.mutable_margin()->set_margin_m(1); }, "changes[0].margin.pair.a.name"},
           {[](auto& m) {
              *m.mutable_margin()->mutable_pair() = HandAndCup();
              m.mutable_margin()->set_margin_m(-0.1);
            },
            "changes[0].margin.margin_m"},
           {[](auto& m) {
              *m.mutable_margin()->mutable_pair() = HandAndCup();
              m.mutable_margin()->set_margin_m(std::nan(""));
            },
            "changes[0].margin.margin_m"}}) {
    google::protobuf::RepeatedPtrField<v1::Change> changes;
    c.spoil(*changes.Add());
    const auto status = ChangesFromProto(changes, Limits{}, store, FieldPath()).status();
    EXPECT_EQ(FieldAtFault(status), c.field) << status;
  }
}

TEST(WirePairRules, QueriesMayIgnorePairsAndWidenParts) {
  v1::QueryOptions proto;
  *proto.add_ignore_pairs() = HandAndCup();
  proto.add_ignore_pairs()->mutable_a()->set_name("*");
  proto.mutable_ignore_pairs(1)->mutable_b()->set_name("*");
  proto.set_margin_sigma(3);
  const auto options = QueryOptionsFromProto(proto, FieldPath());
  ASSERT_TRUE(options.ok()) << options.status();
  ASSERT_EQ(options->query.ignore_pairs.size(), 2u);
  EXPECT_EQ(Ordered(options->query.ignore_pairs[0]), kCupAndHand);
  EXPECT_EQ(options->query.margin_sigma, 3);
  for (const double sigma : {-1.0, std::nan(""), std::numeric_limits<double>::infinity(), 1e300}) {
    proto.set_margin_sigma(sigma);
    EXPECT_EQ(FieldAtFault(QueryOptionsFromProto(proto, FieldPath()).status()), "margin_sigma");
  }
  proto.set_margin_sigma(0);
  proto.mutable_ignore_pairs(1)->mutable_b()->clear_name();
  EXPECT_EQ(FieldAtFault(QueryOptionsFromProto(proto, FieldPath()).status()),
            "ignore_pairs[1].b.name");
}

TEST(WirePairRules, SayWhatTheyAre) {
  const PairRule rule{
      .pair = kCupAndHand,
      .allowed = true,
      .expires = collision::Expiry{.due = {}, .wall_time = collision::WallTime(seconds(1'000))},
      .margin_m = 0};
  const v1::PairRule proto = PairRuleToProto(rule);
  EXPECT_EQ(proto.pair().a().name(), "cup");
  EXPECT_EQ(proto.pair().b().link(), "panda_hand");
  EXPECT_TRUE(proto.allowed());
  EXPECT_EQ(proto.expires().seconds(), 1'000);
  EXPECT_TRUE(proto.has_margin_m());
  const v1::PairRule nothing = PairRuleToProto({.pair = kCupAndHand});
  EXPECT_FALSE(nothing.allowed() || nothing.has_expires() || nothing.has_margin_m());
}

// More rules than one message can hold.
TEST(WirePairRules, AreTheLastOfAnInitialStateAndOfEvents) {
  const World world{"w", "uid", Retention{}};
  GeometryStore store{std::int64_t{1} << 20};
  const WatchContext context{world, View::kShapes, store};
  collision::PairRules rules;
  WatchStep step;
  step.revision = {6};
  const std::string stem(110, 'x');
  for (int i = 10'000; i < 20'000; ++i) {
    rules.push_back({.pair = {{stem + std::to_string(i)}, {"y"}}, .margin_m = 0.1});
    step.rule_deltas.push_back({.before = rules.back(), .after = {.pair = rules.back().pair}});
  }
  const collision::WorldSnapshot snapshot({6}, {}, {}, rules);
  std::size_t next = 0, rule_count = 0;
  int messages = 0;
  for (bool done = false; !done; ++messages) {
    const auto message = InitialStatePiece(snapshot, context, &next);
    done = message.initial_state().initial_state_done();
    for (const v1::PairRule& rule : message.initial_state().pair_rules()) {
      EXPECT_EQ(rule.pair().a().name(), rules[rule_count++].pair.a.name);
    }
  }
  EXPECT_GT(messages, 1);
  EXPECT_EQ(rule_count, rules.size());
  next = rule_count = 0;
  for (bool more = true; more;) {
    const auto message = EventsPiece(step, context, &next);
    more = message.events().more();
    for (const v1::PairRule& rule : message.events().pair_rules()) {
      EXPECT_EQ(rule.pair().a().name(), rules[rule_count++].pair.a.name);
      EXPECT_FALSE(rule.has_margin_m());
    }
  }
  EXPECT_EQ(rule_count, rules.size());
}

}  // namespace
}  // namespace cwm::server
