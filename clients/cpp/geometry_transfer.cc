#include "clients/cpp/geometry_transfer.h"

#include <cstring>

#include "absl/strings/str_cat.h"
#include "clients/cpp/sha256.h"

namespace cwm::client {
namespace {

namespace pb = cwm::v1;

constexpr std::size_t kMeshHeaderBytes = 2 * sizeof(std::uint32_t);
constexpr std::size_t kVertexBytes = 3 * sizeof(double);
constexpr std::size_t kTriangleBytes = 3 * sizeof(std::uint32_t);

}  // namespace

absl::StatusOr<Blob> ReadGeometry(const Connection& connection, const std::string& hash) {
  grpc::ClientContext context;
  connection.Prepare(context);
  pb::ReadGeometryRequest request;
  request.set_hash(hash);
  const auto reader = connection.worlds().ReadGeometry(&context, request);
  Blob blob;
  pb::ReadGeometryResponse chunk;
  while (reader->Read(&chunk)) {
    blob.format = chunk.format();
    blob.bytes += chunk.data();
  }
  if (const grpc::Status status = reader->Finish(); !status.ok()) return FromGrpc(status);
  if (Sha256Hex(blob.bytes) != hash) {
    return absl::DataLossError(absl::StrCat("geometry ", hash, " arrived with another hash"));
  }
  return blob;
}

absl::StatusOr<std::string> WriteGeometry(const Connection& connection, const Blob& blob) {
  grpc::ClientContext context;
  connection.Prepare(context);
  pb::WriteGeometryResponse response;
  const auto writer = connection.worlds().WriteGeometry(&context, &response);
  pb::WriteGeometryRequest request;
  request.mutable_header()->set_format(blob.format);
  request.mutable_header()->set_total_bytes(static_cast<std::int64_t>(blob.bytes.size()));
  request.mutable_header()->set_hash(Sha256Hex(blob.bytes));
  bool open = writer->Write(request);
  for (std::size_t offset = 0; open && offset < blob.bytes.size(); offset += kChunkBytes) {
    request.mutable_chunk()->set_offset(static_cast<std::int64_t>(offset));
    request.mutable_chunk()->set_data(blob.bytes.substr(offset, kChunkBytes));
    open = writer->Write(request);
  }
  if (open) writer->WritesDone();
  if (const grpc::Status status = writer->Finish(); !status.ok()) return FromGrpc(status);
  return response.hash();
}

std::string EncodeMesh(const formats::MeshFile& mesh) {
  const std::uint32_t counts[] = {static_cast<std::uint32_t>(mesh.vertices.size()),
                                  static_cast<std::uint32_t>(mesh.triangles.size())};
  std::string bytes(reinterpret_cast<const char*>(counts), sizeof(counts));
  bytes.append(reinterpret_cast<const char*>(mesh.vertices.data()),
               mesh.vertices.size() * kVertexBytes);
  bytes.append(reinterpret_cast<const char*>(mesh.triangles.data()),
               mesh.triangles.size() * kTriangleBytes);
  return bytes;
}

absl::StatusOr<formats::MeshFile> DecodeMesh(std::string_view bytes) {
  std::uint32_t counts[2] = {0, 0};
  if (bytes.size() >= kMeshHeaderBytes) std::memcpy(counts, bytes.data(), kMeshHeaderBytes);
  const std::size_t vertex_bytes = counts[0] * kVertexBytes;
  const std::size_t expected = kMeshHeaderBytes + vertex_bytes + counts[1] * kTriangleBytes;
  if (bytes.size() != expected) {
    return absl::InvalidArgumentError(absl::StrCat("mesh holds ", bytes.size(), " bytes, must be ",
                                                   expected, " for ", counts[0], " vertices and ",
                                                   counts[1], " triangles"));
  }
  formats::MeshFile mesh;
  mesh.vertices.resize(counts[0]);
  mesh.triangles.resize(counts[1]);
  bytes.remove_prefix(kMeshHeaderBytes);
  if (counts[0] > 0) std::memcpy(mesh.vertices.data(), bytes.data(), vertex_bytes);
  if (counts[1] > 0) {
    std::memcpy(mesh.triangles.data(), bytes.data() + vertex_bytes, bytes.size() - vertex_bytes);
  }
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t corner : triangle) {
      if (corner < counts[0]) continue;
      return absl::InvalidArgumentError(
          absl::StrCat("triangle corner is ", corner, ", must be below ", counts[0]));
    }
  }
  return mesh;
}

}  // namespace cwm::client
