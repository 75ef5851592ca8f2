#include "server/wire/poses.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>

#include "absl/strings/str_cat.h"
#include "collision/geometry/validation.h"
#include "server/wire/numbers.h"

namespace cwm::server {
namespace {

static_assert(std::endian::native == std::endian::little, "bulk bytes are read as they lie");

template <int kWidth>
using Row = std::array<double, kWidth>;

// A broken rule within a row; empty if the row is valid.
struct Fault {
  std::string component;
  std::string description;
};

constexpr std::array<std::string_view, 3> kPointNames = {"x", "y", "z"};
constexpr std::array<std::string_view, 7> kPoseNames = {"tx_m", "ty_m", "tz_m", "qx",
                                                        "qy",   "qz",   "qw"};
constexpr std::array<std::string_view, 6> kRayNames = {"origin x",    "origin y",    "origin z",
                                                       "direction x", "direction y", "direction z"};

bool IsCoordinate(double value) { return std::abs(value) <= kMaxCoordinate_m; }

std::optional<Fault> FindBadNumber(const double* values, const std::string_view* names, int count) {
  for (int i = 0; i < count; ++i) {
    if (IsCoordinate(values[i])) continue;
    return Fault{std::string(names[i]),
                 absl::StrCat("is ", values[i], ", must be finite and at most ", kMaxCoordinate_m,
                              " in magnitude")};
  }
  return std::nullopt;
}

std::optional<Fault> Parse(const Row<7>& row, Pose& X_AB) {
  if (auto fault = FindBadNumber(row.data(), kPoseNames.data(), 7)) return fault;
  const Quaternion rotation(row[6], row[3], row[4], row[5]);
  const double length = rotation.norm();
  if (!(std::abs(length - 1) <= kQuaternionTolerance)) {
    return Fault{"qx..qw", absl::StrCat("has length ", length, ", must be 1 within 1e-3")};
  }
  X_AB = MakePose({row[0], row[1], row[2]}, Quaternion(rotation.coeffs() / length));
  return std::nullopt;
}

std::optional<Fault> Parse(const Row<3>& row, Pose& X_AB) {
  if (auto fault = FindBadNumber(row.data(), kPointNames.data(), 3)) return fault;
  X_AB = MakeTranslation(row[0], row[1], row[2]);
  return std::nullopt;
}

std::optional<Fault> Parse(const Row<3>& row, Vector3& p) {
  if (auto fault = FindBadNumber(row.data(), kPointNames.data(), 3)) return fault;
  p = Vector3(row[0], row[1], row[2]);
  return std::nullopt;
}

std::optional<Fault> Parse(const Row<6>& row, collision::RayRow& ray) {
  if (auto fault = FindBadNumber(row.data(), kRayNames.data(), 6)) return fault;
  const Vector3 direction(row[3], row[4], row[5]);
  const double length = direction.stableNorm();
  if (!(length > 0)) return Fault{"direction", "has length 0, must have a positive length"};
  ray = {.origin = {row[0], row[1], row[2]}, .direction = direction.stableNormalized()};
  return std::nullopt;
}

template <class Number, int kWidth>
Row<kWidth> ReadRow(const char* bytes) {
  std::array<Number, kWidth> raw;
  std::memcpy(raw.data(), bytes, sizeof(raw));
  Row<kWidth> row;
  for (int i = 0; i < kWidth; ++i) row[i] = raw[i];
  return row;
}

template <class Number, int kWidth, class Value>
absl::Status ParseRows(std::string_view data, std::vector<Value>& values, const FieldPath& path) {
  constexpr std::size_t kRowBytes = sizeof(Number) * kWidth;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto row = ReadRow<Number, kWidth>(data.data() + i * kRowBytes);
    if (const auto fault = Parse(row, values[i])) {
      const std::string field = absl::StrCat("data row ", i);
      return path.Field(field).Error(fault->component + " " + fault->description);
    }
  }
  return absl::OkStatus();
}

// `Rows` is any message with `scalar` and `data`.
template <int kWidth, class Value, class Rows>
absl::StatusOr<std::vector<Value>> FromRows(const Rows& rows, std::int64_t max_rows,
                                            const FieldPath& path) {
  const auto count = CountRows({rows.scalar(), rows.data(), kWidth}, max_rows, path);
  if (!count.ok()) return count.status();
  std::vector<Value> values(*count);
  const bool single = rows.scalar() == v1::SCALAR_F32;
  const std::string& data = rows.data();
  const absl::Status status = single ? ParseRows<float, kWidth>(data, values, path)
                                     : ParseRows<double, kWidth>(data, values, path);
  if (!status.ok()) return status;
  return values;
}

}  // namespace

