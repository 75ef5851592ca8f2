// StreamQueries answers are bitwise equal to those of the unary calls.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "collision/geometry/tessellate.h"
#include "server/core/geometry_store.h"
#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

constexpr int kRows = 64;
constexpr v1::Engine kEngines[] = {v1::ENGINE_AUTO, v1::ENGINE_EXACT, v1::ENGINE_FCL,
                                   v1::ENGINE_BULLET};
constexpr v1::ResultForm kForms[] = {v1::RESULT_FORM_COLUMNS, v1::RESULT_FORM_ROWS};

std::string Bytes(const std::vector<double>& values) {
  return std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double));
}

// A world with a shape of each kind, a few metres wide, and a tool of two shapes that is queried
// all over it: near, touching and deep inside.
class StreamQueriesTest : public RunningServer {
 protected:
  StreamQueriesTest() {
    const auto mesh = application_.geometry.Put(BlobFormat::kMeshF64,
                                                EncodeMesh(Tessellate(Cone{0.2, 0.1, 0.4})));
    v1::ApplyChangesRequest request;
    int count = 0;
    const auto put = [&]() -> v1::ShapePart& {
      v1::Object* object = request.add_changes()->mutable_put()->mutable_object();
      object->set_name("object_" + std::to_string(count));
      object->mutable_x_world_object()->set_tx_m(0.5 * (count % 3));
      const int line = count / 3;
      object->mutable_x_world_object()->set_ty_m(0.5 * line);
      object->mutable_x_world_object()->set_qx(0.6);
      object->mutable_x_world_object()->set_qw(0.8);
      ++count;
      return *object->add_shapes();
    };
    put().mutable_sphere()->set_radius_m(0.2);
    v1::Box& box = *put().mutable_box();
    box.set_size_x_m(0.3);
    box.set_size_y_m(0.2);
    box.set_size_z_m(0.1);
    v1::Cylinder& cylinder = *put().mutable_cylinder();
    cylinder.set_radius_m(0.1);
    cylinder.set_length_m(0.4);
    v1::Cone& cone = *put().mutable_cone();
    cone.set_radius_bottom_m(0.2);
    cone.set_length_m(0.3);
    v1::Capsule& capsule = *put().mutable_capsule();
    capsule.set_radius_m(0.1);
    capsule.set_length_m(0.2);
    v1::Plate& plate = *put().mutable_plate();
    plate.set_thickness_m(0.05);
    const std::pair<double, double> corners_m[] = {{0, 0}, {0.3, 0}, {0.3, 0.3}, {0, 0.3}};
    for (const auto& [x_m, y_m] : corners_m) {
      v1::Vector2* vertex = plate.mutable_outline()->add_vertices();
      vertex->set_x(x_m);
      vertex->set_y(y_m);
    }
    put().mutable_convex()->set_hash(mesh->hash);
    put().mutable_mesh()->set_hash(mesh->hash);
    Call call;
    v1::ApplyChangesResponse response;
    const grpc::Status status = world_->ApplyChanges(&call, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
  }

  v1::Subject Tool() {
    v1::Subject subject;
    v1::Subject::Shapes& tool = *subject.mutable_shapes();
    tool.add_shapes()->mutable_capsule()->set_radius_m(0.03);
    tool.mutable_shapes(0)->mutable_capsule()->set_length_m(0.1);
    v1::PlacedShape& palm = *tool.add_shapes();
    palm.mutable_x_body_shape()->set_tz_m(0.1);
    palm.mutable_x_body_shape()->set_qw(1);
    palm.mutable_box()->set_size_x_m(0.1);
    palm.mutable_box()->set_size_y_m(0.04);
    palm.mutable_box()->set_size_z_m(0.04);
    std::vector<double> rows;
    for (int i = 0; i < kRows; ++i) {
      const double half_angle_rad = place_(random_);
      rows.insert(rows.end(), {place_(random_), place_(random_), 0.3 * place_(random_), 0, 0,
                               std::sin(half_angle_rad), std::cos(half_angle_rad)});
    }
    tool.mutable_x_world_body()->set_data(Bytes(rows));
    return subject;
  }
  v1::RayRows Rays() {
    std::vector<double> rows;
    for (int i = 0; i < kRows; ++i) {
      rows.insert(rows.end(), {place_(random_), place_(random_), 2, 0.1 * place_(random_),
                               0.1 * place_(random_), -1});
    }
    v1::RayRows rays;
    rays.set_data(Bytes(rows));
    return rays;
  }
  static v1::QueryOptions Options(v1::Engine engine, v1::ResultForm form) {
    v1::QueryOptions options;
    options.set_engine(engine);
    options.set_result_form(form);
    options.set_margin_m(0.01);
    options.set_max_results(3);
    return options;
  }

  template <class Request, class Response>
  using Method = grpc::Status (v1::QueryService::Stub::*)(grpc::ClientContext*, const Request&,
                                                          Response*);
  // Sends the query both ways.
  template <class Request, class Response>
  void ExpectTheSame(Method<Request, Response> method, const Request& request,
                     Request* (v1::StreamQueriesRequest::*mutable_query)(),
                     const Response& (v1::StreamQueriesResponse::*answer)() const) {
    Response unary;
    Call call;
    const grpc::Status status = ((*query_).*method)(&call, request, &unary);
    v1::StreamQueriesRequest message;
    message.set_id(++id_);
    *(message.*mutable_query)() = request;
    v1::StreamQueriesResponse streamed;
    ASSERT_TRUE(stream_->Write(message) && stream_->Read(&streamed));
    EXPECT_EQ(streamed.id(), id_);
    if (status.ok()) {
      ++answered_;
      EXPECT_FALSE(streamed.has_error()) << streamed.error().message();
      // Bytes of columns, and doubles of rows bit by bit: no tolerance.
      EXPECT_EQ((streamed.*answer)().SerializeAsString(), unary.SerializeAsString());
      return;
    }
    EXPECT_EQ(streamed.error().code(), static_cast<int>(status.error_code()));
    EXPECT_EQ(streamed.error().message(), status.error_message());
    EXPECT_EQ(streamed.error().reason(), ReasonIn(status));
  }

  std::mt19937 random_{7};
  std::uniform_real_distribution<double> place_{-0.2, 1.2};
  Call stream_call_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::StreamQueriesRequest, v1::StreamQueriesResponse>>
      stream_ = query_->StreamQueries(&stream_call_);
  std::int64_t id_ = 0;
  int answered_ = 0;
};

TEST_F(StreamQueriesTest, ChecksAreThoseOfTheUnaryCallForEveryEngine) {
  v1::CheckCollisionsRequest request;
  *request.mutable_subject() = Tool();
  for (const v1::Engine engine : kEngines) {
    for (const v1::ResultForm form : kForms) {
      SCOPED_TRACE(v1::Engine_Name(engine) + " " + v1::ResultForm_Name(form));
      *request.mutable_options() = Options(engine, form);
      ExpectTheSame(&v1::QueryService::Stub::CheckCollisions, request,
                    &v1::StreamQueriesRequest::mutable_check_collisions,
                    &v1::StreamQueriesResponse::check_collisions);
    }
  }
  EXPECT_EQ(answered_, 8);
}

TEST_F(StreamQueriesTest, DistancesAreThoseOfTheUnaryCallForEveryEngine) {
  v1::GetDistancesRequest request;
  *request.mutable_subject() = Tool();
  for (const v1::Engine engine : kEngines) {
    for (const v1::ResultForm form : kForms) {
      SCOPED_TRACE(v1::Engine_Name(engine) + " " + v1::ResultForm_Name(form));
      *request.mutable_options() = Options(engine, form);
      ExpectTheSame(&v1::QueryService::Stub::GetDistances, request,
                    &v1::StreamQueriesRequest::mutable_get_distances,
                    &v1::StreamQueriesResponse::get_distances);
    }
  }
  EXPECT_EQ(answered_, 8);
}

TEST_F(StreamQueriesTest, ContactsAreThoseOfTheUnaryCallForEveryEngine) {
  v1::GetContactsRequest request;
  *request.mutable_subject() = Tool();
  for (const v1::Engine engine : kEngines) {
    for (const v1::ResultForm form : kForms) {
      SCOPED_TRACE(v1::Engine_Name(engine) + " " + v1::ResultForm_Name(form));
      *request.mutable_options() = Options(engine, form);
      ExpectTheSame(&v1::QueryService::Stub::GetContacts, request,
                    &v1::StreamQueriesRequest::mutable_get_contacts,
                    &v1::StreamQueriesResponse::get_contacts);
    }
  }
  EXPECT_EQ(answered_, 8);
}

TEST_F(StreamQueriesTest, RaysAreThoseOfTheUnaryCallAndSoAreTheRefusalsOfEnginesThatCastNone) {
  v1::CastRaysRequest request;
  *request.mutable_rays() = Rays();
  for (const v1::Engine engine : kEngines) {
    for (const v1::ResultForm form : kForms) {
      SCOPED_TRACE(v1::Engine_Name(engine) + " " + v1::ResultForm_Name(form));
      *request.mutable_options() = Options(engine, form);
      ExpectTheSame(&v1::QueryService::Stub::CastRays, request,
                    &v1::StreamQueriesRequest::mutable_cast_rays,
                    &v1::StreamQueriesResponse::cast_rays);
    }
  }
  EXPECT_EQ(answered_, 4) << "AUTO and EXACT, in two forms";
}

TEST_F(StreamQueriesTest, SamplesAreThoseOfTheUnaryCallAndSoAreTheRefusalsOfEnginesThatTakeNone) {
  v1::SamplePointsRequest request;
  std::vector<double> points;
  for (int i = 0; i < 3 * kRows; ++i) points.push_back(place_(random_));
  request.mutable_points()->set_data(Bytes(points));
  for (const v1::Engine engine : kEngines) {
    for (const v1::ResultForm form : kForms) {
      SCOPED_TRACE(v1::Engine_Name(engine) + " " + v1::ResultForm_Name(form));
      *request.mutable_options() = Options(engine, form);
      ExpectTheSame(&v1::QueryService::Stub::SamplePoints, request,
                    &v1::StreamQueriesRequest::mutable_sample_points,
                    &v1::StreamQueriesResponse::sample_points);
    }
  }
  EXPECT_EQ(answered_, 4) << "AUTO and EXACT, in two forms";
}

// Ensures that the comparisons are meaningful: there are hits, misses and penetrations.
TEST_F(StreamQueriesTest, TheQueriesMeetTheWorldInEveryWay) {
  v1::CheckCollisionsRequest check;
  *check.mutable_subject() = Tool();
  *check.mutable_options() = Options(v1::ENGINE_AUTO, v1::RESULT_FORM_COLUMNS);
  v1::CheckCollisionsResponse verdicts;
  Call check_call;
  ASSERT_TRUE(query_->CheckCollisions(&check_call, check, &verdicts).ok());
  EXPECT_THAT(verdicts.verdicts(), ::testing::Contains(static_cast<char>(v1::VERDICT_FREE)));
  EXPECT_THAT(verdicts.verdicts(), ::testing::Contains(static_cast<char>(v1::VERDICT_COLLISION)));
  EXPECT_GE(verdicts.objects_size(), 4);
  v1::CastRaysRequest cast;
  *cast.mutable_rays() = Rays();
  v1::CastRaysResponse hits;
  Call cast_call;
  ASSERT_TRUE(query_->CastRays(&cast_call, cast, &hits).ok());
  EXPECT_THAT(hits.hit(), ::testing::Contains('\1'));
  EXPECT_THAT(hits.hit(), ::testing::Contains('\0'));
}

}  // namespace
}  // namespace cwm::server
