#include "server/core/kept_snapshots.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "server/core/approximate_bytes.h"
#include "tests/server/core/spindle.h"
#include "tests/server/core/test_objects.h"

namespace cwm::server {
namespace {

using collision::Revision;
using std::chrono::milliseconds;
using std::chrono::minutes;
using std::chrono::seconds;

constexpr Clock::time_point kBegin{std::chrono::hours(5)};
constexpr auto kFrame = std::chrono::microseconds(33'333);

// A world of two objects, of which one moves in each revision.
class MovingWorld {
 public:
  explicit MovingWorld(const Retention& retention = {})
      : latest_(*collision::Apply(std::make_shared<const collision::WorldSnapshot>(),
                                  std::vector{Put("a"), Put("b")})),
        kept(retention, latest_) {}

  void Move(Clock::time_point when) {
    const std::string name = latest_->revision().value % 3 == 0 ? "a" : "b";
    const double x_m = 1e-3 * static_cast<double>(latest_->revision().value);
    Append(*collision::Apply(latest_, std::vector{server::Move(name, x_m)}), when);
  }
  void Append(SnapshotPtr next, Clock::time_point when) {
    const auto deltas = collision::Difference(*latest_, *next);
    std::vector<SnapshotPtr> dropped;
    kept.Append(
        next, when,
        {.changed_count = deltas.size(), .superseded_bytes = ApproximateSupersededBytes(deltas)},
        dropped);
    latest_ = std::move(next);
  }
  std::int64_t latest() const { return latest_->revision().value; }
  bool Keeps(std::int64_t revision) const { return kept.Find({revision}) != nullptr; }
  std::set<std::int64_t> Revisions() const {
    std::set<std::int64_t> revisions;
    for (std::int64_t r = 0; r <= latest(); ++r) {
      if (Keeps(r)) revisions.insert(r);
    }
    return revisions;
  }

 private:
  SnapshotPtr latest_;

 public:
  KeptSnapshots kept;
};

TEST(KeptSnapshots, OfASlowWorldAreTheNewest256HoweverOldTheyAre) {
  for (const Clock::duration interval :
       {Clock::duration(milliseconds(100)), Clock::duration(seconds(7)),
        Clock::duration(minutes(90))}) {
    MovingWorld world;
    for (int i = 1; i <= 700; ++i) {
      world.Move(kBegin + i * interval);
      if (i % 100 != 0) continue;
      const std::int64_t oldest = std::max<std::int64_t>(1, world.latest() - 255);
      EXPECT_EQ(world.kept.oldest(), Revision{oldest});
      EXPECT_EQ(static_cast<std::int64_t>(world.Revisions().size()), world.latest() - oldest + 1);
    }
  }
}

TEST(KeptSnapshots, OfAWorldThatIsSlowOnAverageIncludeItsBursts) {
  MovingWorld world;
  Clock::time_point when = kBegin;
  for (int burst = 0; burst < 100; ++burst, when += seconds(2)) {
    for (int i = 0; i < 6; ++i) world.Move(when += milliseconds(1));
  }
  EXPECT_EQ(world.kept.oldest(), Revision{world.latest() - 255});
  EXPECT_EQ(world.Revisions().size(), 256u);
}

TEST(KeptSnapshots, OfAFastWorldAreThinnedByAge) {
  MovingWorld world;
  std::map<std::int64_t, Clock::time_point> made;
  Clock::time_point now = kBegin;
  for (; now < kBegin + minutes(10); now += kFrame) {
    world.Move(now);
    made[world.latest()] = now;
    EXPECT_LE(world.kept.size(), 256u);
  }
  now -= kFrame;
  std::map<int, int> counts;  // by age in seconds
  for (const std::int64_t revision : world.Revisions()) {
    ++counts[static_cast<int>(std::chrono::floor<seconds>(now - made[revision]).count())];
  }
  EXPECT_GE(counts[0], 30) << "all of the last second";
  for (int age_s = 2; age_s < 10; ++age_s) EXPECT_NEAR(counts[age_s], 10, 1) << age_s;
  for (int age_s = 12; age_s < 140; ++age_s) EXPECT_NEAR(counts[age_s], 1, 1) << age_s;
  EXPECT_GE(counts.rbegin()->first, 130) << "how far they reach back";
}

TEST(KeptSnapshots, ASnapshotThatIsUsedStaysAndOneThatIsNotFalls) {
  MovingWorld world;
  Clock::time_point now = kBegin;
  world.Move(now);
  const std::int64_t used = world.latest();
  ASSERT_NE(world.kept.Use({used}, now), nullptr);
  Clock::time_point last_use = now;
  std::int64_t unused = 0;
  for (; now < kBegin + minutes(10); now += kFrame) {
    world.Move(now);
    if (unused == 0 && now > kBegin + seconds(20)) unused = world.latest();
    ASSERT_TRUE(world.Keeps(used)) << (now - kBegin).count() * 1e-9 << " s";
    if (now - last_use >= seconds(50)) {
      ASSERT_NE(world.kept.Use({used}, now), nullptr);
      last_use = now;
    }
  }
  EXPECT_FALSE(world.Keeps(unused));
  EXPECT_EQ(world.kept.leased_count(), 1u);
  EXPECT_GT(world.kept.oldest(), Revision{used}) << "a lease extends the past of nobody else";
  for (; now <= last_use + seconds(60); now += kFrame) world.Move(now);
  EXPECT_TRUE(world.Keeps(used));
  world.Move(now + milliseconds(1));
  EXPECT_FALSE(world.Keeps(used));
}

TEST(KeptSnapshots, ASnapshotThatIsHeldStays) {
  MovingWorld world;
  Clock::time_point now = kBegin;
  for (int i = 0; i < 300; ++i) world.Move(now += kFrame);
  // A query that takes five minutes is answered from it.
  SnapshotPtr held = world.kept.latest();
  const std::int64_t revision = held->revision().value;
  const Clock::time_point begin = now;
  while (now < begin + minutes(5)) world.Move(now += kFrame);
  EXPECT_TRUE(world.Keeps(revision));
  EXPECT_GT(world.kept.oldest(), Revision{revision});
  held = nullptr;
  while (now < begin + minutes(6) + seconds(2)) world.Move(now += kFrame);
  EXPECT_FALSE(world.Keeps(revision)) << "a minute after it was last looked at";
}

TEST(KeptSnapshots, LeasesEndWithoutANewRevision) {
  MovingWorld world({.exact_snapshots = 1, .recent_snapshots = 0});
  world.kept.Use({1}, kBegin);
  world.Move(kBegin);
  std::vector<SnapshotPtr> dropped;
  world.kept.EndLeases(kBegin + seconds(60), dropped);
  EXPECT_TRUE(world.Keeps(1));
  world.kept.EndLeases(kBegin + seconds(60) + Clock::duration(1), dropped);
  EXPECT_FALSE(world.Keeps(1));
  ASSERT_EQ(dropped.size(), 1u);
  EXPECT_EQ(dropped[0]->revision(), Revision{1});
}

TEST(KeptSnapshots, WhatWasTheNewestWithinTheLastSecondIsKeptAtAnyRate) {
  MovingWorld world;
  Clock::time_point now = kBegin;
  // A revision that was made an hour ago and was the newest until now is recent too.
  for (int i = 0; i < 600; ++i) world.Move(now += kFrame);
  std::map<std::int64_t, Clock::time_point> superseded = {{world.latest(), now + minutes(60)}};
  now += minutes(60);
  for (int i = 0; i < 5'000; ++i, now += milliseconds(1)) {
    superseded[world.latest()] = now;
    world.Move(now);
    if (i % 97 != 0) continue;
    for (const auto& [revision, when] : superseded) {
      if (when >= now - seconds(1)) {
        ASSERT_TRUE(world.Keeps(revision)) << revision;
      }
    }
  }
  EXPECT_GE(world.kept.size(), 1'000u);
  // The many fall again, over the next revisions.
  for (int i = 0; i < 800; ++i) world.Move(now += milliseconds(50));
  EXPECT_EQ(world.kept.size(), 256u);
}

TEST(KeptSnapshots, AreLimitedInNumberAlsoWithinASecond) {
  MovingWorld world({.exact_snapshots = 10, .recent_snapshots = 50});
  for (int i = 0; i < 500; ++i) world.Move(kBegin + i * std::chrono::microseconds(10));
  EXPECT_EQ(world.Revisions().size(), 50u);
  EXPECT_EQ(world.kept.oldest(), Revision{world.latest() - 49});
}

TEST(KeptSnapshots, TheLeastRecentlyUsedLeasesFallFirst) {
  MovingWorld world({.exact_snapshots = 2, .recent_snapshots = 0, .leased_snapshots = 3});
  for (int i = 1; i <= 8; ++i) {
    world.kept.Use({world.latest()}, kBegin + milliseconds(i));
    world.Move(kBegin + milliseconds(i));
    world.kept.Use({1}, kBegin + milliseconds(i));
  }
  EXPECT_EQ(world.Revisions(), (std::set<std::int64_t>{1, 6, 7, 8, 9}));
  EXPECT_EQ(world.kept.leased_count(), 3u);
}

// The base with another mesh in the place of its object "scan".
SnapshotPtr WithNewMesh(const SnapshotPtr& base, double scale) {
  TriangleMesh mesh = Spindle(100);
  for (Vector3& vertex : mesh.vertices) vertex *= scale;
  SurfacePart surface;
  surface.surface.mesh = std::make_shared<const TriangleMesh>(std::move(mesh));
  HybridModel model;
  model.surfaces.push_back(std::move(surface));
  const auto prepared = collision::Prepare(std::make_shared<const HybridModel>(std::move(model)));
  const std::vector<collision::Change> put = {
      {collision::PutObject{.name = "scan", .geometry = prepared, .supported_by = {}},
       std::nullopt}};
  return *collision::Apply(base, put);
}

TEST(KeptSnapshots, MeshesThatAreHeldCountOnceForEachKeptSnapshot) {
  SnapshotPtr latest = WithNewMesh(std::make_shared<const collision::WorldSnapshot>(), 0.01);
  const std::int64_t mesh_bytes = ApproximateBytes(*latest->Find("scan"));
  const Retention retention{.snapshot_bytes = 60 * mesh_bytes, .leased_bytes = 10 * mesh_bytes};
  MovingWorld world(retention);
  Clock::time_point now = kBegin;
  for (int i = 0; i < 600; ++i) {
    latest = WithNewMesh(latest, 0.01 + 1e-5 * i);
    world.Append(latest, now += kFrame);
    if (i % 10 == 0) world.kept.Use(latest->revision(), now);
  }
  const std::size_t unleased = world.kept.size() - world.kept.leased_count();
  EXPECT_GE(unleased, 50u) << "thinned ones do not count";
  EXPECT_LE(unleased, 62u);
  EXPECT_GE(world.kept.leased_count(), 7u);
  EXPECT_LE(world.kept.leased_count(), 10u);
}

TEST(KeptSnapshots, NamesTheNearestOne) {
  MovingWorld world({.exact_snapshots = 3, .recent_snapshots = 0});
  world.kept.Use({3}, kBegin);
  for (int i = 1; i <= 9; ++i) {
    world.Move(kBegin);
    world.kept.Use({3}, kBegin);
  }
  ASSERT_EQ(world.Revisions(), (std::set<std::int64_t>{3, 8, 9, 10}));
  const std::map<std::int64_t, std::int64_t> nearest = {{-5, 3}, {0, 3}, {3, 3}, {4, 3},
                                                        {5, 3},  {6, 8}, {7, 8}, {9, 9}};
  for (const auto& [revision, expected] : nearest) {
    EXPECT_EQ(world.kept.NearestTo({revision}), Revision{expected}) << revision;
  }
}

// What is promised, written plainly: sets of revisions, searched from end to end.
class PlainModel {
 public:
  explicit PlainModel(const Retention& retention) : retention_(retention) {}

  void Append(std::int64_t revision, Clock::time_point when) {
    if (!made_.empty()) superseded_[made_.rbegin()->first] = when;
    made_[revision] = when;
    unleased_.insert(revision);
    EndLeases(when);
    for (int i = 0; i < 2 && Size() > Limit(when); ++i) {
      const std::int64_t falls = NextToFall(when);
      unleased_.erase(falls);
      if (used_.contains(falls) && used_[falls] >= when - retention_.lease_time) {
        leased_.insert(falls);
      }
    }
    while (static_cast<std::int64_t>(leased_.size()) > retention_.leased_snapshots) {
      leased_.erase(*std::ranges::min_element(leased_, {},
                                              [&](std::int64_t each) { return used_.at(each); }));
    }
  }
  void Use(std::int64_t revision, Clock::time_point now) { used_[revision] = now; }
  void EndLeases(Clock::time_point now) {
    std::erase_if(leased_,
                  [&](std::int64_t each) { return used_.at(each) < now - retention_.lease_time; });
  }
  std::set<std::int64_t> Kept() const {
    std::set<std::int64_t> kept = leased_;
    kept.insert(unleased_.begin(), unleased_.end());
    return kept;
  }
  const std::set<std::int64_t>& unleased() const { return unleased_; }

 private:
  std::int64_t Size() const { return static_cast<std::int64_t>(unleased_.size()); }
  bool IsRecent(std::int64_t revision, Clock::time_point now) const {
    const auto superseded = superseded_.find(revision);
    return superseded == superseded_.end() || superseded->second >= now - retention_.recent_time;
  }
  std::int64_t Limit(Clock::time_point now) const {
    const std::int64_t recent =
        std::ranges::count_if(Kept(), [&](std::int64_t each) { return IsRecent(each, now); });
    return std::max(retention_.exact_snapshots, std::min(recent, retention_.recent_snapshots));
  }
  bool IsSlow() const {
    const std::int64_t newest = made_.rbegin()->first;
    for (const std::int64_t each : Kept()) {
      if (each <= newest - retention_.exact_snapshots) continue;
      const auto passed = made_.at(newest) - made_.at(each);
      return passed >= milliseconds(100) * (retention_.exact_snapshots - 1);
    }
    return false;
  }
  std::int64_t NextToFall(Clock::time_point now) const {
    if (!IsSlow()) {
      std::set<std::pair<std::int64_t, std::int64_t>> seen;  // interval and its number
      for (const std::int64_t each : unleased_) {
        if (IsRecent(each, now)) break;
        const bool is_near = superseded_.at(each) >= now - retention_.recent_time - seconds(10);
        const auto time = std::chrono::floor<milliseconds>(made_.at(each).time_since_epoch());
        if (seen.contains({is_near ? 100 : 1'000, time.count() / (is_near ? 100 : 1'000)})) {
          return each;
        }
        seen.insert({100, time.count() / 100});
        seen.insert({1'000, time.count() / 1'000});
      }
    }
    return *unleased_.begin();
  }

  const Retention retention_;
  std::map<std::int64_t, Clock::time_point> made_, superseded_, used_;
  std::set<std::int64_t> unleased_, leased_;
};

TEST(KeptSnapshots, AreThoseOfThePlainModelInRandomWorlds) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    std::mt19937 random(seed);
    const auto below = [&](int bound) {
      return std::uniform_int_distribution(0, bound - 1)(random);
    };
    const Retention retention{.exact_snapshots = 20 + below(60),
                              .recent_snapshots = below(200),
                              .lease_time = seconds(5 + below(60)),
                              .leased_snapshots = 2 + below(20)};
    MovingWorld world(retention);
    PlainModel model(retention);
    Clock::time_point now = kBegin;
    // The first snapshot is as old as time itself.
    world.Move(now);
    model.Append(1, Clock::time_point(seconds(1)));
    model.Append(world.latest(), now);
    int period_ms = 33;
    for (int i = 0; i < 1'500; ++i) {
      if (below(200) == 0) period_ms = 1 + below(below(2) == 0 ? 40 : 1'500);
      now += milliseconds(below(2 * period_ms));
      world.Move(now);
      model.Append(world.latest(), now);
      for (int uses = below(3); uses > 0; --uses) {
        const std::set<std::int64_t> kept = model.Kept();
        const std::int64_t used = *std::next(kept.begin(), below(static_cast<int>(kept.size())));
        ASSERT_NE(world.kept.Use({used}, now), nullptr);
        model.Use(used, now);
      }
      ASSERT_EQ(world.kept.size(), model.Kept().size()) << "seed " << seed << ", step " << i;
      ASSERT_EQ(world.kept.oldest().value, *model.unleased().begin());
      if (i % 50 == 0) {
        ASSERT_EQ(world.Revisions(), model.Kept()) << "seed " << seed;
      }
    }
    std::vector<SnapshotPtr> dropped;
    world.kept.DropAllButLatest(dropped);
    EXPECT_EQ(world.kept.leased_count(), 0u);
    EXPECT_EQ(world.kept.own_bytes(), ApproximateOwnBytes(*world.kept.latest(), 1));
  }
}

}  // namespace
}  // namespace cwm::server
