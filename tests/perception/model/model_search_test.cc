// The octree, the candidate list and connectivity, compared with brute force.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "perception/search/candidate_list.h"
#include "perception/search/octree.h"
#include "perception/search/point_lanes.h"
#include "perception/simulation/random_draws.h"

namespace cwm::perception {
namespace {

// Two parallel squares of 10 cm, 6 cm apart, facing up, and scattered points of no surface.
OrientedPoints TwoSquares(int per_square) {
  OrientedPoints points;
  RandomDraws draws(11, 0);
  const auto add = [&points](const Eigen::Vector3f& p, const Eigen::Vector3f& n) {
    points.points.push_back(p);
    points.normals.push_back(n);
    points.sigma_m.push_back(0.001f);
    points.normal_sigma_rad.push_back(0.02f);
    points.cloud_index.push_back(static_cast<std::uint32_t>(points.cloud_index.size()));
  };
  const auto coordinate = [&draws] { return static_cast<float>(draws.Uniform(0, 0.1)); };
  for (int i = 0; i < per_square; ++i) {
    add({coordinate(), coordinate(), 0}, Eigen::Vector3f::UnitZ());
  }
  for (int i = 0; i < per_square / 2; ++i) {
    add({coordinate(), coordinate(), 0.06f}, Eigen::Vector3f::UnitZ());
  }
  for (int i = 0; i < per_square / 4; ++i) {
    add({coordinate(), coordinate(), coordinate()}, Eigen::Vector3f::UnitX());
  }
  points.viewpoint = Vector3(0, 0, 1);
  return points;
}

PlaneModel LevelAt(double z_m, const ModelPoints& points) {
  return {.point = Vector3(0, 0, z_m) - points.origin_L, .normal = Vector3::UnitZ()};
}

SeenFrom Side(RandomDraws& draws) {
  return draws.Uniform() < 0.5 ? SeenFrom::kOutside : SeenFrom::kInside;
}

// A random unit vector perpendicular to `n`.
Vector3 Across(const Vector3& n, RandomDraws& draws) {
  const double angle_rad = draws.Uniform(0, 2 * std::numbers::pi);
  const Matrix3 basis = BasisFromZ(n);
  return std::cos(angle_rad) * basis.col(0) + std::sin(angle_rad) * basis.col(1);
}

// A random model of one kind that touches the point with its normal, so that it has inliers.
template <class M>
M Touching(const SamplePoint& at, RandomDraws& draws);
template <>
PlaneModel Touching(const SamplePoint& at, RandomDraws&) {
  return {.point = at.p, .normal = at.n};
}
template <>
SphereModel Touching(const SamplePoint& at, RandomDraws& draws) {
  const double radius_m = draws.Uniform(0.01, 0.1);
  const SeenFrom side = Side(draws);
  return {.center = at.p - SignOf(side) * radius_m * at.n, .radius_m = radius_m, .side = side};
}
template <>
ConeModel Touching(const SamplePoint& at, RandomDraws& draws) {
  ConeModel cone;
  cone.radius_m = draws.Uniform(0.01, 0.1);
  cone.slope = draws.Uniform(-0.3, 0.3);
  cone.side = Side(draws);
  const Vector3 normal = SignOf(cone.side) * at.n;
  const Vector3 along = Across(normal, draws);  // the line of the wall through the point
  cone.axis = (along - cone.slope * normal).normalized();
  const Vector3 outward = (normal + cone.slope * along).normalized();
  cone.point = at.p - cone.radius_m * outward;
  return cone;
}
template <>
CylinderModel Touching(const SamplePoint& at, RandomDraws& draws) {
  CylinderModel cylinder;
  cylinder.radius_m = draws.Uniform(0.01, 0.1);
  cylinder.side = Side(draws);
  cylinder.axis = Across(at.n, draws);
  cylinder.point = at.p - SignOf(cylinder.side) * cylinder.radius_m * at.n;
  return cylinder;
}

TEST(SubsampleForSearch, TakesWhatWasSentManyTimesOnce) {
  const OrientedPoints once = TwoSquares(5);
  OrientedPoints often = once;
  for (int k = 1; k < 1000; ++k) {
    often.points.insert(often.points.end(), once.points.begin(), once.points.end());
    often.normals.insert(often.normals.end(), once.normals.begin(), once.normals.end());
    often.sigma_m.insert(often.sigma_m.end(), once.sigma_m.begin(), once.sigma_m.end());
    often.normal_sigma_rad.insert(often.normal_sigma_rad.end(), once.normal_sigma_rad.begin(),
                                  once.normal_sigma_rad.end());
  }
  EXPECT_EQ(SubsampleForSearch(often, 100'000).size(), SubsampleForSearch(once, 100'000).size());
}

template <class M>
class OctreeInliers : public ::testing::Test {};
using AllModels = testing::Types<PlaneModel, SphereModel, CylinderModel, ConeModel>;
TYPED_TEST_SUITE(OctreeInliers, AllModels);

TYPED_TEST(OctreeInliers, AreThoseOfBruteForce) {
  const ModelPoints points = SubsampleForSearch(TwoSquares(1000), 10000);
  const Octree octree(points);
  std::vector<char> available(points.size(), 1);
  for (std::size_t i = 0; i < available.size(); i += 5) available[i] = 0;
  RandomDraws draws(12, 0);
  for (int trial = 0; trial < 400; ++trial) {
    const auto touched =
        static_cast<std::uint32_t>(draws.Uniform(0, static_cast<double>(points.size())));
    const auto model = Touching<TypeParam>({points.p[touched], points.n[touched]}, draws);
    const double gate_scale = draws.Uniform(0.5, 3);
    std::vector<std::uint32_t> brute;
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      if (available[i] && IsInlier(model, points, i, gate_scale)) brute.push_back(i);
    }
    ASSERT_GE(brute.size(), available[touched] ? 1u : 0u) << trial;
    ASSERT_EQ(FindInliers(model, points, octree, available, gate_scale), brute) << trial;
  }
}

// The distances are the same four at a time or one by one, on ranges that do not begin or end at a
// multiple of four.
TYPED_TEST(OctreeInliers, HaveTheVeryDistancesOfTheModel) {
  const ModelPoints points = SubsampleForSearch(TwoSquares(1000), 10000);
  const PointLanes lanes(points);
  const std::vector<PointLanes::Range> ranges = {{3, 1001}, {1001, 1002}, {1007, points.size()}};
  RandomDraws draws(13, 0);
  std::size_t found = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const auto touched =
        static_cast<std::uint32_t>(draws.Uniform(0, static_cast<double>(points.size())));
    const auto model = Touching<TypeParam>({points.p[touched], points.n[touched]}, draws);
    std::vector<Hit> brute;
    for (const PointLanes::Range& range : ranges) {
      for (auto i = static_cast<std::uint32_t>(range.begin); i < range.end; ++i) {
        if (IsInlier(model, points, i)) brute.push_back({i, model.Distance_m(points.p[i])});
      }
    }
    const std::vector<Hit> hits = lanes.HitsIn(model, ranges);
    ASSERT_EQ(hits.size(), brute.size()) << trial;
    for (std::size_t k = 0; k < hits.size(); ++k) {
      ASSERT_EQ(hits[k].at, brute[k].at) << trial;
      ASSERT_EQ(hits[k].distance_m, brute[k].distance_m) << trial;  // equal bit by bit
    }
    found += hits.size();
  }
  EXPECT_GT(found, 200u);
}

