#include "collision/query/interrupt.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "tests/collision/query/random_world.h"

namespace cwm::collision {
namespace {

// derived: a check of the clock is due after 64 units of 32 steps.
constexpr std::size_t kStepsBetweenLooks = std::size_t{64} * 32;

TEST(Interrupt, LooksAfterSoMuchWorkWhateverItsPortions) {
  for (const std::size_t portion : {1u, 7u, 32u, 100u, 5'000u}) {
    std::stop_source stop;
    const TimeLimit limit{QueryOptions{}};
    Interrupt interrupt(stop.get_token(), limit);
    EXPECT_FALSE(interrupt.CountWork(1));  // this call checks the clock
    stop.request_stop();
    std::size_t steps = 0;
    while (!interrupt.MustEndAfter(portion)) steps += portion;
    EXPECT_LE(steps, kStepsBetweenLooks + 64 * portion);
    EXPECT_TRUE(interrupt.MustEndAfter(1));  // and stays true
    EXPECT_EQ(interrupt.reason(), Interrupt::Reason::kStopped);
  }
}

// Rows that request a stop while one of them is placed, and count how many are placed.
class RowsThatStop : public BodyRows {
 public:
  RowsThatStop(Pose X_WB, std::stop_source& stop) : X_WB_(std::move(X_WB)), stop_(stop) {}
  std::size_t size() const override { return 64; }
  void Place(std::size_t, std::span<Pose> X_WF) const override {
    if (++placed_ == kStopsAt) stop_.request_stop();
    X_WF[0] = X_WB_;
  }
  int placed() const { return placed_; }
  static constexpr int kStopsAt = 3;

 private:
  const Pose X_WB_;
  std::stop_source& stop_;
  mutable int placed_ = 0;
};

Shape HullOfManyCorners() {
  std::vector<Vector3> points;
  for (int i = 0; i < 4000; ++i) {  // on a spiral
    const double z = 1 - (i + 0.5) / 2000, angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    const double r = std::sqrt(1 - z * z);
    points.push_back(0.2 * Vector3(r * std::cos(angle), r * std::sin(angle), z));
  }
  return Convex{std::make_shared<const TriangleMesh>(ConvexHull3(points))};
}

Shape DiscOfManyCorners() {
  Plate disc{{}, {}, 0.1};
  for (int i = 0; i < 2100; ++i) {
    const double angle = 2 * std::numbers::pi * i / 2100;
    disc.outline.emplace_back(std::cos(angle), std::sin(angle));
  }
  return disc;
}

TEST(Interrupt, LooksAfterEachPairOfManyCorners) {
  const auto world = WorldOf(
      {PutOf("box", {{.X_FS = Pose::Identity(), .shape = Box{{1, 1, 1}}}}, Pose::Identity())});
  for (const Shape& shape :
       {HullOfManyCorners(), DiscOfManyCorners(), Shape(MakeMesh(BoxMesh({0.2, 0.2, 0.2})))}) {
    const QueryBody body = BodyFromShapes({{.X_FS = Pose::Identity(), .shape = shape}});
    for (const bool of_contacts : {false, true}) {
      std::stop_source stop;
      const RowsThatStop rows(MakeTranslation(0.5, 0, 0), stop);
      const auto result = of_contacts ? GetContacts(*world, body, rows, {}, stop.get_token())
                                      : GetDistances(*world, body, rows, {}, stop.get_token());
      EXPECT_EQ(result.status().code(), absl::StatusCode::kCancelled);
      EXPECT_EQ(rows.placed(), RowsThatStop::kStopsAt) << NameOf(KindOf(shape));
    }
  }
}

// A row during which the time runs out is not answered.
TEST(Interrupt, WithinAPairLeavesThePrefix) {
  Plate comb{{{0, -0.1}, {1, -0.1}}, {}, 0.05};
  for (int i = 199; i >= 0; --i) {
    const double x = i / 200.0;
    comb.outline.insert(comb.outline.end(),
                        {{x + 0.005, 0}, {x + 0.004, 0.5}, {x + 0.002, 0.5}, {x + 0.001, 0}});
  }
  const auto world =
      WorldOf({PutOf("comb", {{.X_FS = Pose::Identity(), .shape = comb}}, Pose::Identity())});
  const QueryBody body = BodyFromShapes({{.X_FS = Pose::Identity(), .shape = comb}});
  const std::vector<Pose> at(20,
                             MakePose({0.1, 0.1, 0.01}, Quaternion(1, 0.1, 0.1, 0).normalized()));
  QueryOptions options;
  const PairColumns all = *GetDistances(*world, body, at, options);
  options.deadline = std::chrono::steady_clock::now();
  EXPECT_EQ(GetDistances(*world, body, at, options)->completed, 0u);
  options.deadline = std::chrono::steady_clock::now() + std::chrono::milliseconds(1);
  const PairColumns some = *GetDistances(*world, body, at, options);
  EXPECT_LE(some.completed, at.size());
  for (std::size_t k = 0; k < some.distance_m.size(); ++k) {
    EXPECT_EQ(some.distance_m[k], all.distance_m[k]);
  }
}

}  // namespace
}  // namespace cwm::collision
