#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "server/core/geometry_store.h"
#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

using ::testing::HasSubstr;

constexpr double kExact_m = 1e-7;  // the accuracy of answers labelled EXACT

std::vector<double> Doubles(const std::string& bytes) {
  std::vector<double> values(bytes.size() / sizeof(double));
  std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

// Boxes with edges of 0.2 m at x = 0 and x = 2; the query's body is a sphere of radius 0.1 m.
class QueryTest : public RunningServer {
 protected:
  QueryTest() {
    PutBox("left", 0);
    PutBox("right", 2);
  }
  grpc::Status Distances(const v1::GetDistancesRequest& request,
                         v1::GetDistancesResponse* response) {
    Call call;
    return query_->GetDistances(&call, request, response);
  }
};

TEST_F(QueryTest, DistancesHaveTheClosedFormForEveryEngine) {
  for (const v1::Engine engine :
       {v1::ENGINE_AUTO, v1::ENGINE_EXACT, v1::ENGINE_FCL, v1::ENGINE_BULLET}) {
    v1::GetDistancesRequest request;
    *request.mutable_subject() = SphereAt({0.5, 1.4});
    request.mutable_options()->set_engine(engine);
    v1::GetDistancesResponse response;
    const auto status = Distances(request, &response);
    ASSERT_TRUE(status.ok()) << status.error_message();
    EXPECT_EQ(response.completed_count(), 2);
    EXPECT_EQ(response.revision(), 2);
    const auto distances = Doubles(response.columns().distance_m());
    ASSERT_EQ(distances.size(), 2u);
    // Bullet's answers are BOUNDED by about 1e-4 m; the others are exact.
    const double tolerance = engine == v1::ENGINE_BULLET ? 1e-3 : kExact_m;
    EXPECT_NEAR(distances[0], 0.5 - 0.1 - 0.1, tolerance) << v1::Engine_Name(engine);
    EXPECT_NEAR(distances[1], 2 - 1.4 - 0.1 - 0.1, tolerance) << v1::Engine_Name(engine);
    const auto normals = Doubles(response.columns().normal());
    EXPECT_NEAR(normals[0], -1, tolerance);  // from the sphere to the box on its left
    EXPECT_NEAR(normals[3], 1, tolerance);
    EXPECT_EQ(response.objects(0).name(), "left");
    EXPECT_EQ(response.objects(1).name(), "right");
  }
}

TEST_F(QueryTest, RowsSayTheSame) {
  v1::GetDistancesRequest request;
  *request.mutable_subject() = SphereAt({0.5});
  request.mutable_options()->set_result_form(v1::RESULT_FORM_ROWS);
  request.mutable_options()->set_max_results(2);
  v1::GetDistancesResponse response;
  ASSERT_TRUE(Distances(request, &response).ok());
  ASSERT_EQ(response.rows_size(), 1);
  ASSERT_EQ(response.rows(0).answers_size(), 2);
  EXPECT_EQ(response.rows(0).answers(0).object(), "left");
  EXPECT_NEAR(response.rows(0).answers(1).distance_m(), 1.3, kExact_m);
}

TEST_F(QueryTest, CollisionIsDistanceBelowTheMargin) {
  v1::CheckCollisionsRequest request;
  *request.mutable_subject() = SphereAt({0, 0.25, 0.5});
  request.mutable_options()->set_margin_m(0.06);
  v1::CheckCollisionsResponse response;
  Call call;
  ASSERT_TRUE(query_->CheckCollisions(&call, request, &response).ok());
  EXPECT_EQ(response.verdicts(), std::string("\x02\x02\x01"));
  EXPECT_EQ(response.trust(), std::string(3, static_cast<char>(v1::TRUST_EXACT)));
}

TEST_F(QueryTest, AnOverlayIsSeenByItsQueryAlone) {
  v1::GetDistancesRequest request;
  *request.mutable_subject() = SphereAt({0.5});
  request.mutable_options()->set_max_results(5);
  *request.mutable_options()->add_overlay() = PutBoxChange("near", 1);
  v1::Change* move = request.mutable_options()->add_overlay();
  move->mutable_move()->set_name("right");
  move->mutable_move()->mutable_x_world_object()->set_tx_m(5);
  move->mutable_move()->mutable_x_world_object()->set_qw(1);
  request.mutable_options()->add_overlay()->mutable_remove()->set_name("left");
  v1::GetDistancesResponse response;
  const auto status = Distances(request, &response);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(response.revision(), 2);
  ASSERT_EQ(response.objects_size(), 2);
  EXPECT_EQ(response.objects(0).name(), "near");
  EXPECT_EQ(response.objects(0).uid(), "");
  EXPECT_EQ(response.objects(1).name(), "right");
  EXPECT_NE(response.objects(1).uid(), "");
  const auto distances = Doubles(response.columns().distance_m());
  ASSERT_EQ(distances.size(), 2u);
  EXPECT_NEAR(distances[0], 0.5 - 0.1 - 0.1, kExact_m);
  EXPECT_NEAR(distances[1], 4.5 - 0.1 - 0.1, kExact_m);

  request.mutable_options()->clear_overlay();
  v1::GetDistancesResponse after;
  ASSERT_TRUE(Distances(request, &after).ok());
  EXPECT_EQ(after.revision(), 2);
  EXPECT_EQ(after.objects(0).name(), "left");
  EXPECT_NEAR(Doubles(after.columns().distance_m())[1], 1.5 - 0.1 - 0.1, kExact_m);
}

TEST_F(QueryTest, AnObjectOfTheOverlayCanAsk) {
  v1::CheckCollisionsRequest request;
  request.mutable_subject()->mutable_object()->set_name("probe");
  *request.mutable_options()->add_overlay() = PutBoxChange("probe", 0.15);
  v1::CheckCollisionsResponse response;
  Call call;
  const auto status = query_->CheckCollisions(&call, request, &response);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(response.verdicts(), std::string("\x02"));
}

TEST_F(QueryTest, AnOverlayThatCannotBeAppliedFailsTheQueryAndIsNamed) {
  v1::GetDistancesRequest request;
  *request.mutable_subject() = SphereAt({0.5});
  v1::GetDistancesResponse response;
  request.mutable_options()->add_overlay()->mutable_remove()->set_name("nobody");
  auto status = Distances(request, &response);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(ReasonIn(status), "OBJECT_UNKNOWN");
  EXPECT_EQ(status.error_message(), "options.overlay[0]: object 'nobody' does not exist");
  request.mutable_options()->mutable_overlay(0)->mutable_remove()->set_name("no such/ name!");
  status = Distances(request, &response);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(FieldIn(status), "options.overlay[0].remove.name");
  request.mutable_options()->mutable_overlay(0)->clear_what();
  EXPECT_EQ(FieldIn(Distances(request, &response)), "options.overlay[0].what");
  *request.mutable_options()->mutable_overlay(0) = PutBoxChange("left", 1);
  request.mutable_options()->mutable_overlay(0)->set_expected_object_revision(77);
  status = Distances(request, &response);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::ABORTED);
  EXPECT_EQ(ReasonIn(status), "OBJECT_REVISION_MISMATCH");
}

