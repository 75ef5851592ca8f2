// A real server on a real Unix socket, with its client stubs.
#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <string>
#include <vector>

#include "collision/geometry/triangle_mesh.h"
#include "cwm/v1/admin.grpc.pb.h"
#include "cwm/v1/error_details.pb.h"
#include "cwm/v1/perception.grpc.pb.h"
#include "cwm/v1/query.grpc.pb.h"
#include "cwm/v1/robot.grpc.pb.h"
#include "cwm/v1/world.grpc.pb.h"
#include "gtest/gtest.h"
#include "server/rpc/server.h"
#include "tests/support/process.h"

namespace cwm::server {

class RunningServer : public ::testing::Test {
 protected:
  RunningServer() : RunningServer(Limits{}, Retention{}) {}
  RunningServer(const Limits& limits, const Retention& retention,
                const TransportLimits& transport = {});

  std::shared_ptr<grpc::Channel> Dial() const;

  // Puts a box with edges of 0.2 m at (x, 0, 0); returns the revision.
  std::int64_t PutBox(const std::string& name, double x_m, const std::string& world = "");
  // Expects that the world still exists and is at this revision.
  void ExpectRevision(std::int64_t revision, const std::string& world = "");

  void LoadRobot(const std::string& name, v1::LoadRobotHeader header);
  // Sends a whole upload of one point at the origin; the caller finishes it.
  std::unique_ptr<grpc::ClientWriter<v1::IngestCloudRequest>> SendOnePoint(
      grpc::ClientContext* call, v1::IngestCloudResponse* response);

  testing::ScratchDirectory scratch_;
  Application application_;
  std::string address_ = "unix:" + (scratch_ / "cwm.sock");
  std::unique_ptr<Server> server_;
  std::unique_ptr<v1::AdminService::Stub> admin_;
  std::unique_ptr<v1::PerceptionService::Stub> perception_;
  std::unique_ptr<v1::QueryService::Stub> query_;
  std::unique_ptr<v1::RobotService::Stub> robot_;
  std::unique_ptr<v1::WorldService::Stub> world_;
};

// A tetrahedron as an OBJ file.
inline constexpr char kTetrahedron[] =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

// A strip of triangles, with about 36 bytes per vertex (35 as text).
TriangleMesh Strip(std::uint32_t vertex_count);

// A client context with a deadline, so that no test hangs.
class Call : public grpc::ClientContext {
 public:
  explicit Call(std::chrono::milliseconds timeout = std::chrono::seconds(60)) {
    set_deadline(std::chrono::system_clock::now() + timeout);
  }
};

// Describes points of three floats, x, y and z, without gaps.
void DescribePoints(std::int64_t point_count, v1::IngestCloudHeader* header);

// The next message that is not a bookmark; empty after the last one.
v1::WatchWorldResponse NextMessage(grpc::ClientReader<v1::WatchWorldResponse>* watch);

v1::Change PutBoxChange(const std::string& name, double x_m);

// The standard details of an error.
struct Details {
  v1::ErrorInfo info;
  v1::BadRequest bad_request;
  bool has_retry = false;
};
Details DetailsIn(const grpc::Status& status);
std::string ReasonIn(const grpc::Status& status);
// The field at fault; empty unless there is exactly one.
std::string FieldIn(const grpc::Status& status);

// A sphere of radius 0.1 m at each x on the x axis.
v1::Subject SphereAt(const std::vector<double>& x_m);

}  // namespace cwm::server
