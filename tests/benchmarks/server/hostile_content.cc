#include "tests/benchmarks/server/hostile_content.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <random>

#include "absl/strings/str_cat.h"
#include "clients/cpp/geometry_transfer.h"
#include "clients/cpp/robot_upload.h"
#include "clients/cpp/row_bytes.h"
#include "proto/transfer/crc32c.h"
#include "proto/transfer/mesh_bytes.h"

namespace cwm::benchmarks {
namespace {

constexpr std::size_t kChunkBytes = 1 << 20;

std::string Encoded(const TriangleMesh& mesh) {
  std::string bytes;
  ForEachMeshPiece(mesh, [&bytes](const void* data, std::size_t size) {
    bytes.append(static_cast<const char*>(data), size);
  });
  return bytes;
}

}  // namespace

TriangleMesh Torus(int around, int across, int variant) {
  TriangleMesh mesh;
  const double ring_m = 0.35 + 1e-4 * variant, tube_m = 0.15;
  for (int i = 0; i < around; ++i) {
    const double u = 2 * std::numbers::pi * i / around;
    for (int j = 0; j < across; ++j) {
      const double v = 2 * std::numbers::pi * j / across;
      const double radius_m = ring_m + tube_m * std::cos(v);
      mesh.vertices.emplace_back(radius_m * std::cos(u), radius_m * std::sin(u),
                                 tube_m * std::sin(v));
    }
  }
  const auto at = [&](int i, int j) {
    return static_cast<std::uint32_t>((i % around) * across + j % across);
  };
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

bool StoreTori(Target& target, int copies, int around, int across) {
  for (int copy = 0; copy < copies; ++copy) {
    const std::string bytes = Encoded(Torus(around, across, copy));
    target.mesh_bytes = static_cast<std::int64_t>(bytes.size());
    const auto hash = client::WriteGeometry(
        target.server.connection(), {.format = v1::GEOMETRY_FORMAT_MESH_F64, .bytes = bytes});
    if (!hash.ok()) return false;
    target.hashes.push_back(*hash);
  }
  return true;
}

bool Apply(const MeasuredServer& server, const v1::ApplyChangesRequest& request) {
  const client::Connection& connection = server.connection();
  return connection.Call(&v1::WorldService::Stub::ApplyChanges, connection.worlds(), request).ok();
}

bool PutBoxes(const MeasuredServer& server, const std::string& world, int count) {
  v1::ApplyChangesRequest request;
  request.set_world(world);
  const int side = std::max(1, static_cast<int>(std::cbrt(count)));
  for (int i = 0; i < count; ++i) {
    v1::Object* object = request.add_changes()->mutable_put()->mutable_object();
    object->set_name(absl::StrCat("box_", i));
    v1::Pose* pose = object->mutable_x_world_object();
    pose->set_tx_m(0.2 * (i % side));
    pose->set_ty_m(0.2 * (i / side % side));
    pose->set_tz_m(0.2 * (i / side / side));
    pose->set_qw(1);
    v1::Box* box = object->add_shapes()->mutable_box();
    box->set_size_x_m(0.05);
    box->set_size_y_m(0.05);
    box->set_size_z_m(0.05);
  }
  return Apply(server, request);
}

bool PutMesh(const MeasuredServer& server, const std::string& world, const std::string& hash) {
  v1::ApplyChangesRequest request;
  request.set_world(world);
  v1::Object* object = request.add_changes()->mutable_put()->mutable_object();
  object->set_name("torus");
  object->mutable_x_world_object()->set_qw(1);
  object->add_shapes()->mutable_mesh()->set_hash(hash);
  return Apply(server, request);
}

std::string ArmUrdf(int links) {
  std::string urdf = R"(<robot name="arm"><link name="a0"/>)";
  for (int i = 1; i <= links; ++i) {
    absl::StrAppend(
        &urdf, R"(<link name="a)", i,
        R"("><collision><geometry><sphere radius=".01"/></geometry></collision></link>)",
        R"(<joint name="j)", i, R"(" type="prismatic"><origin xyz=".1 0 0"/><parent link="a)",
        i - 1, R"("/><child link="a)", i, R"("/><axis xyz="0 0 1"/>)",
        R"(<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>)");
  }
  return urdf + "</robot>";
}

bool LoadArm(const MeasuredServer& server, const std::string& world, int links) {
  v1::LoadRobotHeader header;
  header.set_world(world);
  header.set_urdf(ArmUrdf(links));
  return client::LoadRobot(server.connection(), header, {}).ok();
}