TEST_F(QueryTest, ContactsAreDeepestFirst) {
  v1::GetContactsRequest request;
  *request.mutable_subject() = SphereAt({0.15});
  request.mutable_options()->set_result_form(v1::RESULT_FORM_ROWS);
  v1::GetContactsResponse response;
  Call call;
  ASSERT_TRUE(query_->GetContacts(&call, request, &response).ok());
  ASSERT_EQ(response.rows(0).answers_size(), 1);
  EXPECT_NEAR(response.rows(0).answers(0).distance_m(), -0.05, kExact_m);
}

TEST_F(QueryTest, RaysHitTheNearestFace) {
  v1::CastRaysRequest request;
  const double rays[12] = {1, 0, 0, -3, 0, 0, 1, 0, 5, 0, 1, 0};
  request.mutable_rays()->set_data(rays, sizeof(rays));
  request.mutable_options()->set_result_form(v1::RESULT_FORM_ROWS);
  v1::CastRaysResponse response;
  Call call;
  ASSERT_TRUE(query_->CastRays(&call, request, &response).ok());
  ASSERT_EQ(response.rows_size(), 2);
  EXPECT_EQ(response.rows(0).object(), "left");
  EXPECT_NEAR(response.rows(0).distance_m(), 0.9, kExact_m);
  EXPECT_NEAR(response.rows(0).normal().x(), 1, kExact_m);
  EXPECT_FALSE(response.rows(1).hit());
  EXPECT_EQ(response.rows(0).trust(), v1::TRUST_EXACT);
}

