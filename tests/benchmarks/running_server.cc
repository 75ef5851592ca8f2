#include "tests/benchmarks/running_server.h"

#include <chrono>
#include <filesystem>
#include <string>
#include <variant>

#include "tests/benchmarks/benchmark_world.h"

namespace cwm::benchmarks {
namespace {

std::string ServerProgram() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / "cwm-server";
}

bool PutBenchmarkWorld(const client::Connection& connection) {
  v1::ApplyChangesRequest request;
  for (const Placed<>& placed : BenchmarkShapes()) {
    v1::Object* object = request.add_changes()->mutable_put()->mutable_object();
    object->set_name("object_" + std::to_string(request.changes_size() - 1));
    SetPose(placed.X_FS, object->mutable_x_world_object());
    if (!SetShape(placed.shape, object->add_shapes())) return false;
  }
  grpc::ClientContext context;
  v1::ApplyChangesResponse response;
  return connection.worlds().ApplyChanges(&context, request, &response).ok();
}

}  // namespace

void SetPose(const Pose& X, v1::Pose* out) {
  const Quaternion q(X.linear());
  out->set_tx_m(X.translation().x());
  out->set_ty_m(X.translation().y());
  out->set_tz_m(X.translation().z());
  out->set_qx(q.x());
  out->set_qy(q.y());
  out->set_qz(q.z());
  out->set_qw(q.w());
}

bool SetShape(const Shape& shape, v1::ShapePart* part) {
  if (const auto* box = std::get_if<Box>(&shape)) {
    part->mutable_box()->set_size_x_m(box->size_m.x());
    part->mutable_box()->set_size_y_m(box->size_m.y());
    part->mutable_box()->set_size_z_m(box->size_m.z());
  } else if (const auto* cylinder = std::get_if<Cylinder>(&shape)) {
    part->mutable_cylinder()->set_radius_m(cylinder->radius_m);
    part->mutable_cylinder()->set_length_m(cylinder->length_m);
  } else if (const auto* sphere = std::get_if<Sphere>(&shape)) {
    part->mutable_sphere()->set_radius_m(sphere->radius_m);
  } else if (const auto* capsule = std::get_if<Capsule>(&shape)) {
    part->mutable_capsule()->set_radius_m(capsule->radius_m);
    part->mutable_capsule()->set_length_m(capsule->length_m);
  } else {
    return false;
  }
  return true;
}

RunningServer::RunningServer()
    : process_({ServerProgram(), "--listen", "unix:" + scratch_ / "cwm.sock", "--viewer", "off"},
               scratch_ / "server.log"),
      connection_({.address = "unix:" + scratch_ / "cwm.sock", .deadline = std::nullopt}) {
  const auto deadline = std::chrono::system_clock::now() + std::chrono::seconds(10);
  up_ = connection_.channel()->WaitForConnected(deadline) && PutBenchmarkWorld(connection_);
}

}  // namespace cwm::benchmarks
