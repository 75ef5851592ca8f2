#include "tests/server/rpc/running_server.h"

#include <utility>

#include "perception/interpret_scene.h"
#include "proto/transfer/crc32c.h"

namespace cwm::server {

RunningServer::RunningServer(const Limits& limits, const Retention& retention,
                             const TransportLimits& transport)
    : application_{.limits = limits,
                   .retention = retention,
                   .interpret = perception::InterpretScene,
                   .transport = transport} {
  auto server = Server::Start(application_, {.addresses = {address_}});
  if (!server.ok()) throw std::runtime_error(std::string(server.status().message()));
  server_ = *std::move(server);
  const auto channel = Dial();
  admin_ = v1::AdminService::NewStub(channel);
  perception_ = v1::PerceptionService::NewStub(channel);
  query_ = v1::QueryService::NewStub(channel);
  robot_ = v1::RobotService::NewStub(channel);
  world_ = v1::WorldService::NewStub(channel);
}

std::shared_ptr<grpc::Channel> RunningServer::Dial() const {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);
  arguments.SetMaxSendMessageSize(-1);
  return grpc::CreateCustomChannel(address_, grpc::InsecureChannelCredentials(), arguments);
}

v1::Change PutBoxChange(const std::string& name, double x_m) {
  v1::Change change;
  v1::Object* object = change.mutable_put()->mutable_object();
  object->set_name(name);
  object->mutable_x_world_object()->set_tx_m(x_m);
  object->mutable_x_world_object()->set_qw(1);
  v1::Box* box = object->add_shapes()->mutable_box();
  box->set_size_x_m(0.2);
  box->set_size_y_m(0.2);
  box->set_size_z_m(0.2);
  return change;
}

std::int64_t RunningServer::PutBox(const std::string& name, double x_m, const std::string& world) {
  Call call;
  v1::ApplyChangesRequest request;
  request.set_world(world);
  *request.add_changes() = PutBoxChange(name, x_m);
  v1::ApplyChangesResponse response;
  const grpc::Status status = world_->ApplyChanges(&call, request, &response);
  EXPECT_TRUE(status.ok()) << status.error_message();
  return response.revision();
}

void RunningServer::ExpectRevision(std::int64_t revision, const std::string& world) {
  Call call;
  v1::GetWorldRequest request;
  request.set_world(world);
  v1::GetWorldResponse response;
  const grpc::Status status = world_->GetWorld(&call, request, &response);
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(response.revision(), revision);
}

void RunningServer::LoadRobot(const std::string& name, v1::LoadRobotHeader header) {
  Call call;
  v1::LoadRobotResponse response;
  const auto writer = robot_->LoadRobot(&call, &response);
  header.set_name(name);
  v1::LoadRobotRequest request;
  *request.mutable_header() = std::move(header);
  writer->Write(request);
  request.mutable_finish();
  writer->Write(request);
  writer->WritesDone();
  const grpc::Status status = writer->Finish();
  EXPECT_TRUE(status.ok()) << status.error_message();
}

std::unique_ptr<grpc::ClientWriter<v1::IngestCloudRequest>> RunningServer::SendOnePoint(
    grpc::ClientContext* call, v1::IngestCloudResponse* response) {
  v1::IngestCloudRequest header;
  DescribePoints(1, header.mutable_header());
  v1::IngestCloudRequest chunk;
  chunk.mutable_chunk()->set_data(std::string(12, '\0'));
  chunk.mutable_chunk()->set_crc32c(Crc32c(chunk.chunk().data()));
  v1::IngestCloudRequest end;
  end.mutable_finish();
  auto writer = perception_->IngestCloud(call, response);
  EXPECT_TRUE(writer->Write(header) && writer->Write(chunk) && writer->Write(end));
  writer->WritesDone();
  return writer;
}

void DescribePoints(std::int64_t point_count, v1::IngestCloudHeader* header) {
  for (int axis = 0; axis < 3; ++axis) {
    v1::CloudField* field = header->mutable_layout()->add_fields();
    field->set_name(std::string(1, static_cast<char>('x' + axis)));
    field->set_offset(4 * axis);
    field->set_type(v1::FIELD_TYPE_F32);
  }
  header->mutable_layout()->set_point_step(12);
  header->set_point_count(point_count);
  header->set_total_bytes(12 * point_count);
}

v1::WatchWorldResponse NextMessage(grpc::ClientReader<v1::WatchWorldResponse>* watch) {
  v1::WatchWorldResponse message;
  do {
    if (!watch->Read(&message)) return {};
  } while (message.has_bookmark());
  return message;
}

Details DetailsIn(const grpc::Status& status) {
  v1::Status packed;
  EXPECT_TRUE(packed.ParseFromString(status.error_details()));
  Details details;
  for (const google::protobuf::Any& any : packed.details()) {
    if (any.type_url() == "type.googleapis.com/google.rpc.ErrorInfo") {
      EXPECT_TRUE(details.info.ParseFromString(any.value()));
    } else if (any.type_url() == "type.googleapis.com/google.rpc.BadRequest") {
      EXPECT_TRUE(details.bad_request.ParseFromString(any.value()));
    } else if (any.type_url() == "type.googleapis.com/google.rpc.RetryInfo") {
      details.has_retry = true;
    } else {
      ADD_FAILURE() << "unknown detail " << any.type_url();
    }
  }
  return details;
}

std::string ReasonIn(const grpc::Status& status) { return DetailsIn(status).info.reason(); }

std::string FieldIn(const grpc::Status& status) {
  const v1::BadRequest bad_request = DetailsIn(status).bad_request;
  return bad_request.field_violations_size() == 1 ? bad_request.field_violations(0).field() : "";
}

v1::Subject SphereAt(const std::vector<double>& x_m) {
  v1::Subject subject;
  subject.mutable_shapes()->add_shapes()->mutable_sphere()->set_radius_m(0.1);
  std::string* data = subject.mutable_shapes()->mutable_x_world_body()->mutable_data();
  for (const double x : x_m) {
    const double row[7] = {x, 0, 0, 0, 0, 0, 1};
    data->append(reinterpret_cast<const char*>(row), sizeof(row));
  }
  return subject;
}

TriangleMesh Strip(std::uint32_t vertex_count) {
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < vertex_count; ++i) {
    const std::uint32_t rung = i / 2;
    mesh.vertices.emplace_back(0.001 * rung, i % 2, 0);
    if (i >= 2) mesh.triangles.push_back({i - 2, i - 1, i});
  }
  return mesh;
}

}  // namespace cwm::server