TEST_F(QueryTest, ARayThatHitsAnOpenSurfaceSaysSo) {
  TriangleMesh sheet;
  sheet.vertices = {{-1, -1, 5}, {1, -1, 5}, {0, 1, 5}};
  sheet.triangles = {{0, 1, 2}};
  const std::string bytes = EncodeMesh(sheet);
  const auto stored = application_.geometry.Put(BlobFormat::kMeshF64, bytes);
  ASSERT_TRUE(stored.ok());
  v1::ApplyChangesRequest put;
  v1::Object* object = put.add_changes()->mutable_put()->mutable_object();
  object->set_name("sheet");
  object->add_shapes()->mutable_mesh()->set_hash(stored->hash);
  v1::ApplyChangesResponse applied;
  Call put_call;
  ASSERT_TRUE(world_->ApplyChanges(&put_call, put, &applied).ok());
  v1::CastRaysRequest request;
  const double rays[12] = {0, 0, 3, 0, 0, 1, 0, 0, 3, 0, 0, -1};
  request.mutable_rays()->set_data(rays, sizeof(rays));
  v1::CastRaysResponse response;
  Call call;
  ASSERT_TRUE(query_->CastRays(&call, request, &response).ok());
  EXPECT_EQ(response.hit(), std::string("\x01\x01"));
  EXPECT_EQ(response.trust(), std::string({static_cast<char>(v1::TRUST_SURFACE_ONLY),
                                           static_cast<char>(v1::TRUST_EXACT)}));
}

TEST_F(QueryTest, PointsAreSampledAndThoseBesideNothingHaveNoDistance) {
  v1::SamplePointsRequest request;
  const double points[9] = {0.9, 0, 0, 50, 0, 0, 0, 0, 0};
  request.mutable_points()->set_data(points, sizeof(points));
  request.mutable_options()->set_max_distance_m(5);
  v1::SamplePointsResponse columns;
  Call columns_call;
  ASSERT_TRUE(query_->SamplePoints(&columns_call, request, &columns).ok());
  EXPECT_EQ(columns.completed_count(), 3);
  EXPECT_EQ(columns.state(), std::string({static_cast<char>(v1::SAMPLE_STATE_SMOOTH),
                                          static_cast<char>(v1::SAMPLE_STATE_BEYOND),
                                          static_cast<char>(v1::SAMPLE_STATE_KINK)}));
  EXPECT_EQ(columns.distance_m().size(), 3 * sizeof(double));
  EXPECT_EQ(columns.gradient().size(), 9 * sizeof(double));
  EXPECT_EQ(columns.bound_m(), "");
  request.mutable_options()->set_result_form(v1::RESULT_FORM_ROWS);
  v1::SamplePointsResponse rows;
  Call rows_call;
  ASSERT_TRUE(query_->SamplePoints(&rows_call, request, &rows).ok());
  ASSERT_EQ(rows.rows_size(), 3);
  EXPECT_EQ(rows.rows(0).object(), "left");
  EXPECT_NEAR(rows.rows(0).distance_m(), 0.8, kExact_m);
  EXPECT_NEAR(rows.rows(0).gradient().x(), 1, kExact_m);
  EXPECT_EQ(rows.rows(0).trust(), v1::TRUST_EXACT);
  EXPECT_EQ(rows.rows(1).state(), v1::SAMPLE_STATE_BEYOND);
  EXPECT_FALSE(rows.rows(1).has_distance_m() || rows.rows(1).has_gradient() ||
               rows.rows(1).has_object() || rows.rows(1).has_object_part());
  EXPECT_LT(rows.rows(2).distance_m(), 0);
}

TEST_F(QueryTest, ABadPointRefusesTheBatchAndNamesItsRow) {
  const double no_number = std::numeric_limits<double>::quiet_NaN();
  const double points[6] = {0, 0, 0, 1, no_number, 0};
  v1::SamplePointsRequest request;
  request.mutable_points()->set_data(points, sizeof(points));
  v1::SamplePointsResponse ignored;
  {
    Call call;
    const auto status = query_->SamplePoints(&call, request, &ignored);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
    EXPECT_EQ(FieldIn(status), "points.data row 1");
    EXPECT_THAT(status.error_message(), HasSubstr("y is nan"));
  }
  request.mutable_points()->set_data(points, sizeof(points) - 1);
  Call call;
  const auto status = query_->SamplePoints(&call, request, &ignored);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(FieldIn(status), "points.data");
  EXPECT_THAT(status.error_message(), HasSubstr("has 47 bytes, must be a multiple of 24"));
}

