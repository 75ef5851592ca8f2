#include "clients/cpp/cloud_upload.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "clients/cpp/geometry_transfer.h"
#include "proto/transfer/chunks.h"
#include "proto/transfer/crc32c.h"
#include "proto/transfer/sha256.h"

namespace cwm::client {
namespace {

using formats::CloudField;
using formats::CloudFile;
using formats::Scalar;
namespace pb = cwm::v1;

std::optional<pb::FieldType> WireType(Scalar type) {
  switch (type) {
    case Scalar::kI8:
      return pb::FIELD_TYPE_I8;
    case Scalar::kU8:
      return pb::FIELD_TYPE_U8;
    case Scalar::kI16:
      return pb::FIELD_TYPE_I16;
    case Scalar::kU16:
      return pb::FIELD_TYPE_U16;
    case Scalar::kI32:
      return pb::FIELD_TYPE_I32;
    case Scalar::kU32:
      return pb::FIELD_TYPE_U32;
    case Scalar::kF32:
      return pb::FIELD_TYPE_F32;
    case Scalar::kF64:
      return pb::FIELD_TYPE_F64;
    case Scalar::kI64:
    case Scalar::kU64:
      break;
  }
  return std::nullopt;
}

absl::Status CheckCoordinate(const CloudFile& cloud, const std::string& name) {
  const CloudField* field = cloud.Find(name);
  if (field == nullptr) {
    return absl::InvalidArgumentError(absl::StrCat("field ", name, " is missing from the cloud"));
  }
  if (field->count == 1 && WireType(field->type)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("field ", name, " is ", field->count, " x ", std::string(NameOf(field->type)),
                   ", must be one number of at most 32 bits or a float"));
}

// False if the server has ended the call; its status then has the reason.
bool Send(const std::string& bytes, const Progress& progress,
          grpc::ClientWriter<pb::IngestCloudRequest>& writer) {
  const auto total = static_cast<std::int64_t>(bytes.size());
  Sha256 sent;
  for (std::int64_t offset = 0; offset < total; offset += kMaxChunkBytes) {
    pb::IngestCloudRequest request;
    pb::CloudChunk& chunk = *request.mutable_chunk();
    const auto begin = static_cast<std::size_t>(offset);
    chunk.set_offset(offset);
    chunk.set_data(bytes.substr(begin, kMaxChunkBytes));
    chunk.set_crc32c(Crc32c(chunk.data()));
    sent.Add(chunk.data().data(), chunk.data().size());
    if (!writer.Write(request)) return false;
    if (progress) progress(std::min(offset + kMaxChunkBytes, total), total);
  }
  pb::IngestCloudRequest finish;
  finish.mutable_finish()->set_sha256(sent.Hex());
  return writer.Write(finish) && writer.WritesDone();
}

// Sends the header and the bytes, and waits for the reply.
absl::StatusOr<pb::IngestCloudResponse> Upload(const Connection& connection,
                                               pb::IngestCloudHeader header,
                                               const std::string& bytes, const Progress& progress) {
  header.set_total_bytes(static_cast<std::int64_t>(bytes.size()));
  grpc::ClientContext context;
  connection.Prepare(context);
  pb::IngestCloudResponse response;
  const auto writer = connection.perception().IngestCloud(&context, &response);
  pb::IngestCloudRequest first;
  *first.mutable_header() = std::move(header);
  // A failed write has no reason itself: Finish returns the server's.
  if (writer->Write(first)) Send(bytes, progress, *writer);
  const grpc::Status status = writer->Finish();
  if (!status.ok()) return StatusFromGrpc(status);
  return response;
}

}  // namespace

absl::StatusOr<CloudFile> SelectGeometry(const CloudFile& cloud) {
  std::vector<std::string> names = {"x", "y", "z"};
  const std::vector<std::string> normals = {"normal_x", "normal_y", "normal_z"};
  const bool has_normals = std::all_of(normals.begin(), normals.end(), [&](const auto& name) {
    return CheckCoordinate(cloud, name).ok();
  });
  for (const std::string& name : names) {
    if (absl::Status status = CheckCoordinate(cloud, name); !status.ok()) return status;
  }
  if (has_normals) names.insert(names.end(), normals.begin(), normals.end());
  return formats::SelectFields(cloud, names);
}

absl::StatusOr<pb::CloudLayout> LayoutOf(const CloudFile& cloud) {
  pb::CloudLayout layout;
  for (const CloudField& field : cloud.fields) {
    if (absl::Status status = CheckCoordinate(cloud, field.name); !status.ok()) return status;
    pb::CloudField& wire = *layout.add_fields();
    wire.set_name(field.name);
    wire.set_offset(static_cast<int>(field.offset));
    wire.set_type(*WireType(field.type));
  }
  layout.set_point_step(static_cast<int>(cloud.point_step));
  return layout;
}

absl::StatusOr<pb::IngestCloudResponse> IngestCloud(const Connection& connection,
                                                    pb::IngestCloudHeader header,
                                                    const CloudFile& cloud,
                                                    const Progress& progress) {
  auto layout = LayoutOf(cloud);
  if (!layout.ok()) return layout.status();
  *header.mutable_layout() = *std::move(layout);
  header.set_point_count(cloud.size());
  header.set_width(static_cast<int>(cloud.width));
  header.set_height(static_cast<int>(cloud.height));
  return Upload(connection, std::move(header), cloud.bytes, progress);
}

absl::StatusOr<pb::IngestCloudResponse> IngestDepth(const Connection& connection,
                                                    pb::IngestCloudHeader header,
                                                    const std::string& bytes,
                                                    const Progress& progress) {
  return Upload(connection, std::move(header), bytes, progress);
}

absl::StatusOr<std::vector<std::uint32_t>> ReadLabels(const Connection& connection,
                                                      const pb::IngestCloudResponse& response,
                                                      std::int64_t point_count) {
  std::string bytes = response.labels();
  if (bytes.empty() && !response.labels_hash().empty()) {
    auto blob = ReadGeometry(connection, response.labels_hash());
    if (!blob.ok()) return blob.status();
    bytes = std::move(blob->bytes);
  }
  std::vector<std::uint32_t> labels(static_cast<std::size_t>(point_count));
  if (bytes.size() != labels.size() * sizeof(labels[0])) {
    return absl::InternalError(absl::StrCat(
        "labels hold ", bytes.size(), " bytes, must be 4 for each of ", point_count, " points"));
  }
  std::memcpy(labels.data(), bytes.data(), bytes.size());
  return labels;
}

}  // namespace cwm::client
