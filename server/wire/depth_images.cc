#include "server/wire/depth_images.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/wire/numbers.h"

namespace cwm::server {
namespace {

static_assert(std::endian::native == std::endian::little, "depths are read as they lie");

// derived: 170 and 2 degrees of view over an edge of one.
constexpr double kMinFocal_edges = 0.04, kMaxFocal_edges = 30;
// chosen: a small image may be a part of a large one, whose focal length it keeps.
constexpr double kMaxCroppedFocal_px = 10'000;
// chosen: units from a micrometre to a metre.
constexpr double kMinUnit_m = 1e-6, kMaxUnit_m = 1;

absl::Status CheckFocal(double focal_px, int edge_px, const FieldPath& path) {
  const double min_px = kMinFocal_edges * edge_px;
  const double max_px = std::max(kMaxCroppedFocal_px, kMaxFocal_edges * edge_px);
  if (focal_px >= min_px && focal_px <= max_px) return absl::OkStatus();
  return path.Error(absl::StrCat("is ", focal_px, ", must be from ", min_px, " to ", max_px,
                                 " for an edge of ", edge_px, " pixels"));
}

absl::Status CheckCentre(double centre_px, int edge_px, const FieldPath& path) {
  if (centre_px >= -edge_px && centre_px <= 2 * edge_px) return absl::OkStatus();
  return path.Error(absl::StrCat("is ", centre_px, ", must be from ", -edge_px, " to ", 2 * edge_px,
                                 " for an edge of ", edge_px, " pixels"));
}

// Depths as numbers of the sender; `is_return` tells which of them are measured.
template <class Number, class IsReturn>
void Read(std::string_view bytes, const DepthPlan& plan, const IsReturn& is_return,
          std::vector<float>& depth_m) {
  const auto unit_m = static_cast<float>(plan.unit_m);
  const float least_m = plan.camera.least_range_m;
  const float greatest_m = plan.camera.greatest_range_m;
  for (std::size_t i = 0; i < depth_m.size(); ++i) {
    Number number;
    std::memcpy(&number, bytes.data() + i * sizeof(Number), sizeof(Number));
    const float depth = unit_m * static_cast<float>(number);
    // NaN is outside every range. No branches: the compiler vectorises the loop.
    const int is_valid = static_cast<int>(is_return(number)) & static_cast<int>(depth >= least_m) &
                         static_cast<int>(depth <= greatest_m);
    depth_m[i] = is_valid != 0 ? depth : 0.0F;
  }
}

}  // namespace

absl::StatusOr<perception::Pinhole> PinholeFromProto(const v1::Pinhole& pinhole, int width_px,
                                                     int height_px, const FieldPath& path) {
  const absl::Status checks[] = {CheckFocal(pinhole.fx_px(), width_px, path.Field("fx_px")),
                                 CheckFocal(pinhole.fy_px(), height_px, path.Field("fy_px")),
                                 CheckCentre(pinhole.cx_px(), width_px, path.Field("cx_px")),
                                 CheckCentre(pinhole.cy_px(), height_px, path.Field("cy_px"))};
  for (const absl::Status& check : checks) {
    if (!check.ok()) return check;
  }
  return perception::Pinhole{.focal_u_px = pinhole.fx_px(),
                             .focal_v_px = pinhole.fy_px(),
                             .center_u_px = pinhole.cx_px(),
                             .center_v_px = pinhole.cy_px()};
}

absl::StatusOr<DepthPlan> DepthPlanFromProto(const v1::DepthLayout& layout, const FieldPath& path) {
  DepthPlan plan;
  switch (layout.type()) {
    case v1::DEPTH_TYPE_U16:
      break;
    case v1::DEPTH_TYPE_F32:
      plan.is_float = true;
      break;
    default:
      return path.Field("type").Error(absl::StrCat("is ", static_cast<int>(layout.type()),
                                                   ", must be DEPTH_TYPE_U16 or DEPTH_TYPE_F32"));
  }
  for (const auto& [edge, field] :
       {std::pair{layout.width(), "width"}, std::pair{layout.height(), "height"}}) {
    const absl::Status valid = CheckRange(edge, {1, kMaxImageEdge_px}, path.Field(field));
    if (!valid.ok()) return valid;
  }
  plan.unit_m = layout.unit_m() == 0 ? (plan.is_float ? 1 : 0.001) : layout.unit_m();
  if (!(plan.unit_m >= kMinUnit_m && plan.unit_m <= kMaxUnit_m)) {
    return path.Field("unit_m").Error(absl::StrCat("is ", layout.unit_m(), ", must be from ",
                                                   kMinUnit_m, " to ", kMaxUnit_m,
                                                   " metres, or 0 for the default"));
  }
  auto pinhole =
      PinholeFromProto(layout.pinhole(), layout.width(), layout.height(), path.Field("pinhole"));
  if (!pinhole.ok()) return pinhole.status();
  plan.camera = {.pinhole = *pinhole,
                 .width = layout.width(),
                 .height = layout.height(),
                 .least_range_m = std::numeric_limits<float>::min(),
                 .greatest_range_m = std::numeric_limits<float>::max()};
  return plan;
}

absl::StatusOr<std::shared_ptr<const perception::DepthImage>> DecodeDepth(const DepthPlan& plan,
                                                                          std::string_view bytes,
                                                                          const FieldPath& path) {
  if (static_cast<std::int64_t>(bytes.size()) != plan.byte_count()) {
    return path.Error(absl::StrCat("has ", bytes.size(), " bytes, must have ", plan.byte_count(),
                                   " (", plan.camera.width, " x ", plan.camera.height, " x ",
                                   plan.is_float ? 4 : 2, ")"));
  }
  auto image = std::make_shared<perception::DepthImage>();
  image->width = plan.camera.width;
  image->height = plan.camera.height;
  image->depth_m.resize(plan.camera.pixel_count());
  if (plan.is_float) {
    Read<float>(
        bytes, plan, [](float depth) { return depth > 0; }, image->depth_m);
  } else {
    constexpr std::uint16_t kNoReturn = std::numeric_limits<std::uint16_t>::max();
    Read<std::uint16_t>(
        bytes, plan, [](std::uint16_t depth) { return depth != 0 && depth != kNoReturn; },
        image->depth_m);
  }
  return image;
}

perception::PointCloud OrganisedCloud(const perception::DepthImage& image,
                                      const perception::Pinhole& pinhole) {
  perception::PointCloud cloud;
  cloud.width = image.width;
  cloud.height = image.height;
  cloud.points.resize(image.depth_m.size());
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  std::size_t i = 0;
  for (int v = 0; v < image.height; ++v) {
    const auto y = static_cast<float>((v - pinhole.center_v_px) / pinhole.focal_v_px);
    for (int u = 0; u < image.width; ++u, ++i) {
      const auto x = static_cast<float>((u - pinhole.center_u_px) / pinhole.focal_u_px);
      const float depth_m = image.depth_m[i];
      cloud.points[i] = depth_m > 0 ? Eigen::Vector3f(x * depth_m, y * depth_m, depth_m)
                                    : Eigen::Vector3f::Constant(kNaN);
    }
  }
  return cloud;
}

}  // namespace cwm::server