TEST_F(QueryTest, ABatchThatCouldFillTheMemoryIsRefusedByItsOption) {
  v1::GetContactsRequest contacts;
  *contacts.mutable_subject() = SphereAt(std::vector<double>(4'096, 0.5));
  contacts.mutable_options()->set_max_contacts(1'024);
  v1::GetContactsResponse ignored;
  {
    Call call;
    const auto status = query_->GetContacts(&call, contacts, &ignored);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
    EXPECT_EQ(FieldIn(status), "options.max_contacts");
    EXPECT_THAT(status.error_message(), HasSubstr("is 1024 for 4096 rows, must be at most 256"));
  }
  contacts.mutable_options()->set_max_contacts(256);
  Call call;
  EXPECT_TRUE(query_->GetContacts(&call, contacts, &ignored).ok());
  // With two objects no row has more than two answers, whatever limit it gives.
  v1::GetDistancesRequest distances;
  *distances.mutable_subject() = SphereAt(std::vector<double>(65'536, 0.5));
  distances.mutable_options()->set_max_results(64);
  v1::GetDistancesResponse answers;
  EXPECT_TRUE(Distances(distances, &answers).ok());
}

TEST_F(QueryTest, AWorldObjectIsNoObstacleToItself) {
  v1::GetDistancesRequest request;
  request.mutable_subject()->mutable_object()->set_name("left");
  v1::GetDistancesResponse response;
  ASSERT_TRUE(Distances(request, &response).ok());
  EXPECT_EQ(response.objects(0).name(), "right");
  EXPECT_NEAR(Doubles(response.columns().distance_m())[0], 1.8, kExact_m);
}

TEST_F(QueryTest, PointsAreAskedToo) {
  v1::GetDistancesRequest request;
  const double points[3] = {0.4, 0, 0};
  request.mutable_subject()->mutable_points()->set_data(points, sizeof(points));
  v1::GetDistancesResponse response;
  ASSERT_TRUE(Distances(request, &response).ok());
  EXPECT_NEAR(Doubles(response.columns().distance_m())[0], 0.3, kExact_m);
}

TEST_F(QueryTest, OneBadPoseAmongThousandsRefusesTheBatchAndIsNamed) {
  v1::GetDistancesRequest request;
  *request.mutable_subject() = SphereAt(std::vector<double>(4'096, 0.5));
  std::string* data =
      request.mutable_subject()->mutable_shapes()->mutable_x_world_body()->mutable_data();
  const double bad_w = 0.9;
  std::memcpy(data->data() + (1'234 * 7 + 6) * sizeof(double), &bad_w, sizeof(bad_w));
  v1::GetDistancesResponse response;
  const auto status = Distances(request, &response);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(status.error_message(),
            "subject.shapes.x_world_body.data row 1234: qx..qw has length 0.9, must be 1 within "
            "1e-3");
  *request.mutable_subject() = SphereAt({0.5});
  EXPECT_TRUE(Distances(request, &response).ok()) << "the next good request works";
}

TEST_F(QueryTest, UnknownWorldObjectEngineAndRevisionAreTold) {
  v1::GetDistancesRequest good;
  *good.mutable_subject() = SphereAt({0.5});
  v1::GetDistancesResponse response;
  auto request = good;
  request.set_world("elsewhere");
  EXPECT_EQ(ReasonIn(Distances(request, &response)), "WORLD_UNKNOWN");
  request = good;
  request.mutable_subject()->mutable_object()->set_name("ghost");
  EXPECT_EQ(ReasonIn(Distances(request, &response)), "OBJECT_UNKNOWN");
  request = good;
  request.mutable_options()->set_engine(static_cast<v1::Engine>(42));
  EXPECT_EQ(FieldIn(Distances(request, &response)), "options.engine");
  request = good;
  request.mutable_options()->mutable_at_revision()->set_exact(77);
  EXPECT_EQ(ReasonIn(Distances(request, &response)), "REVISION_IN_FUTURE");
  request = good;
  request.mutable_options()->set_world_uid("another");
  EXPECT_EQ(ReasonIn(Distances(request, &response)), "WORLD_REPLACED");
  request = good;
  request.clear_subject();
  EXPECT_EQ(FieldIn(Distances(request, &response)), "subject.what");
}

TEST_F(QueryTest, ABatchOverTheLimitIsRefused) {
  v1::GetDistancesRequest request;
  *request.mutable_subject() = SphereAt(std::vector<double>(65'537, 0.5));
  v1::GetDistancesResponse response;
  EXPECT_THAT(Distances(request, &response).error_message(),
              HasSubstr("has 65537 rows, must have at most 65536"));
}

TEST_F(QueryTest, ATimeBudgetGivesThePrefixOfTheFullAnswer) {
  for (int i = 0; i < 200; ++i) PutBox("extra_" + std::to_string(i), 3 + i);
  v1::GetDistancesRequest request;
  *request.mutable_subject() = SphereAt(std::vector<double>(65'536, 100.5));
  request.mutable_options()->set_max_results(16);
  request.mutable_options()->mutable_time_budget()->set_nanos(2'000'000);
  v1::GetDistancesResponse part;
  ASSERT_TRUE(Distances(request, &part).ok());
  EXPECT_LT(part.completed_count(), 65'536);
  *request.mutable_subject() = SphereAt(std::vector<double>(part.completed_count(), 100.5));
  request.mutable_options()->clear_time_budget();
  v1::GetDistancesResponse full;
  ASSERT_TRUE(Distances(request, &full).ok());
  EXPECT_EQ(full.columns().distance_m(), part.columns().distance_m());
}

TEST_F(QueryTest, AStreamAnswersInOrderAndSurvivesABadBatch) {
  Call call;
  const auto stream = query_->StreamQueries(&call);
  for (int i = 0; i < 20; ++i) {
    v1::StreamQueriesRequest request;
    request.set_id(i);
    if (i == 7) {
      request.mutable_get_distances()->set_world("elsewhere");
    } else if (i == 9) {
      // No query at all.
    } else if (i % 2 == 0) {
      *request.mutable_get_distances()->mutable_subject() = SphereAt({0.5 + 0.01 * i});
    } else {
      *request.mutable_check_collisions()->mutable_subject() = SphereAt({0.0});
    }
    ASSERT_TRUE(stream->Write(request));
  }
  stream->WritesDone();
  v1::StreamQueriesResponse response;
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(stream->Read(&response));
    EXPECT_EQ(response.id(), i);
    if (i == 7) {
      EXPECT_EQ(response.error().reason(), "WORLD_UNKNOWN");
      EXPECT_EQ(response.error().code(), static_cast<int>(grpc::StatusCode::NOT_FOUND));
    } else if (i == 9) {
      EXPECT_EQ(response.error().fields(0).field(), "query");
    } else if (i % 2 == 0) {
      EXPECT_NEAR(Doubles(response.get_distances().columns().distance_m())[0], 0.3 + 0.01 * i,
                  kExact_m);
    } else {
      EXPECT_EQ(response.check_collisions().verdicts(), "\x02");
    }
  }
  EXPECT_FALSE(stream->Read(&response));
  EXPECT_TRUE(stream->Finish().ok());
}

class FewSnapshotsTest : public RunningServer {
 protected:
  static Retention TwoSnapshots() {
    Retention retention;
    retention.exact_snapshots = 2;
    retention.recent_snapshots = 0;
    retention.leased_snapshots = 0;
    retention.recent_time = std::chrono::hours(1);  // so that none is thinned
    return retention;
  }
  FewSnapshotsTest() : RunningServer({}, TwoSnapshots()) {}
};

TEST_F(FewSnapshotsTest, AStreamKeepsItsSnapshotAskable) {
  PutBox("left", 0);
  Call call;
  const auto stream = query_->StreamQueries(&call);
  v1::StreamQueriesRequest request;
  *request.mutable_get_distances()->mutable_subject() = SphereAt({0.5});
  v1::StreamQueriesResponse response;
  ASSERT_TRUE(stream->Write(request) && stream->Read(&response));
  for (int i = 1; i < 8; ++i) PutBox("left", -i);
  request.mutable_get_distances()->mutable_options()->mutable_at_revision()->set_exact(1);
  ASSERT_TRUE(stream->Write(request) && stream->Read(&response));
  EXPECT_EQ(response.get_distances().revision(), 1) << response.error().message();
  Call unary;
  v1::GetDistancesResponse compacted;
  EXPECT_EQ(ReasonIn(query_->GetDistances(&unary, request.get_distances(), &compacted)),
            "REVISION_COMPACTED");
}

}  // namespace
}  // namespace cwm::server
