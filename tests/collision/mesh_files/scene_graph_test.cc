#include "collision/mesh_files/scene_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cwm::collision {
namespace {

using ::testing::HasSubstr;
using Graph = std::vector<std::vector<int>>;

// A graph in which each node except the last uses the next one `times` times.
Graph Chain(int length, int times) {
  Graph graph(length);
  for (int i = 0; i + 1 < length; ++i) graph[i].assign(times, i + 1);
  return graph;
}

TEST(SceneGraph, TakesTreesAndSharedNodes) {
  EXPECT_TRUE(CheckSceneGraph({}).ok());
  EXPECT_TRUE(CheckSceneGraph({{1, 2}, {3}, {3}, {}}).ok());
  EXPECT_TRUE(CheckSceneGraph(Graph(100'000)).ok());
}

TEST(SceneGraph, AllowsAHundredNodesBelowEachOtherAndNoMore) {
  EXPECT_TRUE(CheckSceneGraph(Chain(100, 1)).ok());
  EXPECT_THAT(std::string(CheckSceneGraph(Chain(101, 1)).message()), HasSubstr("deeper than 100"));
}

TEST(SceneGraph, MeasuresDepthThroughNodesThatWereMeasuredBefore) {
  Graph graph = Chain(60, 1);  // nodes 0 to 59
  graph.emplace_back();        // node 60 leads over 40 more to node 0
  for (int i = 0; i < 40; ++i) {
    graph.back().push_back(static_cast<int>(graph.size()));
    graph.emplace_back();
  }
  graph.back().push_back(0);
  EXPECT_FALSE(CheckSceneGraph(graph).ok());
}

TEST(SceneGraph, RefusesCircles) {
  EXPECT_FALSE(CheckSceneGraph({{0}}).ok());
  EXPECT_FALSE(CheckSceneGraph({{1}, {2}, {1}}).ok());
}

TEST(SceneGraph, RefusesGraphsThatUnfoldWithoutEnd) {
  EXPECT_TRUE(CheckSceneGraph(Chain(16, 2)).ok());  // 65 535 nodes
  EXPECT_THAT(std::string(CheckSceneGraph(Chain(17, 2)).message()), HasSubstr("100000"));
  EXPECT_FALSE(CheckSceneGraph(Chain(90, 10)).ok());  // 10^89 nodes: the count must not overflow
}

}  // namespace
}  // namespace cwm::collision