TEST(PointLanes, OnAnAxisOrInACentreTakeTheDirectionThatTheModelTakes) {
  ModelPoints points;
  for (const Vector3& p : {Vector3(0, 0, 0), Vector3(0, 0, 0.01)}) {
    for (const Vector3& n : {Vector3(0, 0, 1), Vector3(1, 0, 0), Vector3(0, 1, 0)}) {
      points.p.push_back(p);
      points.n.push_back(n);
      points.gate_m.push_back(0.1);
      points.min_cos.push_back(0.9);
    }
  }
  const std::vector<PointLanes::Range> all = {{0, points.size()}};
  const auto expect_same = [&](const auto& model) {
    std::vector<std::uint32_t> brute, hits;
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      if (IsInlier(model, points, i)) brute.push_back(i);
    }
    for (const Hit& hit : PointLanes(points).HitsIn(model, all)) hits.push_back(hit.at);
    EXPECT_FALSE(brute.empty());
    EXPECT_EQ(hits, brute);
  };
  expect_same(SphereModel{.radius_m = 0.05});
  expect_same(CylinderModel{.radius_m = 0.05});
  expect_same(ConeModel{.radius_m = 0.05, .slope = 0.1});
}

TEST(Octree, CellsAroundAPointNestUpToTheRoot) {
  const ModelPoints points = SubsampleForSearch(TwoSquares(300), 10000);
  const Octree octree(points);
  for (std::uint32_t i = 0; i < points.size(); i += 17) {
    std::vector<std::uint32_t> cells;
    for (std::uint32_t cell = octree.LeafOf(i); cell != Octree::kNone;
         cell = octree.nodes()[cell].parent) {
      cells.push_back(cell);
    }
    ASSERT_FALSE(cells.empty());
    EXPECT_EQ(octree.nodes()[cells.back()].end - octree.nodes()[cells.back()].begin, points.size());
    for (std::uint32_t cell : cells) {
      EXPECT_LE(octree.nodes()[cell].begin, i);
      EXPECT_GT(octree.nodes()[cell].end, i);
    }
  }
}

