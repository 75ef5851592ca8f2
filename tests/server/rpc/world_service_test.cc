#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "server/core/geometry_store.h"
#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class WorldServiceTest : public RunningServer {
 protected:
  grpc::Status Apply(const v1::ApplyChangesRequest& request,
                     v1::ApplyChangesResponse* response = nullptr) {
    Call call;
    v1::ApplyChangesResponse ignored;
    return world_->ApplyChanges(&call, request, response != nullptr ? response : &ignored);
  }
  grpc::Status List(const v1::ListObjectsRequest& request, v1::ListObjectsResponse* response) {
    Call call;
    return world_->ListObjects(&call, request, response);
  }
};

std::vector<std::string> Names(const v1::ListObjectsResponse& response) {
  std::vector<std::string> names;
  for (const v1::Object& object : response.objects()) names.push_back(object.name());
  return names;
}

TEST_F(WorldServiceTest, PutMoveAndRemoveEachMakeOneRevision) {
  EXPECT_EQ(PutBox("crate", 1), 1);
  v1::ApplyChangesRequest request;
  request.add_changes()->mutable_move()->set_name("crate");
  v1::Pose* pose = request.mutable_changes(0)->mutable_move()->mutable_x_world_object();
  pose->set_tx_m(2);
  pose->set_qw(1);
  v1::ApplyChangesResponse response;
  ASSERT_TRUE(Apply(request, &response).ok());
  EXPECT_EQ(response.revision(), 2);
  ASSERT_TRUE(Apply(request, &response).ok());
  EXPECT_EQ(response.revision(), 2) << "a move to where it is has no effect";
  Call call;
  v1::GetObjectRequest get;
  get.set_name("crate");
  v1::GetObjectResponse got;
  ASSERT_TRUE(world_->GetObject(&call, get, &got).ok());
  EXPECT_EQ(got.object().x_world_object().tx_m(), 2);
  EXPECT_EQ(got.object().geometry_revision(), 1);
  EXPECT_EQ(got.object().pose_revision(), 2);
  EXPECT_EQ(got.world_uid(), response.world_uid());
  request.mutable_changes(0)->mutable_remove()->set_name("crate");
  ASSERT_TRUE(Apply(request, &response).ok());
  EXPECT_EQ(response.revision(), 3);
}

TEST_F(WorldServiceTest, AListOfChangesIsAppliedWholeOrNotAtAll) {
  PutBox("a", 0);
  v1::ApplyChangesRequest request;
  *request.add_changes() = PutBoxChange("b", 1);
  request.add_changes()->mutable_remove()->set_name("ghost");
  const grpc::Status status = Apply(request);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(ReasonIn(status), "OBJECT_UNKNOWN");
  ExpectRevision(1);
  v1::ListObjectsResponse objects;
  ASSERT_TRUE(List({}, &objects).ok());
  EXPECT_THAT(Names(objects), ElementsAre("a"));
}

TEST_F(WorldServiceTest, OfTwoWritersWithTheSameExpectationOneWins) {
  PutBox("a", 0);
  std::array<grpc::Status, 2> statuses;
  {
    std::vector<std::jthread> writers;
    for (int i = 0; i < 2; ++i) {
      writers.emplace_back([this, i, &statuses] {
        v1::ApplyChangesRequest request;
        request.set_expected_revision(1);
        *request.add_changes() = PutBoxChange("writer_" + std::to_string(i), 1 + i);
        statuses[i] = Apply(request);
      });
    }
  }
  EXPECT_NE(statuses[0].ok(), statuses[1].ok());
  const grpc::Status& loser = statuses[0].ok() ? statuses[1] : statuses[0];
  EXPECT_EQ(loser.error_code(), grpc::StatusCode::ABORTED);
  EXPECT_EQ(ReasonIn(loser), "REVISION_MISMATCH");
  ExpectRevision(2);
}

