#include "server/wire/request_cost.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "server/core/error.h"
#include "server/wire/objects.h"
#include "server/wire/shapes.h"
#include "tests/server/core/ends_at_check.h"
#include "tests/server/core/spindle.h"
#include "tests/server/wire/wire_test_values.h"

namespace cwm::server {
namespace {

v1::Change PutOfMentions(const std::string& hash, int mentions) {
  v1::Change change;
  v1::Object& object = *change.mutable_put()->mutable_object();
  object.set_name("pile");
  for (int i = 0; i < mentions; ++i) object.add_shapes()->mutable_mesh()->set_hash(hash);
  return change;
}

// A request that once blocked everybody: a few bytes for each reference to one large mesh.
TEST(Mentions, OfOneMeshPrepareItOnce) {
  GeometryStore store(std::int64_t{1} << 30);
  const auto stored = store.Put(BlobFormat::kMeshF64, EncodeMesh(Spindle(20'000)));
  ASSERT_TRUE(stored.ok());
  google::protobuf::RepeatedPtrField<v1::Change> changes;
  *changes.Add() = PutOfMentions(stored->hash, 600);
  WorkBudget budget;
  const auto read = ChangesFromProto(changes, Limits{}, store, {}, "changes", &budget);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(store.FindMesh(stored->hash)->facts->computed(), 1);
  const auto& put = std::get<collision::PutObject>(read->front().what);
  ASSERT_EQ(put.geometry->parts.size(), 600u);
  for (const collision::PreparedPart& part : put.geometry->parts) {
    EXPECT_EQ(part.engines[0], put.geometry->parts.front().engines[0]);
  }
}

TEST(Mentions, AreReadNoLongerThanTheBudgetLasts) {
  GeometryStore store(std::int64_t{1} << 30);
  const auto stored = store.Put(BlobFormat::kMeshF64, EncodeMesh(Spindle(50'000)));
  ASSERT_TRUE(stored.ok());
  google::protobuf::RepeatedPtrField<v1::Change> changes;
  for (int i = 0; i < 20; ++i) *changes.Add() = PutOfMentions(stored->hash, 600);
  for (const int check : {1, 2, 5}) {
    EndsAtCheck budget(check);
    const auto ended = ChangesFromProto(changes, Limits{}, store, {}, "changes", &budget);
    EXPECT_TRUE(absl::IsCancelled(ended.status())) << ended.status();
    EXPECT_EQ(budget.check_count(), check);
  }
}

TEST(RequestCost, GrowsWithRowsPartsAndWhatHasToBePrepared) {
  GeometryStore store(std::int64_t{1} << 30);
  const CostSource source{store};
  v1::CheckCollisionsRequest request;
  v1::Subject::Shapes& shapes = *request.mutable_subject()->mutable_shapes();
  shapes.add_shapes()->mutable_sphere()->set_radius_m(0.1);
  const double of_one_s = EstimatedCost_s(request, source);
  EXPECT_GT(of_one_s, 0);
  shapes.mutable_x_world_body()->set_data(std::string(7 * 8 * 10'000, '\0'));
  const double of_rows_s = EstimatedCost_s(request, source);
  EXPECT_GT(of_rows_s, 10 * of_one_s);
  for (int i = 0; i < 99; ++i) shapes.add_shapes()->mutable_sphere()->set_radius_m(0.1);
  EXPECT_GT(EstimatedCost_s(request, source), 10 * of_rows_s);

  const auto stored = store.Put(BlobFormat::kMeshF64, EncodeMesh(Spindle(50'000)));
  v1::ApplyChangesRequest changes;
  *changes.add_changes() = PutOfMentions(stored->hash, 1);
  const double of_mesh_s = EstimatedCost_s(changes, source);
  EXPECT_GT(of_mesh_s, 0.1);
  *changes.add_changes() = PutOfMentions(stored->hash, 1000);
  EXPECT_LT(EstimatedCost_s(changes, source), 1.1 * of_mesh_s);  // prepared once
  const auto found = store.FindMesh(stored->hash);
  found->facts->SolidOf(found->mesh, nullptr);
  EXPECT_LT(EstimatedCost_s(changes, source), 0.1 * of_mesh_s);  // prepared by now
}

TEST(RequestCost, AboveTheLimitNamesBoth) {
  Limits limits;
  limits.max_request_cost_s = 2;
  EXPECT_TRUE(CheckCost(1.9, limits).ok());
  const absl::Status refused = CheckCost(7.25, limits);
  EXPECT_TRUE(absl::IsResourceExhausted(refused));
  const ErrorDetails details = DetailsOf(refused);
  EXPECT_EQ(details.reason, "REQUEST_TOO_COSTLY");
  EXPECT_EQ(details.metadata.at("max_request_cost_s"), "2.0");
  EXPECT_FALSE(details.retry_after_s.has_value());  // a retry of the same request cannot succeed
}

}  // namespace
}  // namespace cwm::server
