#include "server/wire/clouds.h"

#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/geometry/validation.h"
#include "server/wire/numbers.h"
#include "server/wire/objects.h"
#include "server/wire/poses.h"
#include "server/wire/times.h"

namespace cwm::server {
namespace {

// chosen: drivers pad points to 16, 32 or 48 bytes; LiDARs with many channels stay below 256.
constexpr int kMaxPointBytes = 1'024;
constexpr int kMaxFields = 256;
// chosen: no range sensor has a constant sigma above a metre.
constexpr double kMaxSigma_m = 1;
constexpr double kMaxQuadratic_per_m = 1;  // a metre at a metre
// chosen: units from a nanometre to a thousand kilometres.
constexpr double kMinScale = 1e-9, kMaxScale = 1e6;
constexpr std::array<std::string_view, 3> kCoordinates = {"x", "y", "z"};
constexpr std::array<std::string_view, 3> kNormals = {"normal_x", "normal_y", "normal_z"};

int SizeOf(v1::FieldType type) {
  switch (type) {
    case v1::FIELD_TYPE_U8:
    case v1::FIELD_TYPE_I8:
      return 1;
    case v1::FIELD_TYPE_U16:
    case v1::FIELD_TYPE_I16:
      return 2;
    case v1::FIELD_TYPE_F32:
    case v1::FIELD_TYPE_U32:
    case v1::FIELD_TYPE_I32:
      return 4;
    case v1::FIELD_TYPE_F64:
      return 8;
    default:
      return 0;
  }
}

absl::Status CheckField(const v1::CloudField& field, int point_step, const FieldPath& path) {
  const int size = SizeOf(field.type());
  if (size == 0) {
    return path.Field("type").Error(
        absl::StrCat("is ", static_cast<int>(field.type()), ", must be a known FieldType"));
  }
  return CheckRange(field.offset(), {0, point_step - size}, path.Field("offset"));
}

// The three fields with these names; empty if none is present. An error if some are missing,
// repeated or not floating point.
absl::StatusOr<std::optional<VectorField>> FindVector(const v1::CloudLayout& layout,
                                                      const std::array<std::string_view, 3>& names,
                                                      const FieldPath& path) {
  std::array<std::optional<ScalarField>, 3> found;
  for (int i = 0; i < layout.fields_size(); ++i) {
    const v1::CloudField& field = layout.fields(i);
    for (int axis = 0; axis < 3; ++axis) {
      if (field.name() != names[axis]) continue;
      const FieldPath field_path = path.Item("fields", i);
      if (found[axis].has_value()) {
        return field_path.Field("name").Error(
            absl::StrCat("is ", field.name(), ", must occur once"));
      }
      if (field.type() != v1::FIELD_TYPE_F32 && field.type() != v1::FIELD_TYPE_F64) {
        return field_path.Field("type").Error(
            absl::StrCat("is ", v1::FieldType_Name(field.type()), " for ", field.name(),
                         ", must be FIELD_TYPE_F32 or FIELD_TYPE_F64"));
      }
      found[axis] = ScalarField{field.offset(), field.type() == v1::FIELD_TYPE_F64};
    }
  }
  if (!found[0] || !found[1] || !found[2]) return std::nullopt;
  return VectorField{*found[0], *found[1], *found[2]};
}

absl::Status CheckCounts(const v1::IngestCloudHeader& header, const Limits& limits,
                         const FieldPath& path) {
  auto status =
      CheckRange(header.point_count(), {1, limits.max_cloud_points}, path.Field("point_count"));
  if (!status.ok()) return status;
  const std::int64_t expected = header.point_count() * header.layout().point_step();
  if (header.total_bytes() != expected) {
    return path.Field("total_bytes")
        .Error(absl::StrCat("is ", header.total_bytes(), ", must be ", expected,
                            " (point_count * point_step)"));
  }
  if (header.width() < 0 || header.height() < 0) {
    return path.Field(header.width() < 0 ? "width" : "height").Error("is negative, must not be");
  }
  const std::int64_t pixels = static_cast<std::int64_t>(header.width()) * header.height();
  if (header.height() > 1 && pixels != header.point_count()) {
    return path.Field("height").Error(
        absl::StrCat("is ", header.height(), " at a width of ", header.width(),
                     ", their product must be point_count (", header.point_count(), ")"));
  }
  return absl::OkStatus();
}

absl::StatusOr<perception::SensorNoise> QuadraticNoise(const v1::SensorModel& model,
                                                       const FieldPath& path) {
  if (!(model.sigma_m() >= 0 && model.sigma_m() <= kMaxSigma_m)) {
    return path.Field("sigma_m").Error(
        absl::StrCat("is ", model.sigma_m(), ", must be from 0 to ", kMaxSigma_m));
  }
  const double quadratic_per_m = model.quadratic_per_m();
  if (!(quadratic_per_m >= 0 && quadratic_per_m <= kMaxQuadratic_per_m) ||
      (quadratic_per_m == 0 && model.sigma_m() == 0)) {
    return path.Field("quadratic_per_m")
        .Error(absl::StrCat("is ", quadratic_per_m, " with sigma_m ", model.sigma_m(),
                            ", must be from 0 to ", kMaxQuadratic_per_m, ", not both 0"));
  }
  return perception::SensorNoise{.model = perception::SensorModel::kGiven,
                                 .given_sigma_m = model.sigma_m(),
                                 .given_quadratic_per_m = quadratic_per_m};
}

void SetModeler(const v1::IngestOptions& options, perception::ModelerOptions& modeler) {
  if (options.has_search_planes()) modeler.search_planes = options.search_planes();
  if (options.has_search_cylinders()) modeler.search_cylinders = options.search_cylinders();
  if (options.has_search_spheres()) modeler.search_spheres = options.search_spheres();
  if (options.has_search_cones()) modeler.search_cones = options.search_cones();
}

absl::StatusOr<perception::Clustering> ClusteringFromProto(v1::Clustering clustering,
                                                           const FieldPath& path) {
  switch (clustering) {
    case v1::CLUSTERING_UNSPECIFIED:
    case v1::CLUSTERING_OBJECTS:
      return perception::Clustering::kObjects;
    case v1::CLUSTERING_NONE:
      return perception::Clustering::kNone;
    default:
      return path.Error(
          absl::StrCat("is ", static_cast<int>(clustering), ", must be a known Clustering"));
  }
}

absl::StatusOr<perception::InterpretOptions> InterpretOptionsFromProto(
    const v1::IngestCloudHeader& header, const FieldPath& path) {
  perception::InterpretOptions options;
  auto noise = SensorNoiseFromProto(header.sensor_model(), path.Field("sensor_model"));
  if (!noise.ok()) return noise.status();
  options.noise = *noise;
  SetModeler(header.options(), options.modeler);
  const FieldPath options_path = path.Field("options");
  const auto clustering =
      ClusteringFromProto(header.options().clustering(), options_path.Field("clustering"));
  if (!clustering.ok()) return clustering.status();
  options.clustering = *clustering;
  if (header.has_x_world_sensor()) {
    auto X_WC = PoseFromProto(header.x_world_sensor(), path.Field("x_world_sensor"));
    if (!X_WC.ok()) return X_WC.status();
    options.X_WC = *X_WC;
  }
  if (header.has_up()) {
    auto up_C = VectorFromProto(header.up(), path.Field("up"));
    if (!up_C.ok()) return up_C.status();
    if (!(up_C->stableNorm() > 0)) {
      return path.Field("up").Error("has length 0, must have a positive length");
    }
    options.up_C = *up_C;
  }
  return options;
}

absl::StatusOr<IngestMode> IngestModeFromProto(v1::IngestMode mode, const FieldPath& path) {
  switch (mode) {
    case v1::INGEST_MODE_UNSPECIFIED:
    case v1::INGEST_MODE_UPDATE:
      return IngestMode::kUpdate;
    case v1::INGEST_MODE_ADD:
      return IngestMode::kAdd;
    case v1::INGEST_MODE_SEGMENT_ONLY:
      return IngestMode::kSegmentOnly;
    default:
      return path.Error(
          absl::StrCat("is ", static_cast<int>(mode), ", must be a known IngestMode"));
  }
}

absl::Status TakeFrame(const v1::IngestCloudHeader& header, const FieldPath& path,
                       IngestRequest& request) {
  switch (header.frame()) {
    case v1::CLOUD_FRAME_UNSPECIFIED:
    case v1::CLOUD_FRAME_SENSOR:
      return absl::OkStatus();
    case v1::CLOUD_FRAME_WORLD:
      break;
    default:
      return path.Field("frame").Error(
          absl::StrCat("is ", static_cast<int>(header.frame()), ", must be a known CloudFrame"));
  }
  for (const auto& [is_set, field] : {std::pair{header.has_x_world_sensor(), "x_world_sensor"},
                                      std::pair{header.has_up(), "up"}}) {
    if (!is_set) continue;
    return path.Field(field).Error(
        "is set, must be absent with CLOUD_FRAME_WORLD: the points' frame is the world's, z is up");
  }
  request.in_world_frame = true;
  request.options.X_WC = Pose::Identity();
  request.cloud.seen_from_origin = header.has_viewpoint();
  return absl::OkStatus();
}

// Sets the scale and the viewpoint.
absl::Status TakePlacing(const v1::IngestCloudHeader& header, const FieldPath& path,
                         CloudPlan& plan) {
  plan.scale = header.scale() == 0 ? 1 : header.scale();
  if (!(plan.scale >= kMinScale && plan.scale <= kMaxScale)) {
    return path.Field("scale").Error(absl::StrCat("is ", header.scale(), ", must be from ",
                                                  kMinScale, " to ", kMaxScale,
                                                  " metres per unit, or 0 for 1"));
  }
  if (!header.has_viewpoint()) return absl::OkStatus();
  auto viewpoint = VectorFromProto(header.viewpoint(), path.Field("viewpoint"));
  if (!viewpoint.ok()) return viewpoint.status();
  plan.viewpoint_C = *viewpoint;
  return absl::OkStatus();
}

absl::StatusOr<IngestRequest> IngestRequestFromProto(const v1::IngestCloudHeader& header,
                                                     const FieldPath& path) {
  constexpr std::int64_t kMaxIdBytes = 128;
  IngestRequest request;
  auto status = CheckPrintable(header.sensor(), kMaxIdBytes, path.Field("sensor"));
  if (!status.ok()) return status;
  status = CheckTextLength(header.request_id(), kMaxIdBytes, path.Field("request_id"));
  if (!status.ok()) return status;
  request.sensor = header.sensor();
  request.write.request_id = header.request_id();
  if (header.has_expected_revision()) {
    request.write.expected_revision = collision::Revision{header.expected_revision()};
  }
  auto options = InterpretOptionsFromProto(header, path);
  if (!options.ok()) return options.status();
  request.options = *options;
  auto mode = IngestModeFromProto(header.mode(), path.Field("mode"));
  if (!mode.ok()) return mode.status();
  request.mode = *mode;
  request.force = header.force();
  if (auto status = TakeFrame(header, path, request); !status.ok()) return status;
  request.frame_stamp = std::chrono::system_clock::now();
  if (header.has_frame_stamp()) {
    auto stamp = TimePointFromProto(header.frame_stamp(), path.Field("frame_stamp"));
    if (!stamp.ok()) return stamp.status();
    request.frame_stamp = *stamp;
  }
  return request;
}

}  // namespace

absl::StatusOr<CloudLayout> CloudLayoutFromProto(const v1::CloudLayout& layout,
                                                 const FieldPath& path) {
  auto status = CheckRange(layout.point_step(), {1, kMaxPointBytes}, path.Field("point_step"));
  if (!status.ok()) return status;
  if (layout.fields_size() > kMaxFields) {
    return path.Field("fields").Error(
        absl::StrCat("holds ", layout.fields_size(), ", must hold at most ", kMaxFields));
  }
  for (int i = 0; i < layout.fields_size(); ++i) {
    status = CheckField(layout.fields(i), layout.point_step(), path.Item("fields", i));
    if (!status.ok()) return status;
  }
  auto xyz = FindVector(layout, kCoordinates, path);
  if (!xyz.ok()) return xyz.status();
  if (!xyz->has_value()) return path.Field("fields").Error("must hold x, y and z");
  auto normal = FindVector(layout, kNormals, path);
  if (!normal.ok()) return normal.status();
  return CloudLayout{.point_step = layout.point_step(), .xyz = **xyz, .normal = *normal};
}

absl::StatusOr<perception::SensorNoise> SensorNoiseFromProto(const v1::SensorModel& model,
                                                             const FieldPath& path) {
  perception::SensorNoise noise;
  switch (model.kind()) {
    case v1::SensorModel::KIND_UNSPECIFIED:
    case v1::SensorModel::KIND_KINECT:
      noise.model = perception::SensorModel::kKinect;
      return noise;
    case v1::SensorModel::KIND_REALSENSE:
      noise.model = perception::SensorModel::kRealSense;
      return noise;
    case v1::SensorModel::KIND_TIME_OF_FLIGHT:
      noise.model = perception::SensorModel::kTimeOfFlight;
      return noise;
    case v1::SensorModel::KIND_TILTING_LASER:
      noise.model = perception::SensorModel::kTiltingLaser;
      return noise;
    case v1::SensorModel::KIND_CONSTANT:
      break;
    case v1::SensorModel::KIND_QUADRATIC:
      return QuadraticNoise(model, path);
    default:
      return path.Field("kind").Error(absl::StrCat("is ", static_cast<int>(model.kind()),
                                                   ", must be a known SensorModel.Kind"));
  }
  if (!(model.sigma_m() > 0 && model.sigma_m() <= kMaxSigma_m)) {
    return path.Field("sigma_m").Error(
        absl::StrCat("is ", model.sigma_m(), ", must be positive and at most ", kMaxSigma_m));
  }
  noise.model = perception::SensorModel::kGiven;
  noise.given_sigma_m = model.sigma_m();
  return noise;
}

namespace {

absl::Status DescribePoints(const v1::IngestCloudHeader& header, const Limits& limits,
                            const FieldPath& path, CloudPlan& plan) {
  auto layout = CloudLayoutFromProto(header.layout(), path.Field("layout"));
  if (!layout.ok()) return layout.status();
  if (auto status = CheckCounts(header, limits, path); !status.ok()) return status;
  plan.layout = *layout;
  plan.point_count = header.point_count();
  plan.total_bytes = header.total_bytes();
  const bool organised = header.height() > 1;
  plan.request.cloud.width = organised ? header.width() : static_cast<int>(header.point_count());
  plan.request.cloud.height = organised ? header.height() : 1;
  return absl::OkStatus();
}

// The number may be absent, since the image tells it.
absl::Status CheckAgrees(std::int64_t given, std::int64_t of_image, const FieldPath& path) {
  if (given == 0 || given == of_image) return absl::OkStatus();
  return path.Error(
      absl::StrCat("is ", given, ", must be absent or ", of_image, ", as the depth image says"));
}

absl::Status DescribeDepth(const v1::IngestCloudHeader& header, const Limits& limits,
                           const FieldPath& path, CloudPlan& plan) {
  for (const auto& [is_set, field] :
       {std::pair{header.has_layout(), "layout"}, std::pair{header.has_viewpoint(), "viewpoint"},
        std::pair{header.scale() != 0, "scale"},
        std::pair{header.frame() == v1::CLOUD_FRAME_WORLD, "frame"}}) {
    if (is_set) return path.Field(field).Error("is set, must be absent with a depth image");
  }
  auto depth = DepthPlanFromProto(header.depth(), path.Field("depth"));
  if (!depth.ok()) return depth.status();
  const auto pixels = static_cast<std::int64_t>(depth->camera.pixel_count());
  const FieldPath layout = path.Field("depth");
  if (auto status = CheckRange(pixels, {1, limits.max_cloud_points}, layout); !status.ok()) {
    return status;
  }
  const absl::Status checks[] = {
      CheckAgrees(header.width(), depth->camera.width, path.Field("width")),
      CheckAgrees(header.height(), depth->camera.height, path.Field("height")),
      CheckAgrees(header.point_count(), pixels, path.Field("point_count")),
      CheckAgrees(header.total_bytes(), depth->byte_count(), path.Field("total_bytes"))};
  for (const absl::Status& check : checks) {
    if (!check.ok()) return check;
  }
  plan.depth = *depth;
  plan.point_count = pixels;
  plan.total_bytes = depth->byte_count();
  plan.request.cloud.width = depth->camera.width;
  plan.request.cloud.height = depth->camera.height;
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<CloudPlan> CloudPlanFromProto(const v1::IngestCloudHeader& header,
                                             const Limits& limits, const FieldPath& path) {
  CloudPlan plan;
  plan.world = header.world();
  plan.world_uid = header.world_uid();
  plan.want_point_labels = header.want_point_labels();
  const absl::Status described = header.has_depth() ? DescribeDepth(header, limits, path, plan)
                                                    : DescribePoints(header, limits, path, plan);
  if (!described.ok()) return described;
  const perception::PointCloud size = plan.request.cloud;
  auto request = IngestRequestFromProto(header, path);
  if (!request.ok()) return request.status();
  plan.request = *std::move(request);
  plan.request.cloud.width = size.width;
  plan.request.cloud.height = size.height;
  if (auto status = TakePlacing(header, path, plan); !status.ok()) return status;
  if (header.has_time_budget()) {
    auto budget = DurationFromProto(header.time_budget(), path.Field("time_budget"));
    if (!budget.ok()) return budget.status();
    plan.time_budget = *budget;
  }
  return plan;
}

}  // namespace cwm::server