TEST_F(WorldServiceTest, ARetryGetsTheFirstReplyAndOtherContentIsRefused) {
  v1::ApplyChangesRequest request;
  request.set_request_id("once");
  *request.add_changes() = PutBoxChange("a", 0);
  v1::ApplyChangesResponse first;
  ASSERT_TRUE(Apply(request, &first).ok());
  v1::ApplyChangesRequest away;
  away.add_changes()->mutable_remove()->set_name("a");
  ASSERT_TRUE(Apply(away).ok());
  v1::ApplyChangesResponse again;
  ASSERT_TRUE(Apply(request, &again).ok());
  EXPECT_EQ(again.SerializeAsString(), first.SerializeAsString());
  EXPECT_EQ(again.revision(), 1);
  ExpectRevision(2);
  *request.add_changes() = PutBoxChange("c", 2);
  const grpc::Status reused = Apply(request);
  EXPECT_EQ(reused.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(ReasonIn(reused), "REQUEST_ID_REUSED");
  EXPECT_THAT(reused.error_message(), HasSubstr("once")) << "it names the id";
  ExpectRevision(2);
  v1::ListObjectsResponse listed;
  ASSERT_TRUE(List({}, &listed).ok());
  EXPECT_THAT(Names(listed), ElementsAre());
}

TEST_F(WorldServiceTest, ARetryGetsTheFirstReplyBeforeItsChangesAreLookedAt) {
  v1::ApplyChangesRequest request;
  request.set_request_id("once");
  *request.add_changes() = PutBoxChange("a", 0);
  v1::ApplyChangesResponse response;
  ASSERT_TRUE(Apply(request, &response).ok());
  // A retry is not validated again: a mesh that it names may be gone, or a limit lower.
  application_.limits.max_changes = 0;
  const grpc::Status retry = Apply(request, &response);
  EXPECT_TRUE(retry.ok()) << retry.error_message();
  EXPECT_EQ(response.revision(), 1);
  request.set_request_id("twice");
  EXPECT_EQ(FieldIn(Apply(request)), "changes");
}

TEST_F(WorldServiceTest, BadChangesNameTheirFieldAndLeaveTheWorldAlone) {
  PutBox("a", 0);
  v1::ApplyChangesRequest request;
  *request.add_changes() = PutBoxChange("good", 0);
  *request.add_changes() = PutBoxChange("bad", 0);
  request.mutable_changes(1)
      ->mutable_put()
      ->mutable_object()
      ->mutable_shapes(0)
      ->mutable_box()
      ->set_size_x_m(-0.1);
  const grpc::Status status = Apply(request);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(FieldIn(status), "changes[1].put.object.shapes[0].box.size_x_m");
  EXPECT_THAT(status.error_message(), HasSubstr("is -0.1"));
  ExpectRevision(1);
}

TEST_F(WorldServiceTest, OnlyAPutThatIsAppliedMakesAWorld) {
  v1::ApplyChangesRequest request;
  request.add_changes()->mutable_remove()->set_name("ghost");
  EXPECT_EQ(ReasonIn(Apply(request)), "WORLD_UNKNOWN");
  request.clear_changes();
  v1::MoveObject* move = request.add_changes()->mutable_move();
  move->set_name("ghost");
  move->mutable_x_world_object()->set_qw(1);
  EXPECT_EQ(ReasonIn(Apply(request)), "WORLD_UNKNOWN");
  request.clear_changes();
  *request.add_changes() = PutBoxChange("a", 0);
  request.add_changes()->mutable_remove()->set_name("ghost");
  EXPECT_EQ(ReasonIn(Apply(request)), "OBJECT_UNKNOWN");
  request.mutable_changes()->RemoveLast();
  request.set_expected_revision(5);
  EXPECT_EQ(ReasonIn(Apply(request)), "REVISION_MISMATCH");
  request.set_world_uid("another");
  EXPECT_EQ(ReasonIn(Apply(request)), "WORLD_UNKNOWN");
  v1::ListWorldsResponse worlds;
  {
    Call call;
    ASSERT_TRUE(world_->ListWorlds(&call, {}, &worlds).ok());
    EXPECT_EQ(worlds.worlds_size(), 0);
  }
  request.clear_world_uid();
  request.set_expected_revision(0);
  ASSERT_TRUE(Apply(request).ok());
  Call call;
  ASSERT_TRUE(world_->ListWorlds(&call, {}, &worlds).ok());
  EXPECT_EQ(worlds.worlds_size(), 1);
}

TEST_F(WorldServiceTest, ARepeatedDeletionGetsTheFirstReplyAndSparesTheSuccessor) {
  PutBox("a", 0);
  v1::DeleteWorldRequest request;
  request.set_request_id("once");
  v1::DeleteWorldResponse first;
  {
    Call call;
    ASSERT_TRUE(world_->DeleteWorld(&call, request, &first).ok());
  }
  PutBox("b", 0);
  v1::DeleteWorldResponse second;
  Call call;
  ASSERT_TRUE(world_->DeleteWorld(&call, request, &second).ok());
  EXPECT_EQ(second.world_uid(), first.world_uid());
  ExpectRevision(1);
}

TEST_F(WorldServiceTest, UnknownThingsAreNotFound) {
  PutBox("a", 0);
  v1::GetObjectRequest get;
  get.set_name("ghost");
  v1::GetObjectResponse got;
  {
    Call call;
    EXPECT_EQ(ReasonIn(world_->GetObject(&call, get, &got)), "OBJECT_UNKNOWN");
  }
  get.set_world("elsewhere");
  {
    Call call;
    const grpc::Status status = world_->GetObject(&call, get, &got);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
    EXPECT_EQ(ReasonIn(status), "WORLD_UNKNOWN");
  }
}

TEST_F(WorldServiceTest, AnotherWorldUnderTheNameIsNoticed) {
  PutBox("a", 0, "w");
  v1::DeleteWorldRequest request;
  request.set_world("w");
  v1::DeleteWorldResponse deleted;
  {
    Call call;
    ASSERT_TRUE(world_->DeleteWorld(&call, request, &deleted).ok());
    EXPECT_EQ(deleted.revision(), 1);
  }
  PutBox("a", 0, "w");
  v1::ListObjectsRequest list;
  list.set_world("w");
  list.set_world_uid(deleted.world_uid());
  v1::ListObjectsResponse objects;
  const grpc::Status status = List(list, &objects);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(ReasonIn(status), "WORLD_REPLACED");
}

TEST_F(WorldServiceTest, WorldsAreListedByName) {
  PutBox("a", 0, "zoo");
  PutBox("a", 0, "attic");
  Call call;
  v1::ListWorldsResponse response;
  ASSERT_TRUE(world_->ListWorlds(&call, {}, &response).ok());
  ASSERT_EQ(response.worlds_size(), 2);
  EXPECT_EQ(response.worlds(0).name(), "attic");
  EXPECT_EQ(response.worlds(1).object_count(), 1);
}

TEST_F(WorldServiceTest, PagesShowOneRevisionWhateverHappensBetween) {
  for (int i = 0; i < 5; ++i) PutBox("box_" + std::to_string(i), i);
  v1::ListObjectsRequest request;
  request.set_page_size(2);
  v1::ListObjectsResponse page;
  ASSERT_TRUE(List(request, &page).ok());
  EXPECT_THAT(Names(page), ElementsAre("box_0", "box_1"));
  PutBox("box_2b", 9);
  request.set_page_token(page.next_page_token());
  ASSERT_TRUE(List(request, &page).ok());
  EXPECT_THAT(Names(page), ElementsAre("box_2", "box_3"));
  EXPECT_EQ(page.revision(), 5);
  request.set_page_token(page.next_page_token());
  ASSERT_TRUE(List(request, &page).ok());
  EXPECT_THAT(Names(page), ElementsAre("box_4"));
  EXPECT_TRUE(page.next_page_token().empty());
}

TEST_F(WorldServiceTest, ATokenIsBoundToItsFilter) {
  for (int i = 0; i < 3; ++i) PutBox("box_" + std::to_string(i), i);
  v1::ListObjectsRequest request;
  request.set_page_size(1);
  v1::ListObjectsResponse page;
  ASSERT_TRUE(List(request, &page).ok());
  request.set_page_token(page.next_page_token());
  request.set_name_prefix("box");
  EXPECT_EQ(FieldIn(List(request, &page)), "page_token");
  for (const char* forged : {"x", "====", "Zm9vIDEgYmFy"}) {
    request.set_page_token(forged);
    EXPECT_EQ(FieldIn(List(request, &page)), "page_token") << forged;
  }
  // Lengths that no name, list of kinds or token needs are refused before any work.
  request.set_page_token(std::string(1025, 'a'));
  EXPECT_EQ(FieldIn(List(request, &page)), "page_token");
  request.clear_page_token();
  request.set_name_prefix(std::string(129, 'a'));
  EXPECT_EQ(FieldIn(List(request, &page)), "name_prefix");
  request.set_name_prefix(std::string(128, 'a'));
  EXPECT_TRUE(List(request, &page).ok());
  for (int k = 0; k < 33; ++k) request.add_kinds(v1::OBJECT_KIND_OBJECT);
  EXPECT_EQ(FieldIn(List(request, &page)), "kinds");
}

TEST_F(WorldServiceTest, FiltersByKindPrefixAndBox) {
  PutBox("near", 0);
  PutBox("far", 10);
  v1::ListObjectsRequest request;
  v1::ListObjectsResponse response;
  request.set_name_prefix("n");
  ASSERT_TRUE(List(request, &response).ok());
  EXPECT_THAT(Names(response), ElementsAre("near"));
  request.Clear();
  request.mutable_within()->mutable_min()->set_x(5);
  request.mutable_within()->mutable_max()->set_x(9.95);
  ASSERT_TRUE(List(request, &response).ok());
  EXPECT_THAT(Names(response), ElementsAre("far"));
  request.mutable_within()->mutable_max()->set_x(9.85);
  ASSERT_TRUE(List(request, &response).ok());
  EXPECT_THAT(Names(response), ElementsAre());
  request.mutable_within()->mutable_max()->set_x(4);
  EXPECT_EQ(FieldIn(List(request, &response)), "within.min");
  request.Clear();
  request.add_kinds(v1::OBJECT_KIND_SUPPORT);
  ASSERT_TRUE(List(request, &response).ok());
  EXPECT_EQ(response.objects_size(), 0);
}

TEST_F(WorldServiceTest, AtLeastWaitsForTheRevisionAndForTheDeadline) {
  PutBox("a", 0);
  v1::ListObjectsRequest request;
  request.mutable_at_revision()->set_at_least(2);
  v1::ListObjectsResponse response;
  {
    Call call(std::chrono::milliseconds(100));
    EXPECT_EQ(world_->ListObjects(&call, request, &response).error_code(),
              grpc::StatusCode::DEADLINE_EXCEEDED);
  }
  const std::jthread writer([this] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    PutBox("b", 1);
  });
  ASSERT_TRUE(List(request, &response).ok());
  EXPECT_THAT(Names(response), ElementsAre("a", "b"));
}

