// The points of an uploaded cloud: DecodeCloud of clouds.h.
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "absl/strings/str_cat.h"
#include "collision/geometry/validation.h"
#include "server/wire/clouds.h"

namespace cwm::server {
namespace {

static_assert(std::endian::native == std::endian::little, "cloud bytes are read as they lie");

constexpr std::array<std::string_view, 3> kAxisNames = {"x", "y", "z"};

double ReadScalar(const char* point, const ScalarField& field) {
  if (field.is_double) {
    double value;
    std::memcpy(&value, point + field.offset, sizeof(value));
    return value;
  }
  float value;
  std::memcpy(&value, point + field.offset, sizeof(value));
  return value;
}

// True if the three fields are consecutive F32, which are copied as they are.
bool IsPacked(const VectorField& field) {
  for (int axis = 0; axis < 3; ++axis) {
    const int expected = field[0].offset + axis * static_cast<int>(sizeof(float));
    if (field[axis].is_double || field[axis].offset != expected) return false;
  }
  return true;
}

void ReadPacked(std::string_view bytes, int step, int offset, std::vector<Eigen::Vector3f>& out) {
  for (std::size_t i = 0; i < out.size(); ++i) {
    std::memcpy(out[i].data(), bytes.data() + i * step + offset, 3 * sizeof(float));
  }
}

void ReadVectors(std::string_view bytes, int step, const VectorField& field,
                 std::vector<Eigen::Vector3f>& out) {
  if (IsPacked(field)) return ReadPacked(bytes, step, field[0].offset, out);
  for (std::size_t i = 0; i < out.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      out[i][axis] = static_cast<float>(ReadScalar(bytes.data() + i * step, field[axis]));
    }
  }
}

// From the sender's coordinates to metres relative to the viewpoint.
struct Placing {
  double scale = 1;
  Vector3 viewpoint_C = Vector3::Zero();

