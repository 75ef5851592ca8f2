// Tests work on meshes that is stopped midway, and values that are built once.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <random>
#include <thread>
#include <utility>
#include <vector>

#include "collision/geometry/interruptible_sort.h"
#include "collision/geometry/lazy.h"
#include "collision/geometry/mesh_parts.h"
#include "collision/geometry/validation.h"

namespace cwm {
namespace {

// Ends the work at the n-th check.
class EndsAtLook : public WorkCounter {
 public:
  explicit EndsAtLook(int look) : left_(look) {}
  bool MustEndAfter(std::size_t steps) override {
    max_at_once_ = std::max(max_at_once_, steps);
    if (steps > 0) ++looks_;
    return looks_ >= left_;
  }
  bool MustEndNow() override { return MustEndAfter(1); }
  int looks() const { return looks_; }
  std::size_t max_at_once() const { return max_at_once_; }

 private:
  int left_;
  int looks_ = 0;
  std::size_t max_at_once_ = 0;
};

constexpr int kNever = 1 << 30;

// A closed sheet with two sides and `squares` squares along an edge.
TriangleMesh Pillow(std::uint32_t squares) {
  TriangleMesh mesh;
  const std::uint32_t corners = squares + 1;
  for (const double z : {0.0, 1.0}) {
    for (std::uint32_t i = 0; i < corners * corners; ++i) {
      const bool at_rim =
          i % corners == 0 || i % corners == squares || i / corners == 0 || i / corners == squares;
      mesh.vertices.emplace_back(i % corners, i / corners, at_rim ? 0.5 : z);
    }
  }
  for (std::uint32_t i = 0; i < squares * squares; ++i) {
    const std::uint32_t a = i / squares * corners + i % squares, b = a + 1, c = a + corners;
    const std::uint32_t d = c + 1, top = corners * corners;
    mesh.triangles.push_back({a, d, b});
    mesh.triangles.push_back({a, c, d});
    mesh.triangles.push_back({top + a, top + b, top + d});
    mesh.triangles.push_back({top + a, top + d, top + c});
  }
  return mesh;
}

TEST(InterruptibleSort, OrdersAsStdSortDoes) {
  std::mt19937_64 random(7);
  for (const std::size_t size : {0u, 1u, 1000u, 32'768u, 32'769u, 200'000u}) {
    std::vector<std::uint64_t> values(size);
    for (std::uint64_t& value : values) value = random() % 5'000;
    std::vector<std::uint64_t> sorted = values;
    std::sort(sorted.begin(), sorted.end());
    InterruptibleSort(values, std::less<>());
    EXPECT_EQ(values, sorted) << size;
  }
}

// A closed mesh of triangles that share positions but no indices, as in an STL file.
TriangleMesh SpindleOfLooseTriangles(std::uint32_t sides) {
  TriangleMesh mesh;
  const auto at = [sides](std::uint32_t k) {
    const double angle = 2 * std::numbers::pi * (k % sides) / sides;
    return Vector3(std::cos(angle), std::sin(angle), 0);
  };
  const auto add = [&mesh](const Vector3& a, const Vector3& b, const Vector3& c) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {a, b, c});
    mesh.triangles.push_back({first, first + 1, first + 2});
  };
  for (std::uint32_t k = 0; k < sides; ++k) {
    add(Vector3(0, 0, 1), at(k), at(k + 1));
    add(Vector3(0, 0, -1), at(k + 1), at(k));
  }
  return mesh;
}

TEST(Interrupted, AMeshThatIsClosedByPlacesAloneIsWatertightWhateverItsSize) {
  for (const std::uint32_t sides : {3u, 100u, 30'000u}) {
    TriangleMesh mesh = SpindleOfLooseTriangles(sides);
    EXPECT_FALSE(IsWatertightByIndex(mesh));
    EXPECT_TRUE(IsWatertight(mesh)) << sides;
    EXPECT_TRUE(TrianglesWoundInward(mesh, ConnectedComponents(mesh)).empty());
    EXPECT_EQ(ComponentPoints(mesh).size(), 1u);
    for (TriangleMesh::Triangle& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
    EXPECT_EQ(TrianglesWoundInward(mesh, ConnectedComponents(mesh)),
              std::vector<bool>(mesh.triangles.size(), true));
    mesh.triangles.pop_back();
    EXPECT_FALSE(IsWatertight(mesh)) << sides;
  }
}

TEST(Interrupted, EndsAtTheLookThatSaysSo) {
  const TriangleMesh mesh = Pillow(150);
  const std::vector<std::function<void(WorkCounter*)>> works = {
      [&](WorkCounter* work) { IsWatertight(mesh, work); },
      [&](WorkCounter* work) { ConnectedComponents(mesh, work); },
      [&](WorkCounter* work) { ConvexHull3(mesh.vertices, work); },
      [&](WorkCounter* work) { FindViolation(mesh, work); },
      [&](WorkCounter* work) { SignedVolume_m3(mesh, work); }};
  for (std::size_t k = 0; k < works.size(); ++k) {
    EndsAtLook all(kNever);
    works[k](&all);
    EXPECT_GT(all.looks(), 10) << k;
    EXPECT_LE(all.max_at_once(), std::size_t{1} << 17) << k;  // a few milliseconds
    for (const int look : {1, all.looks() / 2, all.looks()}) {
      EndsAtLook counter(look);
      works[k](&counter);
      EXPECT_LE(counter.looks(), look + 4) << k;
    }
  }
}

TEST(Lazy, IsBuiltOnceForAllWhoAskAtATime) {
  const Lazy<int> value;
  std::atomic<int> built = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < 8; ++i) {
    threads.emplace_back([&] {
      const int* got = value.Get([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        return ++built;
      });
      EXPECT_EQ(*got, 1);
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(built, 1);
}

TEST(Lazy, WhatWasEndedIsBuiltByTheNext) {
  const Lazy<int> value;
  EndsAtLook at_once(1);
  EXPECT_EQ(value.Get(
                [&] {
                  EXPECT_TRUE(MustEnd(&at_once, 1));
                  return 1;
                },
                &at_once),
            nullptr);
  EXPECT_EQ(value.GetIfBuilt(), nullptr);
  EXPECT_EQ(*value.Get([] { return 2; }), 2);
}

// A thread that waits for another one's build leaves when its own time is over.
TEST(Lazy, AWaitEndsWithItsOwnCounter) {
  const Lazy<int> value;
  std::atomic<bool> under_way = false, may_end = false;
  std::thread builder([&] {
    value.Get([&] {
      under_way = true;
      while (!may_end) std::this_thread::yield();
      return 1;
    });
  });
  while (!under_way) std::this_thread::yield();
  EndsAtLook soon(2);
  EXPECT_EQ(value.Get([] { return 2; }, &soon), nullptr);
  EXPECT_EQ(soon.looks(), 2);
  may_end = true;
  builder.join();
  EXPECT_EQ(*value.GetIfBuilt(), 1);
}

}  // namespace
}  // namespace cwm