TEST_F(WorldServiceTest, NobodyWaitsForARevisionOfAWorldThatWasReplaced) {
  PutBox("a", 0);
  const std::string old_uid = "0123456789abcdef0123456789abcdef";
  v1::AtRevision future;
  future.set_at_least(99);
  // A call that waited would end with DEADLINE_EXCEEDED.
  {
    Call call(std::chrono::seconds(5));
    v1::ListObjectsRequest request;
    *request.mutable_at_revision() = future;
    request.set_world_uid(old_uid);
    v1::ListObjectsResponse response;
    EXPECT_EQ(ReasonIn(world_->ListObjects(&call, request, &response)), "WORLD_REPLACED");
  }
  {
    Call call(std::chrono::seconds(5));
    v1::GetObjectRequest request;
    request.set_name("a");
    *request.mutable_at_revision() = future;
    request.set_world_uid(old_uid);
    v1::GetObjectResponse response;
    EXPECT_EQ(ReasonIn(world_->GetObject(&call, request, &response)), "WORLD_REPLACED");
  }
  v1::GetDistancesRequest query;
  *query.mutable_subject() = SphereAt({0.5});
  *query.mutable_options()->mutable_at_revision() = future;
  query.mutable_options()->set_world_uid(old_uid);
  {
    Call call(std::chrono::seconds(5));
    v1::GetDistancesResponse response;
    EXPECT_EQ(ReasonIn(query_->GetDistances(&call, query, &response)), "WORLD_REPLACED");
  }
  Call call(std::chrono::seconds(5));
  const auto stream = query_->StreamQueries(&call);
  v1::StreamQueriesRequest request;
  *request.mutable_get_distances() = query;
  v1::StreamQueriesResponse response;
  ASSERT_TRUE(stream->Write(request) && stream->Read(&response));
  EXPECT_EQ(response.error().reason(), "WORLD_REPLACED");
}

