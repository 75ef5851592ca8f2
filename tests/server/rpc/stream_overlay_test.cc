// Overlays of streams: they apply to the stream's own queries, at any revision.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

constexpr double kExact_m = 1e-9;

// Distances along one stream, each to the nearest obstacle.
class StreamOverlayTest : public RunningServer {
 protected:
  StreamOverlayTest() {
    PutBox("left", 0);
    PutBox("right", 2);
  }
  v1::StreamQueriesResponse Send(const v1::StreamQueriesRequest& request) {
    v1::StreamQueriesResponse response;
    EXPECT_TRUE(stream_->Write(request) && stream_->Read(&response));
    return response;
  }
  static v1::StreamQueriesRequest AtHalf() {
    v1::StreamQueriesRequest request;
    *request.mutable_get_distances()->mutable_subject() = SphereAt({0.5});
    return request;
  }
  static v1::StreamQueriesRequest Supposing(const std::vector<v1::Change>& changes) {
    v1::StreamQueriesRequest request;
    request.mutable_overlay()->mutable_changes()->Assign(changes.begin(), changes.end());
    return request;
  }
  static double Nearest_m(const v1::GetDistancesResponse& response) {
    double distance_m = NAN;
    const std::string& bytes = response.columns().distance_m();
    if (bytes.size() >= sizeof(double)) std::memcpy(&distance_m, bytes.data(), sizeof(double));
    return distance_m;
  }
  double NearestToHalf_m() {
    const v1::StreamQueriesResponse response = Send(AtHalf());
    EXPECT_FALSE(response.has_error()) << response.error().message();
    return Nearest_m(response.get_distances());
  }

  Call call_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::StreamQueriesRequest, v1::StreamQueriesResponse>>
      stream_ = query_->StreamQueries(&call_);
};

TEST_F(StreamOverlayTest, HoldsForAllQueriesOfItsStreamAndNoOther) {
  EXPECT_NEAR(NearestToHalf_m(), 0.3, kExact_m);
  v1::StreamQueriesRequest opening = Supposing({PutBoxChange("near", 0.9)});
  opening.set_id(7);
  const v1::StreamQueriesResponse opened = Send(opening);
  EXPECT_EQ(opened.id(), 7);
  EXPECT_EQ(opened.answer_case(), v1::StreamQueriesResponse::ANSWER_NOT_SET);
  EXPECT_NEAR(NearestToHalf_m(), 0.2, kExact_m);
  EXPECT_NEAR(NearestToHalf_m(), 0.2, kExact_m);
  // The overlay applies to whichever revision is queried.
  PutBox("between", 0.85);
  EXPECT_NEAR(NearestToHalf_m(), 0.15, kExact_m);
  v1::StreamQueriesRequest before = AtHalf();
  before.mutable_get_distances()->mutable_options()->mutable_at_revision()->set_exact(2);
  const v1::StreamQueriesResponse earlier = Send(before);
  EXPECT_EQ(earlier.get_distances().revision(), 2);
  EXPECT_NEAR(Nearest_m(earlier.get_distances()), 0.2, kExact_m);
  // A query's own overlay is applied after it.
  v1::StreamQueriesRequest both = AtHalf();
  v1::Change* own = both.mutable_get_distances()->mutable_options()->add_overlay();
  own->mutable_remove()->set_name("near");
  both.mutable_get_distances()->mutable_options()->add_ignore("between");
  EXPECT_NEAR(Nearest_m(Send(both).get_distances()), 0.3, kExact_m);
  // Another overlay replaces it, from the query in the same message on.
  v1::StreamQueriesRequest other = AtHalf();
  *other.mutable_overlay()->add_changes() = PutBoxChange("nearer", 0.8);
  EXPECT_NEAR(Nearest_m(Send(other).get_distances()), 0.1, kExact_m);
  // Other clients do not see it, and no revision is made.
  v1::GetDistancesResponse response;
  Call unary;
  ASSERT_TRUE(query_->GetDistances(&unary, AtHalf().get_distances(), &response).ok());
  EXPECT_NEAR(Nearest_m(response), 0.15, kExact_m);
  ExpectRevision(3);
  // An empty overlay removes it.
  EXPECT_FALSE(Send(Supposing({})).has_error());
  EXPECT_NEAR(NearestToHalf_m(), 0.15, kExact_m);
}

TEST_F(StreamOverlayTest, IsOfOneWorld) {
  PutBox("far", 5, "other");
  Send(Supposing({PutBoxChange("near", 0.9)}));
  v1::StreamQueriesRequest elsewhere = AtHalf();
  elsewhere.mutable_get_distances()->set_world("other");
  EXPECT_NEAR(Nearest_m(Send(elsewhere).get_distances()), 4.3, kExact_m);
  elsewhere.mutable_get_distances()->set_world("default");
  EXPECT_NEAR(Nearest_m(Send(elsewhere).get_distances()), 0.2, kExact_m);
}

