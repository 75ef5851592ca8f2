#include "server/core/work_budget.h"

#include <gtest/gtest.h>

#include <memory>

#include "server/core/error.h"
#include "server/core/geometry_store.h"
#include "server/core/world.h"
#include "tests/server/core/ends_at_check.h"
#include "tests/server/core/test_objects.h"

namespace cwm::server {
namespace {

TriangleMesh ClosedMesh() {
  return {.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
          .triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
}

TEST(WorkBudget, SaysWhyItEnded) {
  WorkBudget forever;
  EXPECT_FALSE(forever.MustEndNow());
  EXPECT_TRUE(forever.status().ok());

  WorkBudget late(Clock::now() - std::chrono::seconds(1), {});
  EXPECT_TRUE(late.MustEndAfter(1));  // the first step checks
  EXPECT_TRUE(absl::IsDeadlineExceeded(late.status()));
  EXPECT_EQ(DetailsOf(late.status()).reason, "TIME_BUDGET_SPENT");

  std::stop_source stop;
  WorkBudget cancelled(Clock::time_point::max(), stop.get_token());
  EXPECT_FALSE(cancelled.MustEndNow());
  stop.request_stop();
  EXPECT_TRUE(cancelled.MustEndNow());
  EXPECT_TRUE(absl::IsCancelled(cancelled.status()));
  EXPECT_TRUE(cancelled.MustEndAfter(0));  // and stays ended
}

TEST(WorkBudget, LooksOnceForSoManySteps) {
  WorkBudget budget;
  for (int i = 0; i < 10'000; ++i) EXPECT_FALSE(budget.MustEndAfter(100));
  EXPECT_GT(budget.check_count(), 10);
  EXPECT_LT(budget.check_count(), 100);
}

TEST(MeshFacts, AreComputedOncePerStoredMeshAndGoWithIt) {
  GeometryStore store(1 << 20);
  const auto stored = store.Put(BlobFormat::kMeshF64, EncodeMesh(ClosedMesh()));
  ASSERT_TRUE(stored.ok());
  const auto first = store.FindMesh(stored->hash), second = store.FindMesh(stored->hash);
  ASSERT_TRUE(first.ok() && second.ok());
  EXPECT_EQ(first->facts, second->facts);
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(first->facts->SolidOf(first->mesh, nullptr)->watertight);
    EXPECT_TRUE(second->facts->HullOf(second->mesh, nullptr)->fault.empty());
  }
  EXPECT_EQ(first->facts->computed(), 2);  // one computation of each fact
  EXPECT_EQ(store.encoded_count(), 0);
}

TEST(MeshFacts, WhatWasEndedIsComputedAgain) {
  GeometryStore store(1 << 20);
  const auto stored = store.Put(BlobFormat::kMeshF64, EncodeMesh(ClosedMesh()));
  const auto found = store.FindMesh(stored->hash);
  EndsAtCheck at_once(1);
  EXPECT_FALSE(found->facts->SolidOf(found->mesh, &at_once).has_value());
  EXPECT_TRUE(found->facts->SolidOf(found->mesh, nullptr)->watertight);
}

TEST(GeometryStore, AnUploadEndsWithItsBudgetAndStoresNothing) {
  GeometryStore store(1 << 20);
  EndsAtCheck at_once(1);
  const auto refused = store.Put(BlobFormat::kMeshF64, EncodeMesh(ClosedMesh()), &at_once);
  EXPECT_TRUE(absl::IsCancelled(refused.status()));
  const auto stored = store.Put(BlobFormat::kMeshF64, EncodeMesh(ClosedMesh()));
  ASSERT_TRUE(stored.ok());
  EXPECT_FALSE(stored->already_known);
}

// A long list is applied before the writer's turn is taken, all or nothing.
TEST(World, ALongListEndsWithItsBudgetAndChangesNothing) {
  const auto world = std::make_shared<World>("w", "uid", Retention{});
  std::vector<collision::Change> changes;
  for (int i = 0; i < 1000; ++i) changes.push_back(Put("object_" + std::to_string(i), i));
  for (const int check : {1, 2}) {
    EndsAtCheck budget(check);
    EXPECT_TRUE(absl::IsCancelled(world->Apply(changes, {}, &budget).status())) << check;
  }
  EXPECT_EQ(world->Snapshot()->revision().value, 0);
  WorkBudget forever;
  ASSERT_TRUE(world->Apply(changes, {}, &forever).ok());
  EXPECT_EQ(world->Snapshot()->revision().value, 1);
  EXPECT_EQ(world->Snapshot()->objects().size(), 1000u);
  EXPECT_EQ(world->Snapshot()->weight(), 1000);
}

}  // namespace
}  // namespace cwm::server