TEST(CandidateList, LeaderIsTheShapeOfMostPoints) {
  const ModelPoints points = SubsampleForSearch(TwoSquares(1000), 10000);
  const Connectivity connectivity(points);
  CandidateList list(points, connectivity, 1);
  list.Add(LevelAt(0.06, points));
  list.Add(LevelAt(0, points));
  const Candidate* leader = list.Leader();
  ASSERT_NE(leader, nullptr);
  EXPECT_EQ(leader->inliers.size(), 1000u);
}

TEST(CandidateList, RescoresBySubtractionAsIfScoredAnew) {
  const ModelPoints points = SubsampleForSearch(TwoSquares(1000), 10000);
  const Connectivity connectivity(points);
  CandidateList list(points, connectivity, 1);
  list.Add(LevelAt(0, points));
  list.Add(LevelAt(0.001, points));  // shares its points with the first
  list.Add(LevelAt(0.06, points));
  const std::vector<std::uint32_t> taken = list.Leader()->inliers;
  list.Remove(taken);
  EXPECT_EQ(list.available_count(), points.size() - taken.size());
  const Candidate* next = list.Leader();
  ASSERT_NE(next, nullptr);
  std::set<std::uint32_t> brute;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (list.available()[i] && IsInlier(LevelAt(0.06, points), points, i)) brute.insert(i);
  }
  EXPECT_EQ(std::set<std::uint32_t>(next->inliers.begin(), next->inliers.end()), brute);
}

TEST(CandidateList, RefusedShapesDoNotComeBack) {
  const ModelPoints points = SubsampleForSearch(TwoSquares(1000), 10000);
  const Connectivity connectivity(points);
  CandidateList list(points, connectivity, 1);
  list.Add(LevelAt(0, points));
  const Candidate leader = *list.Leader();
  list.Reject(leader);
  list.Add(LevelAt(0.0005, points));
  EXPECT_EQ(list.Leader(), nullptr);
}

TEST(Connectivity, LargestComponentLeavesOutWhatLiesApart) {
  const ModelPoints points = SubsampleForSearch(TwoSquares(1000), 10000);
  const Connectivity connectivity(points);
  std::vector<std::uint32_t> level;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (points.n[i].z() > 0.9) level.push_back(i);
  }
  EXPECT_EQ(connectivity.LargestComponent(level).size(), 1000u);
  EXPECT_TRUE(connectivity.LargestComponent({}).empty());
}

}  // namespace
}  // namespace cwm::perception
