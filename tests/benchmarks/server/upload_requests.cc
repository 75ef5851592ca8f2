// Uploads of clouds and blobs: half uploads, announced sizes, zeros, clouds that no sensor makes.
#include <algorithm>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "proto/transfer/crc32c.h"
#include "tests/benchmarks/server/hostile_content.h"
#include "tests/benchmarks/server/hostile_request.h"

namespace cwm::benchmarks {
namespace {

constexpr char kWrite[] = "cwm.v1.WorldService/WriteGeometry";
constexpr char kIngest[] = "cwm.v1.PerceptionService/IngestCloud";
constexpr std::int64_t kPromised = 80'000'000;  // labels of as many points as a cloud may have
constexpr std::size_t kZerosBytes = 1 << 20;

// An upload that stops after some chunks of zeros.
CallPlan HalfWritten(int chunks) {
  CallPlan plan{.method = kWrite, .half_closes = false};
  v1::WriteGeometryRequest message;
  message.mutable_header()->set_format(v1::GEOMETRY_FORMAT_LABELS_U32);
  message.mutable_header()->set_total_bytes(kPromised);
  plan.messages.push_back(message.SerializeAsString());
  for (int i = 0; i < chunks; ++i) {
    message.mutable_chunk()->set_offset(static_cast<std::int64_t>(i * kZerosBytes));
    message.mutable_chunk()->set_data(std::string(kZerosBytes, '\0'));
    plan.messages.push_back(message.SerializeAsString());
  }
  return plan;
}

CallPlan HalfIngested(int chunks) {
  constexpr std::int64_t kPoints = 20'000'000;
  CallPlan plan = CloudUploadPlan("half", {1, 2, 3});
  plan.half_closes = false;
  v1::IngestCloudRequest message;
  message.ParseFromString(plan.messages[0]);
  message.mutable_header()->set_point_count(kPoints);
  message.mutable_header()->set_total_bytes(kPoints * 12);
  plan.messages = {message.SerializeAsString()};
  for (int i = 0; i < chunks; ++i) {
    message.mutable_chunk()->set_offset(static_cast<std::int64_t>(i * kZerosBytes));
    message.mutable_chunk()->set_data(std::string(kZerosBytes, '\0'));
    message.mutable_chunk()->set_crc32c(Crc32c(message.chunk().data()));
    plan.messages.push_back(message.SerializeAsString());
  }
  return plan;
}

SendCopy Holding(CallPlan plan, int calls) {
  return [plan, calls](const Target& target, int, Sent& sent) {
    const auto channel = target.server.NewChannel();
    for (int i = 0; i < calls; ++i) target.HoldOver(channel, plan, sent);
  };
}

std::vector<float> SamePoint(int count) {
  std::vector<float> xyz;
  for (int i = 0; i < count; ++i) xyz.insert(xyz.end(), {1.0F, 0.5F, 0.25F});
  return xyz;
}

std::vector<float> NanPoints(int count) {
  return std::vector<float>(static_cast<std::size_t>(3 * count),
                            std::numeric_limits<float>::quiet_NaN());
}

// Points on a lattice: planes in all directions.
std::vector<float> Lattice(int side) {
  std::vector<float> xyz;
  for (int i = 0; i < side * side * side; ++i) {
    xyz.insert(xyz.end(), {0.5F + 0.01F * static_cast<float>(i % side),
                           0.01F * static_cast<float>(i / side % side),
                           0.01F * static_cast<float>(i / side / side)});
  }
  return xyz;
}

// Ingests a cloud. Its content is the part of the scan that a world may keep, points and labels;
// the model is added to that.
SendCopy Ingest(std::vector<float> xyz) {
  return [xyz = std::move(xyz)](const Target& target, int copy, Sent& sent) {
    CallPlan plan = CloudUploadPlan(absl::StrCat("scan_", copy), xyz);
    constexpr std::int64_t kBytesOfPoint = 16;
    const auto finite = std::count_if(xyz.begin(), xyz.end(), [](float x) { return x == x; });
    sent.content_bytes = finite / 3 * kBytesOfPoint;
    target.Hold(plan, sent);
  };
}

// Many blobs of a few bytes that nothing refers to, over one connection.
void TinyBlobs(const Target& target, int copy, Sent& sent) {
  std::vector<CallPlan> plans;
  for (int i = 0; i < 3'000; ++i) {
    v1::WriteGeometryRequest header, chunk;
    const std::string label = absl::StrCat(absl::Hex(copy * 100'000 + i, absl::kZeroPad8));
    header.mutable_header()->set_format(v1::GEOMETRY_FORMAT_LABELS_U32);
    header.mutable_header()->set_total_bytes(static_cast<std::int64_t>(label.size()));
    chunk.mutable_chunk()->set_data(label);
    plans.push_back(
        {.method = kWrite, .messages = {header.SerializeAsString(), chunk.SerializeAsString()}});
  }
  target.CallSequentially(plans, 2.0, sent);
}

// A mesh of kTriangles triangles that share three vertices: every triangle has the same corners.
void FlatMesh(const Target& target, int copy, Sent& sent) {
  constexpr std::uint32_t kTriangles = 80'000;
  const std::uint32_t counts[2] = {3, kTriangles};
  std::string bytes(reinterpret_cast<const char*>(counts), sizeof(counts));
  const double vertices[9] = {0, 0, 0, 1.0 + copy, 0, 0, 0, 1, 0};
  bytes.append(reinterpret_cast<const char*>(vertices), sizeof(vertices));
  const std::uint32_t triangle[3] = {0, 1, 2};
  for (std::uint32_t i = 0; i < kTriangles; ++i) {
    bytes.append(reinterpret_cast<const char*>(triangle), sizeof(triangle));
  }
  v1::WriteGeometryRequest header, chunk;
  header.mutable_header()->set_format(v1::GEOMETRY_FORMAT_MESH_F64);
  header.mutable_header()->set_total_bytes(static_cast<std::int64_t>(bytes.size()));
  chunk.mutable_chunk()->set_data(bytes);
  CallPlan plan{.method = kWrite,
                .messages = {header.SerializeAsString(), chunk.SerializeAsString()}};
  sent.content_bytes = static_cast<std::int64_t>(bytes.size());
  target.Hold(plan, sent);
}

}  // namespace

std::vector<HostileRequest> UploadRequests() {
  return {
      {.name = "WriteGeometry/promise",
       .copies = 1,
       .send = Holding(HalfWritten(0), 200),
       .has_cpu = false},
      {.name = "WriteGeometry/half",
       .copies = 4,
       .send = Holding(HalfWritten(4), 1),
       .has_cpu = false},
      {.name = "WriteGeometry/half_large", .copies = 4, .send = Holding(HalfWritten(32), 1)},
      {.name = "WriteGeometry/tiny_blobs", .copies = 1, .send = TinyBlobs, .has_cpu = false},
      {.name = "WriteGeometry/flat_mesh", .copies = 4, .send = FlatMesh},
      {.name = "IngestCloud/promise",
       .copies = 1,
       .send = Holding(HalfIngested(0), 200),
       .has_cpu = false},
      {.name = "IngestCloud/half_large", .copies = 4, .send = Holding(HalfIngested(32), 1)},
      {.name = "IngestCloud/noise", .copies = 1, .send = Ingest(NoisePoints(200'000))},
      {.name = "IngestCloud/same_point", .copies = 1, .send = Ingest(SamePoint(200'000))},
      {.name = "IngestCloud/same_point_large", .copies = 1, .send = Ingest(SamePoint(1'000'000))},
      {.name = "IngestCloud/not_a_number", .copies = 1, .send = Ingest(NanPoints(1'000'000))},
      {.name = "IngestCloud/lattice", .copies = 1, .send = Ingest(Lattice(60))},
  };
}

}  // namespace cwm::benchmarks