TEST_F(StreamOverlayTest, ThatCannotBeAppliedIsToldToEachQueryAndNeverLeftOut) {
  v1::Change ghost;
  ghost.mutable_remove()->set_name("ghost");
  EXPECT_FALSE(Send(Supposing({ghost})).has_error()) << "the world may come to have it";
  for (int i = 0; i < 2; ++i) {
    const v1::StreamQueriesResponse response = Send(AtHalf());
    EXPECT_EQ(response.error().reason(), "OBJECT_UNKNOWN");
    EXPECT_EQ(response.error().message(), "overlay.changes[0]: object 'ghost' does not exist");
  }
  v1::Change nameless;
  nameless.mutable_remove()->set_name("no such/ name!");
  EXPECT_EQ(Send(Supposing({nameless})).error().fields(0).field(),
            "overlay.changes[0].remove.name");
  EXPECT_EQ(Send(AtHalf()).error().fields(0).field(), "overlay.changes[0].remove.name");
  const std::vector<v1::Change> many(20'000, PutBoxChange("near", 0.9));
  EXPECT_EQ(Send(Supposing(many)).error().fields(0).field(), "overlay");
  EXPECT_FALSE(Send(Supposing({})).has_error());
  EXPECT_NEAR(NearestToHalf_m(), 0.3, kExact_m);
}

TEST_F(StreamOverlayTest, AllowsForATimeAndNoLonger) {
  v1::StreamQueriesRequest check;
  *check.mutable_check_collisions()->mutable_subject() = SphereAt({0});
  check.mutable_check_collisions()->mutable_options()->set_result_form(v1::RESULT_FORM_ROWS);
  const auto verdict = [&](const v1::StreamQueriesRequest& query) {
    const v1::StreamQueriesResponse response = Send(query);
    EXPECT_FALSE(response.has_error()) << response.error().message();
    return response.check_collisions().rows(0).verdict();
  };
  v1::Change change;
  change.mutable_allow()->mutable_pair()->mutable_a()->set_name("left");
  change.mutable_allow()->mutable_pair()->mutable_b()->set_name("*");
  constexpr std::chrono::seconds kAllowed{1};
  change.mutable_allow()->mutable_expires_after()->set_seconds(kAllowed.count());
  v1::StreamQueriesRequest first = check;
  *first.mutable_overlay()->add_changes() = change;
  EXPECT_EQ(verdict(first), v1::VERDICT_FREE);
  std::this_thread::sleep_for(kAllowed);
  // The query is about the same revision as before.
  EXPECT_EQ(verdict(check), v1::VERDICT_COLLISION);
  // If an allowance is first permanent and then temporary, the latter counts. A withdrawal before
  // it does not expire with it.
  v1::StreamQueriesRequest twice = check;
  *twice.mutable_overlay()->add_changes() = change;
  twice.mutable_overlay()->mutable_changes(0)->mutable_allow()->clear_expires_after();
  *twice.mutable_overlay()->add_changes() = change;
  EXPECT_EQ(verdict(twice), v1::VERDICT_FREE);
  v1::ApplyChangesRequest allow;
  *allow.add_changes() = change;
  allow.mutable_changes(0)->mutable_allow()->clear_expires_after();
  std::this_thread::sleep_for(kAllowed);
  EXPECT_EQ(verdict(check), v1::VERDICT_COLLISION);
  // Allowances of the world remain after an overlay's allowance has expired.
  Call call;
  v1::ApplyChangesResponse allowed;
  ASSERT_TRUE(world_->ApplyChanges(&call, allow, &allowed).ok());
  EXPECT_EQ(verdict(first), v1::VERDICT_FREE);
  std::this_thread::sleep_for(kAllowed);
  EXPECT_EQ(verdict(check), v1::VERDICT_FREE);
  v1::StreamQueriesRequest withdrawn = twice;
  withdrawn.mutable_overlay()->mutable_changes(0)->mutable_allow()->set_withdraw(true);
  EXPECT_EQ(verdict(withdrawn), v1::VERDICT_FREE);
  std::this_thread::sleep_for(kAllowed);
  EXPECT_EQ(verdict(check), v1::VERDICT_COLLISION);
}

TEST_F(StreamOverlayTest, IsOfNoOtherWorldThatComesToHaveTheName) {
  Send(Supposing({PutBoxChange("near", 0.9)}));
  Call call;
  v1::DeleteWorldResponse deleted;
  ASSERT_TRUE(world_->DeleteWorld(&call, {}, &deleted).ok());
  PutBox("left", 0);
  EXPECT_EQ(Send(AtHalf()).error().reason(), "WORLD_REPLACED");
  Send(Supposing({PutBoxChange("near", 0.9)}));
  EXPECT_NEAR(NearestToHalf_m(), 0.2, kExact_m);
  // An overlay set before the world exists applies to the first world of that name.
  v1::StreamQueriesRequest early = Supposing({PutBoxChange("near", 0.9)});
  early.mutable_overlay()->set_world("later");
  Send(early);
  PutBox("left", 0, "later");
  v1::StreamQueriesRequest query = AtHalf();
  query.mutable_get_distances()->set_world("later");
  EXPECT_NEAR(Nearest_m(Send(query).get_distances()), 0.2, kExact_m);
}

}  // namespace
}  // namespace cwm::server
