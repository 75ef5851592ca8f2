#include "perception/search/point_lanes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace cwm::perception {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// Points on the z axis at these heights, facing up, with gates of 2.5 mm.
ModelPoints OnTheZAxis(const std::vector<double>& heights_m) {
  ModelPoints points;
  for (double z_m : heights_m) {
    points.p.emplace_back(0, 0, z_m);
    points.n.push_back(Vector3::UnitZ());
    points.gate_m.push_back(0.0025);
    points.min_cos.push_back(0.9);
  }
  return points;
}

std::vector<std::uint32_t> PlacesHit(const PointLanes& lanes, const AnyModel& model,
                                     const std::vector<PointLanes::Range>& ranges,
                                     double gate_scale = 1) {
  std::vector<std::uint32_t> places;
  for (const Hit& hit : lanes.HitsIn(model, ranges, gate_scale)) places.push_back(hit.at);
  return places;
}

TEST(PointLanes, TellPlacesInTheListAndSignedDistances) {
  const ModelPoints points = OnTheZAxis({0, 0.001, 0.002, 0.003, 0.004, -0.002});
  const PointLanes lanes(points, std::array<std::uint32_t, 4>{5, 3, 1, 4});
  ASSERT_EQ(lanes.size(), 4u);
  const PointLanes::Range all{0, 4};
  const std::vector<Hit> hits = lanes.HitsIn(PlaneModel{}, {&all, 1});
  ASSERT_EQ(hits.size(), 2u);
  EXPECT_EQ(hits[0].at, 0u);
  EXPECT_EQ(hits[0].distance_m, -0.002);
  EXPECT_EQ(hits[1].at, 2u);
  EXPECT_EQ(hits[1].distance_m, 0.001);
}

// The padding of the last group of four lies on this plane too.
TEST(PointLanes, KeepToTheRangesAndTheirOrder) {
  const PointLanes lanes(OnTheZAxis(std::vector<double>(11, 0.0)));
  EXPECT_THAT(PlacesHit(lanes, PlaneModel{}, {{8, 11}, {1, 3}}), ElementsAre(8, 9, 10, 1, 2));
  EXPECT_THAT(PlacesHit(lanes, PlaneModel{}, {{10, 11}}), ElementsAre(10));
  EXPECT_THAT(PlacesHit(lanes, PlaneModel{}, {{4, 4}}), IsEmpty());
  EXPECT_THAT(PlacesHit(lanes, PlaneModel{}, {}), IsEmpty());
  EXPECT_THAT(PlacesHit(PointLanes(), PlaneModel{}, {{0, 0}}), IsEmpty());
}

TEST(PointLanes, WidenTheGateAndNotTheNormals) {
  ModelPoints points = OnTheZAxis({0.051, 0.054, 0.056, 0.05});
  points.n[3] = Vector3::UnitX();
  const PointLanes lanes(points);
  const SphereModel ball{.radius_m = 0.05};
  EXPECT_THAT(PlacesHit(lanes, ball, {{0, 4}}), ElementsAre(0));
  EXPECT_THAT(PlacesHit(lanes, ball, {{0, 4}}, 2), ElementsAre(0, 1));
  EXPECT_THAT(PlacesHit(lanes, ball, {{0, 4}}, 0.3), IsEmpty());
}

TEST(PointLanes, TellTheInsideFromTheOutside) {
  ModelPoints points;
  for (const double facing : {1.0, -1.0}) {
    for (const Vector3& away : {Vector3(1, 0, 0), Vector3(0, -1, 0)}) {
      points.p.push_back(0.05 * away + Vector3(0, 0, 0.02));
      points.n.push_back(facing * away);
      points.gate_m.push_back(0.001);
      points.min_cos.push_back(0.9);
    }
  }
  const PointLanes lanes(points);
  CylinderModel can{.radius_m = 0.05};
  ConeModel cup{.radius_m = 0.048, .slope = 0.1};  // 5 cm at z = 2 cm
  EXPECT_THAT(PlacesHit(lanes, can, {{0, 4}}), ElementsAre(0, 1));
  EXPECT_THAT(PlacesHit(lanes, cup, {{0, 4}}), ElementsAre(0, 1));
  can.side = cup.side = SeenFrom::kInside;
  EXPECT_THAT(PlacesHit(lanes, can, {{0, 4}}), ElementsAre(2, 3));
  EXPECT_THAT(PlacesHit(lanes, cup, {{0, 4}}), ElementsAre(2, 3));
}

}  // namespace
}  // namespace cwm::perception