  bool is_identity() const { return scale == 1 && viewpoint_C.isZero(0); }
};

Vector3 ReadPoint(const CloudPlan& plan, std::string_view bytes, std::int64_t i) {
  const char* point = bytes.data() + i * plan.layout.point_step;
  return {ReadScalar(point, plan.layout.xyz[0]), ReadScalar(point, plan.layout.xyz[1]),
          ReadScalar(point, plan.layout.xyz[2])};
}

// Sums up to kMeanSamples points, evenly spread.
Vector3 MeanOfFinite(const CloudPlan& plan, std::string_view bytes) {
  constexpr std::int64_t kMeanSamples = 100'000;
  const std::int64_t stride = 1 + plan.point_count / kMeanSamples;
  Vector3 sum = Vector3::Zero();
  double count = 0;
  for (std::int64_t i = 0; i < plan.point_count; i += stride) {
    const Vector3 p = ReadPoint(plan, bytes, i);
    if (!p.allFinite() || p.isZero(0)) continue;
    sum += p;
    ++count;
  }
  return count > 0 ? Vector3(sum / count) : sum;
}

Placing PlacingOf(const CloudPlan& plan, std::string_view bytes) {
  Placing placing{.scale = plan.scale};
  if (plan.viewpoint_C) {
    placing.viewpoint_C = *plan.viewpoint_C;
  } else if (plan.request.in_world_frame) {
    placing.viewpoint_C = plan.scale * MeanOfFinite(plan, bytes);
    placing.viewpoint_C.z() += kUnknownHeight_m;
  }
  return placing;
}

// derived: a no-return at the viewpoint that was turned into another frame in single precision.
constexpr double kAtViewpoint_m = 1e-5;

// Drivers give (0, 0, 0) where nothing returned, and other programs turn it into other frames.
void Place(const CloudPlan& plan, std::string_view bytes, const Placing& placing,
           std::vector<Eigen::Vector3f>& points) {
  for (std::int64_t i = 0; i < plan.point_count; ++i) {
    const Vector3 sent = ReadPoint(plan, bytes, i);
    const Vector3 p = placing.scale * sent - placing.viewpoint_C;
    const bool no_return = sent.isZero(0) || p.cwiseAbs().maxCoeff() < kAtViewpoint_m;
    points[static_cast<std::size_t>(i)] =
        no_return ? Eigen::Vector3f::Zero().eval() : p.cast<float>().eval();
  }
}

absl::Status CheckPrecision(const CloudPlan& plan, std::string_view bytes, const Placing& placing) {
  for (int axis = 0; axis < 3; ++axis) {
    const ScalarField& field = plan.layout.xyz[axis];
    if (!field.is_double) continue;
    for (std::int64_t i = 0; i < plan.point_count; ++i) {
      const double value = ReadScalar(bytes.data() + i * plan.layout.point_step, field);
      const double distance_m = std::abs(value * placing.scale - placing.viewpoint_C[axis]);
      if (!std::isfinite(value) || distance_m <= kMaxPointDistance_m) continue;
      const std::string name = absl::StrCat("point ", i, ".", std::string(kAxisNames[axis]));
      return FieldPath::OfRequest(name).Error(
          absl::StrCat("is ", value, ", must be within ", kMaxPointDistance_m,
                       " m of the viewpoint: coordinates are metres; for millimetres give a scale "
                       "of 0.001, for a map's offset the viewpoint or x_world_sensor"));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckPoints(const std::vector<Eigen::Vector3f>& points) {
  bool any_finite = false;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f& point = points[i];
    if (!point.allFinite()) continue;
    any_finite = true;
    Eigen::Index axis = 0;
    if (point.cwiseAbs().maxCoeff(&axis) <= kMaxCoordinate_m) continue;
    const std::string name = absl::StrCat("point ", i, ".", std::string(kAxisNames[axis]));
    return FieldPath::OfRequest(name).Error(
        absl::StrCat("is ", point[axis], ", must be within ", kMaxCoordinate_m));
  }
  if (any_finite) return absl::OkStatus();
  const FieldPath root;
  const FieldPath chunk = root.Field("chunk");
  return chunk.Field("data").Error(
      absl::StrCat("holds ", points.size(), " points, none of them finite, must hold one"));
}

absl::StatusOr<DecodedCloud> DecodeDepthCloud(const DepthPlan& plan, std::string_view bytes) {
  const FieldPath root;
  const FieldPath chunk = root.Field("chunk");
  const auto image = DecodeDepth(plan, bytes, chunk.Field("data"));
  if (!image.ok()) return image.status();
  DecodedCloud decoded{.cloud = OrganisedCloud(**image, plan.camera.pinhole)};
  if (auto status = CheckPoints(decoded.cloud.points); !status.ok()) return status;
  return decoded;
}

}  // namespace

std::vector<Eigen::Vector3f> ReadPoints(const CloudLayout& layout, std::string_view bytes,
                                        std::size_t count) {
  std::vector<Eigen::Vector3f> points(count);
  ReadVectors(bytes, layout.point_step, layout.xyz, points);
  return points;
}

absl::StatusOr<DecodedCloud> DecodeCloud(const CloudPlan& plan, std::string_view bytes) {
  if (plan.depth.has_value()) return DecodeDepthCloud(*plan.depth, bytes);
  const Placing placing = PlacingOf(plan, bytes);
  if (auto status = CheckPrecision(plan, bytes, placing); !status.ok()) return status;
  DecodedCloud decoded{.cloud = {}, .viewpoint_C = placing.viewpoint_C};
  perception::PointCloud& cloud = decoded.cloud;
  cloud.width = plan.request.cloud.width;
  cloud.height = plan.request.cloud.height;
  cloud.seen_from_origin = plan.request.cloud.seen_from_origin;
  cloud.points.resize(plan.point_count);
  if (placing.is_identity()) {
    ReadVectors(bytes, plan.layout.point_step, plan.layout.xyz, cloud.points);
  } else {
    Place(plan, bytes, placing, cloud.points);
  }
  if (auto status = CheckPoints(cloud.points); !status.ok()) return status;
  if (plan.layout.normal.has_value()) {
    cloud.normals.resize(plan.point_count);
    ReadVectors(bytes, plan.layout.point_step, *plan.layout.normal, cloud.normals);
  }
  return decoded;
}

}  // namespace cwm::server
