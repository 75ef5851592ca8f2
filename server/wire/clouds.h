// Clouds in messages: a header that is checked before any data, bytes in the sensor's layout, and
// the reply.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "cwm/v1/perception.pb.h"
#include "perception/cloud/point_cloud.h"
#include "server/core/geometry_store.h"
#include "server/core/ingest.h"
#include "server/core/limits.h"
#include "server/wire/depth_images.h"
#include "server/wire/field_path.h"

namespace cwm::server {

// Coordinates are stored relative to the viewpoint, in single precision. Up to this distance from
// it the spacing is at most 0.25 mm, below the noise of every sensor at a hundredth of the
// distance. F64 coordinates beyond are refused rather than rounded: a map's offset belongs into
// x_world_sensor, which stays in double precision.
inline constexpr double kMaxPointDistance_m = 4096;

// The place of a number within a point.
struct ScalarField {
  int offset = 0;
  bool is_double = false;  // F64, otherwise F32
};
using VectorField = std::array<ScalarField, 3>;

struct CloudLayout {
  int point_step = 0;
  VectorField xyz;
  std::optional<VectorField> normal;
};

absl::StatusOr<CloudLayout> CloudLayoutFromProto(const v1::CloudLayout& layout,
                                                 const FieldPath& path);
absl::StatusOr<perception::SensorNoise> SensorNoiseFromProto(const v1::SensorModel& model,
                                                             const FieldPath& path);

// The coordinates of points as they are sent, in single precision.
std::vector<Eigen::Vector3f> ReadPoints(const CloudLayout& layout, std::string_view bytes,
                                        std::size_t count);

// A checked header.
struct CloudPlan {
  std::string world;
  std::string world_uid;  // must match unless empty
  CloudLayout layout;
  std::optional<DepthPlan> depth = {};  // the bytes are a depth image in place of points
  std::int64_t point_count = 0;
  std::int64_t total_bytes = 0;
  double scale = 1;  // metres per unit of the coordinates
  std::optional<Vector3> viewpoint_C = {};
  IngestRequest request;  // all but the points, their viewpoint and the write's digest
  std::optional<std::chrono::nanoseconds> time_budget;
  bool want_point_labels = false;
};

// Checks the header before any data. Refuses what exceeds the limits or is inconsistent (count,
// step, total, width and height).
absl::StatusOr<CloudPlan> CloudPlanFromProto(const v1::IngestCloudHeader& header,
                                             const Limits& limits, const FieldPath& path);

struct DecodedCloud {
  perception::PointCloud cloud;  // metres, relative to the viewpoint
  Vector3 viewpoint_C = Vector3::Zero();
};

// Precondition: bytes.size() == plan.total_bytes. Non-finite coordinates are kept (no return), but
// at least one point must be finite ("chunk.data"). InvalidArgument with the field "point 17.x" for
// an F64 coordinate beyond kMaxPointDistance_m and for any beyond kMaxCoordinate_m.
// Points of the world's frame without a viewpoint were seen from unknown places; the viewpoint is
// then kUnknownHeight_m above their mean, as if seen by a sensor that looks down at a table.
absl::StatusOr<DecodedCloud> DecodeCloud(const CloudPlan& plan, std::string_view bytes);
inline constexpr double kUnknownHeight_m = 1.5;

struct IngestReply {
  const IngestOutcome& outcome;
  const World& world;
  bool want_point_labels = false;
};
// Labels larger than limits.max_inline_bytes are put into the store and named by their hash.
absl::Status IngestReplyToProto(const IngestReply& reply, const Limits& limits,
                                GeometryStore& store, v1::IngestCloudResponse* response);

}  // namespace cwm::server
