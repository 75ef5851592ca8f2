#include "clients/cpp/geometry_transfer.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "absl/strings/str_cat.h"
#include "proto/transfer/chunks.h"
#include "proto/transfer/mesh_bytes.h"
#include "proto/transfer/sha256.h"

namespace cwm::client {

namespace pb = cwm::v1;

namespace {

struct Received {
  Blob blob;
  pb::GeometryHeader header;
};

absl::StatusOr<Received> Receive(const Connection& connection,
                                 const pb::ReadGeometryRequest& request,
                                 const Progress& progress = {}) {
  grpc::ClientContext context;
  connection.Prepare(context);
  const auto reader = connection.worlds().ReadGeometry(&context, request);
  Received received;
  pb::ReadGeometryResponse chunk;
  while (reader->Read(&chunk)) {
    if (chunk.has_header()) received.header = chunk.header();
    received.blob.format = chunk.format();
    received.blob.bytes += chunk.data();
    if (!progress) continue;
    progress(static_cast<std::int64_t>(received.blob.bytes.size()), chunk.total_bytes());
  }
  if (const grpc::Status status = reader->Finish(); !status.ok()) return StatusFromGrpc(status);
  return received;
}

absl::Status CheckHash(std::string_view what, const std::string& bytes, const std::string& hash) {
  if (Sha256Hex(bytes) == hash) return absl::OkStatus();
  return absl::DataLossError(absl::StrCat(absl::string_view(what.data(), what.size()), " ", hash,
                                          " arrived with another hash"));
}

}  // namespace

absl::StatusOr<Blob> ReadGeometry(const Connection& connection, const std::string& hash) {
  pb::ReadGeometryRequest request;
  request.set_hash(hash);
  auto received = Receive(connection, request);
  if (!received.ok()) return received.status();
  if (auto status = CheckHash("geometry", received->blob.bytes, hash); !status.ok()) return status;
  return std::move(received->blob);
}

absl::StatusOr<Surface> ReadSurface(const Connection& connection, const pb::ObjectSurface& object,
                                    const Progress& progress) {
  pb::ReadGeometryRequest request;
  *request.mutable_object() = object;
  auto received = Receive(connection, request, progress);
  if (!received.ok()) return received.status();
  const std::string& bytes = received->blob.bytes;
  auto status = CheckHash("surface", bytes, received->header.hash());
  if (!status.ok()) return status;
  auto mesh = DecodeMesh(bytes);
  if (!mesh.ok()) return mesh.status();
  return Surface{*std::move(mesh), std::move(received->header)};
}

absl::StatusOr<std::string> WriteGeometry(const Connection& connection, const Blob& blob,
                                          const Progress& progress) {
  grpc::ClientContext context;
  connection.Prepare(context);
  pb::WriteGeometryResponse response;
  const auto writer = connection.worlds().WriteGeometry(&context, &response);
  pb::WriteGeometryRequest request;
  request.mutable_header()->set_format(blob.format);
  request.mutable_header()->set_total_bytes(static_cast<std::int64_t>(blob.bytes.size()));
  request.mutable_header()->set_hash(Sha256Hex(blob.bytes));
  bool open = writer->Write(request);
  for (std::size_t offset = 0; open && offset < blob.bytes.size(); offset += kMaxChunkBytes) {
    request.mutable_chunk()->set_offset(static_cast<std::int64_t>(offset));
    request.mutable_chunk()->set_data(blob.bytes.substr(offset, kMaxChunkBytes));
    open = writer->Write(request);
    if (!open || !progress) continue;
    progress(static_cast<std::int64_t>(std::min(offset + kMaxChunkBytes, blob.bytes.size())),
             static_cast<std::int64_t>(blob.bytes.size()));
  }
  if (open) writer->WritesDone();
  if (const grpc::Status status = writer->Finish(); !status.ok()) return StatusFromGrpc(status);
  return response.hash();
}

absl::StatusOr<formats::MeshFile> DecodeMesh(std::string_view bytes) {
  auto mesh = ReadMeshColumns<formats::MeshFile>(bytes);
  if (!mesh.ok()) {
    return absl::InvalidArgumentError(absl::StrCat("mesh ", std::string(mesh.status().message())));
  }
  for (const auto& triangle : mesh->triangles) {
    for (const std::uint32_t corner : triangle) {
      if (corner < mesh->vertices.size()) continue;
      return absl::InvalidArgumentError(
          absl::StrCat("triangle corner is ", corner, ", must be below ", mesh->vertices.size()));
    }
  }
  return mesh;
}

}  // namespace cwm::client
