#include "tests/benchmarks/panda_server.h"

#include <cstring>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "clients/cpp/robot_upload.h"
#include "clients/formats/robot_files.h"
#include "tests/benchmarks/running_server.h"
#include "tests/collision/robot/panda_files.h"

namespace cwm::benchmarks {
namespace {

absl::Status LoadPanda(const client::Connection& connection, const std::string& world) {
  const auto files = collision::testing::ReadPandaFiles();
  if (!files) return absl::NotFoundError("motion_bench_maker is not in CWM_DATA");
  v1::LoadRobotHeader header;
  header.set_world(world);
  header.set_name("panda");
  header.set_urdf(files->urdf);
  header.set_srdf(files->srdf);
  header.set_spheres(files->spherized_urdf);
  std::vector<client::RobotFile> meshes;
  for (const std::string& uri : formats::CollisionMeshUris(files->urdf)) {
    auto bytes = files->meshes(uri);
    if (!bytes.ok()) return bytes.status();
    meshes.push_back({uri, *std::move(bytes)});
  }
  return client::LoadRobot(connection, header, meshes).status();
}

absl::Status AddObjects(const PandaProblem& problem, v1::ApplyChangesRequest* request) {
  for (const collision::WorldObjectPtr& object : problem.world->objects()) {
    v1::Object* put = request->add_changes()->mutable_put()->mutable_object();
    put->set_name(object->name);
    SetPose(object->X_WO, put->mutable_x_world_object());
    for (const auto& part : object->model().shapes) {
      v1::ShapePart* shape = put->add_shapes();
      SetPose(part.X_OS, shape->mutable_x_object_shape());
      if (!SetShape(part.shape, shape)) {
        return absl::UnimplementedError(absl::StrCat(object->name, " has a shape of another kind"));
      }
    }
  }
  return absl::OkStatus();
}

absl::Status Apply(const client::Connection& connection, const v1::ApplyChangesRequest& request) {
  return connection.Call(&v1::WorldService::Stub::ApplyChanges, connection.worlds(), request)
      .status();
}

}  // namespace

absl::Status PutPandaProblem(const client::Connection& connection, const PandaProblem& problem,
                             const std::string& world) {
  if (auto status = LoadPanda(connection, world); !status.ok()) return status;
  v1::ApplyChangesRequest request;
  request.set_world(world);
  if (auto status = AddObjects(problem, &request); !status.ok()) return status;
  return Apply(connection, request);
}

absl::Status ReplacePandaProblem(const client::Connection& connection, const PandaProblem& before,
                                 const PandaProblem& problem, const std::string& world) {
  v1::ApplyChangesRequest request;
  request.set_world(world);
  for (const collision::WorldObjectPtr& object : before.world->objects()) {
    request.add_changes()->mutable_remove()->set_name(object->name);
  }
  if (auto status = AddObjects(problem, &request); !status.ok()) return status;
  return Apply(connection, request);
}

v1::CheckCollisionsRequest PandaIn(const std::string& world, const std::vector<double>& states,
                                   v1::RobotGeometry geometry) {
  v1::CheckCollisionsRequest request;
  request.set_world(world);
  request.mutable_options()->set_verdicts_only(true);
  v1::RobotSubject* robot = request.mutable_subject()->mutable_robot();
  robot->set_robot("panda");
  robot->set_group("panda_arm");
  robot->set_robot_geometry(geometry);
  std::string* data = robot->mutable_rows()->mutable_data();
  data->resize(states.size() * sizeof(double));
  std::memcpy(data->data(), states.data(), data->size());
  return request;
}

}  // namespace cwm::benchmarks
