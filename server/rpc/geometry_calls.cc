#include "server/rpc/geometry_calls.h"

#include <algorithm>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "proto/transfer/mesh_bytes.h"
#include "server/core/error.h"
#include "server/rpc/at_revision.h"
#include "server/rpc/query_queue.h"
#include "server/rpc/status_conversion.h"
#include "server/wire/numbers.h"
#include "server/wire/objects.h"
#include "server/wire/poses.h"
#include "server/wire/queries.h"

namespace cwm::server {
namespace {

// derived: a triangle cannot use more than three vertices.
constexpr std::int64_t kMaxBytesPerTriangle = 3 * kVertexBytes + kTriangleBytes;

absl::Status CheckTriangleCount(const std::string& bytes, const Limits& limits) {
  const auto counts = ReadMeshCounts(bytes);
  if (!counts.ok()) return absl::OkStatus();  // Put reports the error
  const FieldPath request;
  const FieldPath chunk = request.Field("chunk");
  const FieldPath data = chunk.Field("data");
  return CheckRange(counts->triangles, {0, limits.max_mesh_triangles},
                    data.Field("triangle_count"));
}

BlobFormat FormatOf(const v1::WriteGeometryRequest::Header& header) {
  switch (header.format()) {
    case v1::GEOMETRY_FORMAT_LABELS_U32:
      return BlobFormat::kLabelsU32;
    case v1::GEOMETRY_FORMAT_POINTS_F32:
      return BlobFormat::kPointsF32;
    default:
      return BlobFormat::kMeshF64;
  }
}

v1::GeometryFormat FormatToProto(BlobFormat format) {
  switch (format) {
    case BlobFormat::kMeshF64:
      return v1::GEOMETRY_FORMAT_MESH_F64;
    case BlobFormat::kLabelsU32:
      return v1::GEOMETRY_FORMAT_LABELS_U32;
    case BlobFormat::kPointsF32:
      return v1::GEOMETRY_FORMAT_POINTS_F32;
  }
  return v1::GEOMETRY_FORMAT_UNSPECIFIED;
}

// The error of a request that does not name exactly one source.
absl::Status ObjectOrHashError(const std::string& fault) {
  const std::string rule = "must give exactly one of hash and object";
  return MakeError(absl::StatusCode::kInvalidArgument,
                   absl::StrCat("hash and object ", fault, ", ", rule),
                   {.reason = "INVALID_FIELD",
                    .fields = {{"hash", absl::StrCat(fault, ", ", rule)},
                               {"object", absl::StrCat(fault, ", ", rule)}}});
}

}  // namespace

ReadGeometryCall::ReadGeometryCall(grpc::CallbackServerContext* context, Runtime& runtime,
                                   const grpc::ByteBuffer* request)
    : ChunkedRead(context, runtime, runtime.reads) {
  if (const absl::Status parsed = ReadRequest(request, &request_); !parsed.ok()) {
    Start(parsed);
  } else if (!request_.hash().empty()) {
    Start(std::nullopt);
  } else {
    const v1::ObjectSurface& object = request_.object();
    Start(FindRevisionToAwait(runtime, object.world(), object.world_uid(), object.at_revision()));
  }
}

absl::Status ReadGeometryCall::Prepare(const CallContext& call) {
  const bool by_hash = !request_.hash().empty();
  if (by_hash == request_.has_object()) {
    return ObjectOrHashError(by_hash ? "are both given" : "are both absent");
  }
  const absl::Status found = by_hash ? FindBlob() : FindSurface(call);
  return found.ok() ? Begin() : found;
}

absl::Status ReadGeometryCall::FindBlob() {
  const auto blob = runtime_.application.geometry.Get(request_.hash());
  if (!blob.ok()) return blob.status();
  bytes_ = (*blob)->bytes;
  message_.set_format(FormatToProto((*blob)->format));
  message_.mutable_header()->set_hash(request_.hash());
  return absl::OkStatus();
}

absl::Status ReadGeometryCall::FindSurface(const CallContext& call) {
  const FieldPath root;  // must outlive the paths derived from it
  const FieldPath path = root.Field("object");
  const v1::ObjectSurface& requested = request_.object();
  if (auto status = CheckName(requested.name(), path.Field("name")); !status.ok()) return status;
  const auto rule = RevisionRuleFromProto(requested.at_revision(), path.Field("at_revision"));
  if (!rule.ok()) return rule.status();
  const auto at = FindWorldAt(runtime_, requested.world(), requested.world_uid(), *rule, call);
  if (!at.ok()) return at.status();
  const collision::WorldObjectPtr object = at->snapshot->Find(requested.name());
  if (object == nullptr) return UnknownObject(requested.name());
  WorkBudget budget(call.deadline, call.stop);
  const auto surface = runtime_.application.geometry.SurfaceOf(object->geometry, &budget);
  if (!surface.ok()) return surface.status();
  bytes_ = {*surface, &(*surface)->bytes};
  message_.set_format(v1::GEOMETRY_FORMAT_MESH_F64);
  v1::GeometryHeader& header = *message_.mutable_header();
  header.set_hash((*surface)->hash);
  header.set_world_uid(at->world->uid());
  header.set_revision(at->snapshot->revision().value);
  *header.mutable_x_world_object() = PoseToProto(object->X_WO);
  header.set_max_deviation_m((*surface)->max_deviation_m);
  return absl::OkStatus();
}

absl::Status ReadGeometryCall::Begin() {
  const auto total = static_cast<std::int64_t>(bytes_->size());
  auto status = CheckRange(request_.offset(), {0, total}, FieldPath::OfRequest("offset"));
  if (!status.ok()) return status;
  offset_ = static_cast<std::size_t>(request_.offset());
  message_.set_total_bytes(total);
  if (message_.format() != v1::GEOMETRY_FORMAT_MESH_F64) return absl::OkStatus();
  const auto counts = ReadMeshCounts(*bytes_);
  if (!counts.ok()) return counts.status();
  message_.mutable_header()->set_vertex_count(counts->vertices);
  message_.mutable_header()->set_triangle_count(counts->triangles);
  return absl::OkStatus();
}

void ReadGeometryCall::Complete(v1::ReadGeometryResponse& message) {
  if (message.offset() > request_.offset()) message.clear_header();
}

// Bytes that are known already need not be sent.
std::function<absl::StatusOr<bool>()> WriteGeometryCall::LookUp() {
  if (header_.hash().empty() || std::exchange(is_looked_up_, true)) return nullptr;
  return [this] { return IsKnown(); };
}

absl::StatusOr<bool> WriteGeometryCall::IsKnown() {
  GeometryStore& store = runtime_.application.geometry;
  const std::string hash = absl::AsciiStrToLower(header_.hash());
  const auto blob = store.Get(hash);
  if (!blob.ok()) return false;
  const auto size = static_cast<std::int64_t>((*blob)->bytes->size());
  if (header_.total_bytes() != size) {
    return InvalidField("header.total_bytes", absl::StrCat("is ", header_.total_bytes(),
                                                           ", must be ", size, " for that hash"));
  }
  auto stored = store.Renew(FormatOf(header_), hash);
  if (absl::IsNotFound(stored.status())) return false;  // it was just dropped
  if (!stored.ok()) return stored.status();
  Reply(*stored);
  return true;
}

absl::Status WriteGeometryCall::Take(const v1::WriteGeometryRequest& message) {
  const FieldPath root;
  switch (message.what_case()) {
    case v1::WriteGeometryRequest::kHeader:
      return TakeHeader(message.header());
    case v1::WriteGeometryRequest::kChunk:
      if (!upload_) return root.Field("chunk").Error("came before the header, must come after it");
      return upload_->Append(message.chunk().offset(), message.chunk().data(), root.Field("chunk"));
    case v1::WriteGeometryRequest::WHAT_NOT_SET:
      break;
  }
  return root.Field("what").Error("is absent, must be one of header, chunk");
}

absl::Status WriteGeometryCall::TakeHeader(const v1::WriteGeometryRequest::Header& header) {
  const FieldPath root;
  const FieldPath path = root.Field("header");
  if (upload_) return path.Error("came twice, must come once");
  if (!v1::GeometryFormat_IsValid(header.format())) {
    return path.Field("format").Error(
        absl::StrCat("is ", static_cast<int>(header.format()), ", must be a known GeometryFormat"));
  }
  const Limits& limits = runtime_.application.limits;
  const std::int64_t max_mesh_bytes =
      kMeshCountsBytes + limits.max_mesh_triangles * kMaxBytesPerTriangle;
  const std::int64_t max_bytes = std::min(max_mesh_bytes, limits.max_geometry_bytes);
  auto status = CheckRange(header.total_bytes(), {1, max_bytes}, path.Field("total_bytes"));
  if (!status.ok()) return status;
  header_ = header;
  upload_.emplace(header.total_bytes(), limits.max_chunk_bytes, EmptyCharge());
  return absl::OkStatus();
}

absl::Status WriteGeometryCall::CheckEnd() const {
  if (!upload_) return InvalidField("header", "is absent, must come first");
  return upload_->CheckComplete(FieldPath::OfRequest("end of the stream"));
}

WorkQueue& WriteGeometryCall::Queue() { return WriteQueueFor(runtime_, Cost_s()); }

double WriteGeometryCall::Cost_s() const {
  return upload_ ? GeometryCost_s(static_cast<std::int64_t>(upload_->bytes().size())) : 0;
}

absl::Status WriteGeometryCall::Work() {
  Application& application = runtime_.application;
  WorkBudget budget(Clock::time_point::max(), stop_.get_token());  // a deadline cancels the call
  const std::string given_hash = absl::AsciiStrToLower(header_.hash());
  if (!given_hash.empty()) {
    const std::string actual = HashOf(upload_->bytes(), &budget);
    if (HasEnded(&budget)) return budget.status();
    if (actual != given_hash) {
      return InvalidField("header.hash", absl::StrCat("is ", given_hash, ", must be ", actual,
                                                      " (SHA-256 of all bytes)"));
    }
  }
  const BlobFormat format = FormatOf(header_);
  if (format == BlobFormat::kMeshF64) {
    auto status = CheckTriangleCount(upload_->bytes(), application.limits);
    if (!status.ok()) return status;
  }
  auto stored = application.geometry.Put(format, upload_->Take(), &budget);
  if (!stored.ok()) return stored.status();
  Reply(*stored);
  return absl::OkStatus();
}

void WriteGeometryCall::Reply(const GeometryStore::Stored& stored) {
  response_.set_hash(stored.hash);
  response_.set_already_known(stored.already_known);
}

}  // namespace cwm::server