// More waits than any queue has threads: reads and queries continue meanwhile.
TEST_F(WorldServiceTest, WaitingForARevisionHoldsNoWorker) {
  constexpr int kWaits = 40;
  PutBox("a", 0);
  std::atomic<int> answered = 0;
  {
    std::vector<std::jthread> waiters;
    for (int i = 0; i < kWaits; ++i) {
      waiters.emplace_back([&] {
        Call call;
        v1::GetDistancesRequest request;
        *request.mutable_subject() = SphereAt({0.5});
        request.mutable_options()->mutable_at_revision()->set_at_least(2);
        v1::GetDistancesResponse response;
        const grpc::Status status = query_->GetDistances(&call, request, &response);
        EXPECT_TRUE(status.ok()) << status.error_message();
        EXPECT_EQ(response.revision(), 2);
        ++answered;
      });
    }
    v1::GetDistancesRequest now;
    *now.mutable_subject() = SphereAt({0.5});
    for (int i = 0; i < kWaits; ++i) {
      Call call;
      v1::GetDistancesResponse response;
      ASSERT_TRUE(query_->GetDistances(&call, now, &response).ok());
      EXPECT_EQ(response.revision(), 1);
    }
    EXPECT_EQ(answered, 0);
    PutBox("b", 1);
  }
  EXPECT_EQ(answered, kWaits);
}

TEST_F(WorldServiceTest, ExactRevisionsAnswerAsTheyDid) {
  PutBox("a", 0);
  PutBox("b", 1);
  v1::ListObjectsRequest request;
  request.mutable_at_revision()->set_exact(1);
  v1::ListObjectsResponse response;
  ASSERT_TRUE(List(request, &response).ok());
  EXPECT_THAT(Names(response), ElementsAre("a"));
  request.mutable_at_revision()->set_exact(99);
  EXPECT_EQ(List(request, &response).error_code(), grpc::StatusCode::OUT_OF_RANGE);
}

}  // namespace
}  // namespace cwm::server
