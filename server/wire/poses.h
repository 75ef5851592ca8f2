// Converts vectors and rigid transforms, single and in bulk rows.
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "collision/geometry/pose.h"
#include "collision/query/query.h"
#include "cwm/v1/geometry.pb.h"
#include "cwm/v1/query.pb.h"
#include "server/wire/field_path.h"

namespace cwm::server {

// chosen: the largest deviation of a quaternion from unit length; it is normalised. Wide enough for
// single precision and for six printed digits, narrow enough to detect a wrong order or a missing
// component.
inline constexpr double kQuaternionTolerance = 1e-3;

// Bulk rows of `width` numbers, from any message with `scalar` and `data`.
struct BulkRows {
  v1::Scalar scalar;
  const std::string& data;
  std::size_t width;  // not 0
};
// Returns the number of rows. Refuses unknown scalars, incomplete rows and more than `max_rows`.
absl::StatusOr<std::size_t> CountRows(const BulkRows& rows, std::int64_t max_rows,
                                      const FieldPath& path);

absl::StatusOr<Vector3> VectorFromProto(const v1::Vector3& vector, const FieldPath& path);
v1::Vector3 VectorToProto(const Vector3& vector);

absl::StatusOr<Pose> PoseFromProto(const v1::Pose& pose, const FieldPath& path);
v1::Pose PoseToProto(const Pose& pose);  // w >= 0

// An invalid row refuses the batch: "<path>.data row 17: qx..qw has length 0.9, must be 1 within
// 1e-3". At most `max_rows`.
absl::StatusOr<std::vector<Pose>> PosesFromProto(const v1::PoseRows& rows, std::int64_t max_rows,
                                                 const FieldPath& path);
// Points as poses with identity rotation.
absl::StatusOr<std::vector<Pose>> PointPosesFromProto(const v1::Subject::Points& points,
                                                      std::int64_t max_rows, const FieldPath& path);
absl::StatusOr<std::vector<Vector3>> PointsFromProto(const v1::Subject::Points& points,
                                                     std::int64_t max_rows, const FieldPath& path);
// Directions of any positive length; they are normalised.
absl::StatusOr<std::vector<collision::RayRow>> RaysFromProto(const v1::RayRows& rays,
                                                             std::int64_t max_rows,
                                                             const FieldPath& path);

}  // namespace cwm::server
