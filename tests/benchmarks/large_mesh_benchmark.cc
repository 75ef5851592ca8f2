// The largest mesh that is accepted, as an object and as a link of a robot of the running server.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include "clients/cpp/geometry_transfer.h"
#include "clients/cpp/robot_upload.h"
#include "collision/geometry/triangle_mesh.h"
#include "proto/transfer/mesh_bytes.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/running_server.h"
#include "tests/collision/mesh_files/mesh_bytes.h"

namespace cwm::benchmarks {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kRadius_m = 0.3;
constexpr std::uint32_t kRings = 1'581;  // just below 5 million triangles

double Since_s(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// A closed ball of rings, with as many vertices per ring as there are rings, and one vertex at
// either pole.
TriangleMesh Ball() {
  TriangleMesh ball;
  for (std::uint32_t ring = 1; ring < kRings; ++ring) {
    const double theta = std::numbers::pi * ring / kRings;
    for (std::uint32_t k = 0; k < kRings; ++k) {
      const double phi = 2 * std::numbers::pi * k / kRings;
      ball.vertices.emplace_back(kRadius_m * std::sin(theta) * std::cos(phi),
                                 kRadius_m * std::sin(theta) * std::sin(phi),
                                 kRadius_m * std::cos(theta));
    }
  }
  const auto top = static_cast<std::uint32_t>(ball.vertices.size()), bottom = top + 1;
  ball.vertices.emplace_back(0, 0, kRadius_m);
  ball.vertices.emplace_back(0, 0, -kRadius_m);
  for (std::uint32_t k = 0; k < kRings; ++k) {
    const std::uint32_t next = (k + 1) % kRings, last = (kRings - 2) * kRings;
    ball.triangles.push_back({top, k, next});
    ball.triangles.push_back({bottom, last + next, last + k});
    for (std::uint32_t at = 0; at < last; at += kRings) {
      ball.triangles.push_back({at + k, at + kRings + k, at + kRings + next});
      ball.triangles.push_back({at + k, at + kRings + next, at + next});
    }
  }
  return ball;
}

bool PutObject(const client::Connection& connection, const TriangleMesh& mesh) {
  const auto hash = client::WriteGeometry(connection, {.bytes = EncodeMesh(mesh)});
  if (!hash.ok()) return false;
  v1::ApplyChangesRequest request;
  v1::Object* const object = request.add_changes()->mutable_put()->mutable_object();
  object->set_name("ball");
  object->mutable_x_world_object()->set_qw(1);
  object->add_shapes()->mutable_mesh()->set_hash(*hash);
  return connection.Call(&v1::WorldService::Stub::ApplyChanges, connection.worlds(), request).ok();
}

bool PutRobot(const client::Connection& connection, const TriangleMesh& mesh) {
  v1::LoadRobotHeader header;
  header.set_world("robot");
  header.set_name("ball");
  header.set_urdf(
      "<robot name=\"ball\"><link name=\"base\"><collision><geometry><mesh "
      "filename=\"ball.stl\"/></geometry></collision></link></robot>");
  return client::LoadRobot(connection, header, {{"ball.stl", collision::testing::BinaryStl(mesh)}})
      .ok();
}

// The slower of a distance query and a collision query with a box 1 mm beside the ball, in
// milliseconds.
double QueryTime_ms(const client::Connection& connection, const std::string& world) {
  v1::Subject subject;
  v1::Box* const box = subject.mutable_shapes()->add_shapes()->mutable_box();
  box->set_size_x_m(0.1);
  box->set_size_y_m(0.1);
  box->set_size_z_m(0.1);
  const double pose[7] = {kRadius_m + 0.051, 0, 0, 0, 0, 0, 1};
  subject.mutable_shapes()->mutable_x_world_body()->set_data(pose, sizeof(pose));
  v1::GetDistancesRequest distances;
  v1::CheckCollisionsRequest check;
  distances.set_world(world);
  check.set_world(world);
  *distances.mutable_subject() = *check.mutable_subject() = subject;
  Clock::time_point start = Clock::now();
  const auto near =
      connection.Call(&v1::QueryService::Stub::GetDistances, connection.queries(), distances);
  const double distance_ms = 1e3 * Since_s(start);
  start = Clock::now();
  const auto answer =
      connection.Call(&v1::QueryService::Stub::CheckCollisions, connection.queries(), check);
  return near.ok() && answer.ok() ? std::max(distance_ms, 1e3 * Since_s(start)) : NAN;
}

}  // namespace

void MeasureLargeMesh(Report& report) {
  const RunningServer server;
  if (!server.up()) return report.Fail("no server");
  const client::Connection patient(
      {.address = server.connection().address(), .deadline = std::nullopt});
  const TriangleMesh ball = Ball();
  Clock::time_point start = Clock::now();
  if (!PutObject(patient, ball)) return report.Fail("no object of the largest mesh");
  const double object_s = Since_s(start), object_mib = server.ResidentMebibytes();
  start = Clock::now();
  if (!PutRobot(patient, ball)) return report.Fail("no robot of the largest mesh");
  const double robot_s = Since_s(start);
  const double query_ms =
      std::max(QueryTime_ms(patient, "default"), QueryTime_ms(patient, "robot"));
  char text[200];
  std::snprintf(
      text, sizeof(text),
      "a mesh of %zu triangles: %.1f s until it is an object, %.0f MiB; %.1f s more until "
      "it is a link of a robot, %.0f MiB",
      ball.triangles.size(), object_s, object_mib, robot_s, server.ResidentMebibytes());
  report.Detail(text);
  report.Add({.key = "largest_mesh_object_s",
              .value = object_s,
              .unit = "s",
              .how = "from the first byte of a mesh of 5 million triangles until it is an object"});
  report.Add({.key = "largest_mesh_robot_s",
              .value = robot_s,
              .unit = "s",
              .how = "the same as STL until it is a link of a robot"});
  report.Add({.key = "largest_mesh_asked_ms",
              .value = query_ms,
              .unit = "ms",
              .how = "the slowest of a distance and a verdict of a box 1 mm off either"});
}

}  // namespace cwm::benchmarks