absl::StatusOr<std::size_t> CountRows(const BulkRows& rows, std::int64_t max_rows,
                                      const FieldPath& path) {
  if (!v1::Scalar_IsValid(rows.scalar)) {
    return path.Field("scalar").Error(
        absl::StrCat("is ", static_cast<int>(rows.scalar), ", must be SCALAR_F32 or SCALAR_F64"));
  }
  const bool single = rows.scalar == v1::SCALAR_F32;
  const std::size_t row_bytes = rows.width * (single ? sizeof(float) : sizeof(double));
  if (rows.data.size() % row_bytes != 0) {
    const bool is_unsaid = rows.scalar == v1::SCALAR_UNSPECIFIED;
    return path.Field("data").Error(absl::StrCat(
        "has ", rows.data.size(), " bytes, must be a multiple of ", row_bytes, " (", rows.width,
        single ? " F32" : " F64", " a row", is_unsaid ? ", since scalar is not given" : "", ")"));
  }
  const std::size_t count = rows.data.size() / row_bytes;
  if (static_cast<std::int64_t>(count) > max_rows) {
    return path.Field("data").Error(
        absl::StrCat("has ", count, " rows, must have at most ", max_rows));
  }
  return count;
}

absl::StatusOr<Vector3> VectorFromProto(const v1::Vector3& vector, const FieldPath& path) {
  const Vector3 value(vector.x(), vector.y(), vector.z());
  for (int i = 0; i < 3; ++i) {
    if (auto status = CheckCoordinate(value[i], path.Field(kPointNames[i])); !status.ok()) {
      return status;
    }
  }
  return value;
}

v1::Vector3 VectorToProto(const Vector3& vector) {
  v1::Vector3 proto;
  proto.set_x(vector.x());
  proto.set_y(vector.y());
  proto.set_z(vector.z());
  return proto;
}

absl::StatusOr<Pose> PoseFromProto(const v1::Pose& pose, const FieldPath& path) {
  const Row<7> row = {pose.tx_m(), pose.ty_m(), pose.tz_m(), pose.qx(),
                      pose.qy(),   pose.qz(),   pose.qw()};
  Pose X_AB;
  if (auto fault = Parse(row, X_AB)) {
    return path.Field(fault->component).Error(fault->description);
  }
  return X_AB;
}

v1::Pose PoseToProto(const Pose& pose) {
  Quaternion rotation(pose.linear());
  rotation.normalize();
  if (rotation.w() < 0) rotation.coeffs() = -rotation.coeffs();
  v1::Pose proto;
  proto.set_tx_m(pose.translation().x());
  proto.set_ty_m(pose.translation().y());
  proto.set_tz_m(pose.translation().z());
  proto.set_qx(rotation.x());
  proto.set_qy(rotation.y());
  proto.set_qz(rotation.z());
  proto.set_qw(rotation.w());
  return proto;
}

absl::StatusOr<std::vector<Pose>> PosesFromProto(const v1::PoseRows& rows, std::int64_t max_rows,
                                                 const FieldPath& path) {
  return FromRows<7, Pose>(rows, max_rows, path);
}

absl::StatusOr<std::vector<Pose>> PointPosesFromProto(const v1::Subject::Points& points,
                                                      std::int64_t max_rows,
                                                      const FieldPath& path) {
  return FromRows<3, Pose>(points, max_rows, path);
}

absl::StatusOr<std::vector<Vector3>> PointsFromProto(const v1::Subject::Points& points,
                                                     std::int64_t max_rows, const FieldPath& path) {
  return FromRows<3, Vector3>(points, max_rows, path);
}

absl::StatusOr<std::vector<collision::RayRow>> RaysFromProto(const v1::RayRows& rays,
                                                             std::int64_t max_rows,
                                                             const FieldPath& path) {
  return FromRows<6, collision::RayRow>(rays, max_rows, path);
}

}  // namespace cwm::server