v1::ApplyChangesRequest TinySpheres(const std::string& world, int count) {
  v1::ApplyChangesRequest request;
  request.set_world(world);
  for (int i = 0; i < count; ++i) {
    v1::Object* object = request.add_changes()->mutable_put()->mutable_object();
    object->set_name(absl::StrCat(absl::Hex(i)));
    object->add_shapes()->mutable_sphere()->set_radius_m(0.001);
  }
  return request;
}

std::string PoseBytes(int rows, double from_x_m) {
  std::vector<client::PoseRow> poses;
  poses.reserve(static_cast<std::size_t>(rows));
  for (int i = 0; i < rows; ++i) poses.push_back({from_x_m + 0.001 * i, 0, 0, 0, 0, 0, 1});
  return client::RowBytes(poses);
}

std::string PointBytes(int points) {
  std::vector<client::PointRow> rows;
  for (int i = 0; i < points; ++i) {
    rows.push_back({0.35 * std::cos(i * 0.1), 0.35 * std::sin(i * 0.1), 1e-6 * i});
  }
  return client::RowBytes(rows);
}

CallPlan RobotUploadPlan(const v1::LoadRobotHeader& header, const std::vector<NamedFile>& files) {
  CallPlan plan{.method = "cwm.v1.RobotService/LoadRobot"};
  v1::LoadRobotRequest message;
  *message.mutable_header() = header;
  plan.messages.push_back(message.SerializeAsString());
  for (const NamedFile& file : files) {
    message.mutable_file()->set_name(file.name);
    message.mutable_file()->set_total_bytes(static_cast<std::int64_t>(file.bytes.size()));
    plan.messages.push_back(message.SerializeAsString());
    for (std::size_t offset = 0; offset < file.bytes.size(); offset += kChunkBytes) {
      v1::RobotFileChunk* chunk = message.mutable_chunk();
      chunk->set_offset(static_cast<std::int64_t>(offset));
      chunk->set_data(file.bytes.substr(offset, kChunkBytes));
      chunk->set_crc32c(Crc32c(chunk->data()));
      plan.messages.push_back(message.SerializeAsString());
    }
  }
  message.mutable_finish();
  plan.messages.push_back(message.SerializeAsString());
  return plan;
}

std::string MeshUrdf(const std::vector<std::string>& files, const std::vector<double>& scales) {
  std::string urdf = R"(<robot name="r"><link name="l">)";
  for (const std::string& file : files) {
    for (const double scale : scales) {
      absl::StrAppend(&urdf, R"(<collision><geometry><mesh filename=")", file, R"(" scale=")",
                      scale, " ", scale, " ", scale, R"("/></geometry></collision>)");
    }
  }
  return urdf + "</link></robot>";
}

CallPlan CloudUploadPlan(const std::string& world, const std::vector<float>& xyz) {
  constexpr int kPointBytes = 12;
  const std::string bytes(reinterpret_cast<const char*>(xyz.data()), xyz.size() * sizeof(float));
  CallPlan plan{.method = "cwm.v1.PerceptionService/IngestCloud"};
  v1::IngestCloudRequest message;
  v1::IngestCloudHeader* header = message.mutable_header();
  header->set_world(world);
  header->set_point_count(static_cast<std::int64_t>(xyz.size() / 3));
  header->set_total_bytes(static_cast<std::int64_t>(bytes.size()));
  header->mutable_layout()->set_point_step(kPointBytes);
  for (int axis = 0; axis < 3; ++axis) {
    v1::CloudField* field = header->mutable_layout()->add_fields();
    field->set_name(std::string(1, static_cast<char>('x' + axis)));
    field->set_offset(4 * axis);
    field->set_type(v1::FIELD_TYPE_F32);
  }
  plan.messages.push_back(message.SerializeAsString());
  for (std::size_t offset = 0; offset < bytes.size(); offset += kChunkBytes) {
    v1::CloudChunk* chunk = message.mutable_chunk();
    chunk->set_offset(static_cast<std::int64_t>(offset));
    chunk->set_data(bytes.substr(offset, kChunkBytes));
    chunk->set_crc32c(Crc32c(chunk->data()));
    plan.messages.push_back(message.SerializeAsString());
  }
  message.mutable_finish();
  plan.messages.push_back(message.SerializeAsString());
  return plan;
}

std::vector<float> NoisePoints(int count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> along(0.5F, 2.5F);
  std::vector<float> xyz(static_cast<std::size_t>(3 * count));
  for (float& coordinate : xyz) coordinate = along(random);
  return xyz;
}

}  // namespace cwm::benchmarks
