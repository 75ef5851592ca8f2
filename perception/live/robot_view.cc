#include "perception/live/robot_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "perception/live/robot_claims.h"
#include "perception/live/robot_silhouette.h"

namespace cwm::perception {
namespace {

constexpr auto kRobotClass = static_cast<std::uint8_t>(PixelClass::kRobot);
constexpr auto kCarriedClass = static_cast<std::uint8_t>(PixelClass::kCarried);
constexpr auto kMixedClass = static_cast<std::uint8_t>(PixelClass::kMixed);
constexpr auto kHiddenClass = static_cast<std::uint8_t>(PixelClass::kHidden);

// tuned: within this, a point is the robot's whatever known surface explains it too. Of the pixels
// of things within 30 mm of a moving hand, 7 % are lost at 3 and 3 % at 1.5; at 0, 0.04 % of the
// robot's pixels are left to surfaces that it passes closely, at 1.5 none.
constexpr double kSurelyRobot_sigma = 1.5;
// chosen: fewer pixels of a link may all be wrong for other reasons.
constexpr int kMinThroughPixels = 20;
// tuned: on a Panda whose hand moves at 0.6 m/s, at most 7 rays pass through a link in 2,000 frames
// with states within 5 ms, 0.2 % of those that must meet it. A link that is 20 mm beyond its margin
// lets hundreds pass, half of them.
constexpr double kMaxThroughShare = 0.1;

// The greatest speed of a point in the box, relative to the camera.
double RelativeSpeed_m_s(const Aabb& bounds_L, const Pose& X_WL, const SpatialVelocity& V_WL,
                         const RobotFrame& frame) {
  const Vector3 p_WC = frame.X_WC.translation();
  double speed_m_s = 0;  // a convex function of the point, so it is greatest at a corner
  for (int i = 0; i < 8; ++i) {
    const Vector3 p_W = X_WL * bounds_L.corner(static_cast<Aabb::CornerType>(i));
    const Vector3 of_link =
        V_WL.linear_W_m_s + V_WL.angular_W_rad_s.cross(p_W - X_WL.translation());
    const Vector3 of_camera =
        frame.V_WC.linear_W_m_s + frame.V_WC.angular_W_rad_s.cross(p_W - p_WC);
    speed_m_s = std::max(speed_m_s, (of_link - of_camera).norm());
  }
  return speed_m_s;
}

// The velocity of a body that moves with a link, with its origin at p_W.
SpatialVelocity VelocityAt(const LinkAtStamp& link, const Vector3& p_W) {
  SpatialVelocity V = link.V_WL;
  V.linear_W_m_s += V.angular_W_rad_s.cross(p_W - link.X_WL.translation());
  return V;
}

Aabb Padded(const Aabb& bounds, double margin_m) {
  return {bounds.min().array() - margin_m, bounds.max().array() + margin_m};
}

PixelBounds PaddedBy(const PixelBounds& bounds, int border_px, const DepthCamera& camera) {
  if (bounds.empty()) return {};
  return {.u_begin = std::max(0, bounds.u_begin - border_px),
          .v_begin = std::max(0, bounds.v_begin - border_px),
          .u_end = std::min(camera.width, bounds.u_end + border_px),
          .v_end = std::min(camera.height, bounds.v_end + border_px)};
}

// Cells within which a margin at a depth is seen.
int CellsOf(double margin_m, double depth_m, const DepthCamera& camera) {
  const double focal_px = std::max(camera.pinhole.focal_u_px, camera.pinhole.focal_v_px);
  const double cells = std::ceil(margin_m * focal_px / depth_m / kSilhouetteCell_px);
  return static_cast<int>(std::min(cells, 30000.0));
}

// Tightens the rectangle of the mask to the pixels that have a class.
void FitRectangle(const PixelBounds& within, const DepthCamera& camera, RobotMask& mask) {
  PixelBounds found;
  for (int v = within.v_begin; v < within.v_end; ++v) {
    const std::uint8_t* row = mask.pixels.data() + static_cast<std::size_t>(v) * camera.width;
    const auto* begin = std::find_if(row + within.u_begin, row + within.u_end,
                                     [](std::uint8_t pixel) { return pixel != 0; });
    if (begin == row + within.u_end) continue;
    const std::uint8_t* end = row + within.u_end;
    while (end[-1] == 0) --end;
    found.Extend({.u_begin = static_cast<int>(begin - row),
                  .v_begin = v,
                  .u_end = static_cast<int>(end - row),
                  .v_end = v + 1});
  }
  if (found.empty()) {
    mask = {};
    return;
  }
  mask.u_begin = found.u_begin;
  mask.v_begin = found.v_begin;
  mask.u_end = found.u_end;
  mask.v_end = found.v_end;
}

}  // namespace

struct RobotView::Scratch {
  // The surfaces of carried models; those that are no longer carried are forgotten.
  std::map<std::shared_ptr<const HybridModel>, std::shared_ptr<const LinkSurface>> carried;
  RobotSilhouette silhouette;
  BlockDepths blocks;
  std::vector<BodyInView> bodies;  // carried ones first
  std::size_t carried_count = 0;
  std::vector<BodyId> carried_ids;
  std::vector<float> nearest_m;  // by cell: the robot's depth, rendered or measured

  std::span<const BodyInView> CarriedBodies() const {
    return std::span(bodies).first(carried_count);
  }
  std::span<const BodyInView> LinkBodies() const {
    return std::span(bodies).subspan(carried_count);
  }
  void KeepSurfaces(std::span<const CarriedAtStamp> now);
  void AddBody(const LinkSurface& surface, int link, const LinkAtStamp& pose, bool is_carried,
               const RobotFrame& frame, double late_s, const RobotMargins& margins);
  // Lowers each cell to the measured depths of its classed pixels.
  void AddMeasured(const DepthImage& image, const PixelBounds& bounds,
                   std::span<const std::uint8_t> pixels);
  void ClassOutlines(const ClaimFrame& frame, const PixelBounds& bounds,
                     std::span<std::uint8_t> pixels) const;
  void CountThrough(const ClaimFrame& frame, std::span<const std::uint8_t> pixels,
                    RobotSighting& sighting) const;
  void Widen(const ClaimFrame& frame, const PixelBounds& bounds, RobotMask& mask);
  // Classes as mixed what no known surface explains within the sphere and at its outline.
  RobotMask ReachMask(const ClaimFrame& frame, const Pose& X_WC, const ReachSphere& reach_W);
};

void RobotView::Scratch::KeepSurfaces(std::span<const CarriedAtStamp> now) {
  std::map<std::shared_ptr<const HybridModel>, std::shared_ptr<const LinkSurface>> kept;
  for (const CarriedAtStamp& item : now) {
    std::shared_ptr<const LinkSurface>& surface = kept[item.body->model];
    if (surface != nullptr) continue;
    const auto known = carried.find(item.body->model);
    surface = known != carried.end()
                  ? known->second
                  : std::make_shared<const LinkSurface>(SurfaceOf(*item.body->model));
  }
  carried = std::move(kept);
}

void RobotView::Scratch::AddBody(const LinkSurface& surface, int link, const LinkAtStamp& pose,
                                 bool is_carried, const RobotFrame& frame, double late_s,
                                 const RobotMargins& margins) {
  if (surface.empty()) return;
  const DepthCamera& camera = *frame.camera;
  BodyInView body{.surface = &surface, .link = link, .is_carried = is_carried};
  body.X_CL = frame.X_WC.inverse() * pose.X_WL;
  const Vector3 center_C = body.X_CL * surface.bounds_L().center();
  const double radius_m = 0.5 * surface.bounds_L().diagonal().norm();
  const double farthest_m = std::clamp(center_C.z() + radius_m, camera.least_range_m * 1.0,
                                       camera.greatest_range_m * 1.0);
  const double sigma_m =
      std::hypot(frame.noise.AxialSigma_m(farthest_m), frame.noise.WarpSigma_m());
  const double motion_m = RelativeSpeed_m_s(surface.bounds_L(), pose.X_WL, pose.V_WL, frame) *
                          (margins.clock_s + late_s + 0.5 * margins.exposure_s);
  const double margin_m =
      kGate_sigma * sigma_m + motion_m + (is_carried ? margins.carried_m : margins.calibration_m);
  body.slack_m = static_cast<float>(kSurelyRobot_sigma * sigma_m);
  body.margin_m = static_cast<float>(margin_m);
  body.bounds = ProjectBox(Padded(surface.bounds_L(), margin_m), body.X_CL, camera,
                           RobotSilhouette::kNearPlane_m);
  if (body.bounds.empty()) return;
  const Pose X_LC = body.X_CL.inverse();
  body.R_LC = X_LC.linear().cast<float>();
  body.origin_L = X_LC.translation().cast<float>();
  bodies.push_back(body);
}

void RobotView::Scratch::AddMeasured(const DepthImage& image, const PixelBounds& bounds,
                                     std::span<const std::uint8_t> pixels) {
  for (int v = bounds.v_begin; v < bounds.v_end; ++v) {
    const std::size_t first = static_cast<std::size_t>(v) * image.width;
    float* cells =
        nearest_m.data() + static_cast<std::size_t>(v / kSilhouetteCell_px) * silhouette.columns();
    for (int u = bounds.u_begin; u < bounds.u_end; ++u) {
      if (pixels[first + u] == 0) continue;
      float& cell = cells[u / kSilhouetteCell_px];
      cell = std::min(cell, image.depth_m[first + u]);
    }
  }
}

void RobotView::Scratch::ClassOutlines(const ClaimFrame& frame, const PixelBounds& bounds,
                                       std::span<std::uint8_t> pixels) const {
  // Without known surfaces, there may be one.
  const auto is_behind = [&](std::size_t pixel, float near_m) {
    const float expected_m = frame.expected.At(pixel);
    return frame.expected.depth_m.empty() ||
           (expected_m > near_m && expected_m < RobotSilhouette::kNothing_m);
  };
  for (int v = bounds.v_begin; v < bounds.v_end; ++v) {
    const std::size_t first = static_cast<std::size_t>(v) * frame.camera->width;
    const std::size_t first_cell =
        static_cast<std::size_t>(v / kSilhouetteCell_px) * silhouette.columns();
    for (int u = bounds.u_begin; u < bounds.u_end; ++u) {
      const std::size_t cell = first_cell + static_cast<std::size_t>(u / kSilhouetteCell_px);
      const std::size_t pixel = first + static_cast<std::size_t>(u);
      if (nearest_m[cell] == RobotSilhouette::kNothing_m || pixels[pixel] != 0) continue;
      const float depth_m = frame.image->depth_m[pixel];
      if (depth_m > 0) {
        const bool is_mixed = depth_m > nearest_m[cell] && !frame.IsExpected(pixel, depth_m);
        if (is_mixed) pixels[pixel] = kMixedClass;
      } else if (silhouette.body()[cell] >= 0 && is_behind(pixel, silhouette.near_m()[cell])) {
        pixels[pixel] = kHiddenClass;
      }
    }
  }
}

void RobotView::Scratch::CountThrough(const ClaimFrame& frame, std::span<const std::uint8_t> pixels,
                                      RobotSighting& sighting) const {
  struct Count {
    int through = 0;
    int shown = 0;
  };
  std::vector<Count> counts(bodies.size());
  const std::vector<std::int16_t> to_outline = silhouette.CellsToOutline();
  for (int row = 0; row < silhouette.rows(); ++row) {
    for (int column = 0; column < silhouette.columns(); ++column) {
      const std::size_t cell = static_cast<std::size_t>(row) * silhouette.columns() + column;
      const std::int16_t index = silhouette.body()[cell];
      if (index < 0) continue;
      const BodyInView& body = bodies[static_cast<std::size_t>(index)];
      const float near_m = silhouette.near_m()[cell];
      // A link that is displaced by its margin still covers this cell.
      if (to_outline[cell] <= CellsOf(body.margin_m, near_m, *frame.camera)) continue;
      Count& count = counts[static_cast<std::size_t>(index)];
      for (int i = 0; i < kSilhouetteCell_px * kSilhouetteCell_px; ++i) {
        const int u = column * kSilhouetteCell_px + i % kSilhouetteCell_px;
        const int v = row * kSilhouetteCell_px + i / kSilhouetteCell_px;
        if (u >= frame.camera->width || v >= frame.camera->height) continue;
        const std::size_t pixel = static_cast<std::size_t>(v) * frame.camera->width + u;
        const float depth_m = frame.image->depth_m[pixel];
        if (pixels[pixel] == kRobotClass || pixels[pixel] == kCarriedClass) {
          ++count.shown;
        } else if (depth_m > near_m + body.margin_m) {
          ++count.through;
        }
      }
    }
  }
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (bodies[i].is_carried || counts[i].through == 0) continue;
    const double share =
        static_cast<double>(counts[i].through) / (counts[i].through + counts[i].shown);
    const bool is_wrong = counts[i].through >= kMinThroughPixels && share > kMaxThroughShare;
    const bool was_wrong = sighting.fault == RobotStateFault::kWrong;
    if (is_wrong < was_wrong) continue;  // links that are wrong are told before others
    if (is_wrong == was_wrong && counts[i].through <= sighting.through_pixels) continue;
    if (is_wrong) sighting.fault = RobotStateFault::kWrong;
    sighting.through_link = bodies[i].link;
    sighting.through_pixels = counts[i].through;
    sighting.through_share = share;
  }
}

void RobotView::Scratch::Widen(const ClaimFrame& frame, const PixelBounds& bounds,
                               RobotMask& mask) {
  blocks.Compute(*frame.image, bounds);
  float least_m = RobotSilhouette::kNothing_m;
  for (const BodyInView& body : bodies) {
    const auto wide_m = static_cast<float>(body.margin_m + kWrongState_m);
    const PixelBounds wide = ProjectBox(Padded(body.surface->bounds_L(), wide_m), body.X_CL,
                                        *frame.camera, RobotSilhouette::kNearPlane_m);
    ClaimAsMixed(frame, body, wide_m, wide, mask.pixels);
  }
  for (const float depth_m : nearest_m) least_m = std::min(least_m, depth_m);
  if (least_m == RobotSilhouette::kNothing_m) return;
  DilateNearest(silhouette.columns(),
                std::min(CellsOf(kWrongState_m, least_m, *frame.camera),
                         std::max(silhouette.columns(), silhouette.rows())),
                nearest_m);
}

RobotMask RobotView::Scratch::ReachMask(const ClaimFrame& frame, const Pose& X_WC,
                                        const ReachSphere& reach_W) {
  const DepthCamera& camera = *frame.camera;
  const Eigen::Vector3f center_C = (X_WC.inverse() * reach_W.center).cast<float>();
  const auto radius_m = static_cast<float>(reach_W.radius_m);
  RobotMask mask;
  mask.pixels.assign(camera.pixel_count(), 0);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const std::size_t pixel = static_cast<std::size_t>(v) * camera.width + u;
      const float depth_m = frame.image->depth_m[pixel];
      if (depth_m == 0 || frame.IsExpected(pixel, depth_m)) continue;
      if ((frame.Point(u, v, depth_m) - center_C).norm() <= radius_m) {
        mask.pixels[pixel] = kMixedClass;
      }
    }
  }
  const PixelBounds all{.u_end = camera.width, .v_end = camera.height};
  silhouette.Reset(camera);
  nearest_m = silhouette.near_m();
  AddMeasured(*frame.image, all, mask.pixels);
  DilateNearest(silhouette.columns(), 1, nearest_m);
  ClassOutlines(frame, all, mask.pixels);
  FitRectangle(all, camera, mask);
  return mask;
}

SpatialVelocity VelocityBetween(const Pose& X_WF_before, const Pose& X_WF_after,
                                double duration_s) {
  const Eigen::AngleAxisd turn(Matrix3(X_WF_after.linear() * X_WF_before.linear().transpose()));
  return {.angular_W_rad_s = turn.angle() / duration_s * turn.axis(),
          .linear_W_m_s = (X_WF_after.translation() - X_WF_before.translation()) / duration_s};
}

void MergeMask(const RobotMask& other, const DepthCamera& camera, RobotMask& mask) {
  if (other.empty()) return;
  if (mask.empty()) {
    mask = other;
    return;
  }
  constexpr std::array<std::uint8_t, 4> kOrder = {kRobotClass, kCarriedClass, kMixedClass,
                                                  kHiddenClass};
  for (int v = other.v_begin; v < other.v_end; ++v) {
    for (int u = other.u_begin; u < other.u_end; ++u) {
      const std::size_t pixel = static_cast<std::size_t>(v) * camera.width + u;
      std::uint8_t& of_pixel = mask.pixels[pixel];
      // find() of 0 is past the end, so that a class comes before none.
      const auto rank = [&](std::uint8_t pixel_class) {
        return std::find(kOrder.begin(), kOrder.end(), pixel_class);
      };
      if (rank(other.pixels[pixel]) < rank(of_pixel)) of_pixel = other.pixels[pixel];
    }
  }
  mask.u_begin = std::min(mask.u_begin, other.u_begin);
  mask.v_begin = std::min(mask.v_begin, other.v_begin);
  mask.u_end = std::max(mask.u_end, other.u_end);
  mask.v_end = std::max(mask.v_end, other.v_end);
}

RobotView::RobotView(std::shared_ptr<const RobotSurface> surface)
    : surface_(std::move(surface)), scratch_(std::make_unique<Scratch>()) {}
RobotView::~RobotView() = default;

RobotSighting RobotView::Mask(const RobotFrame& frame, const RobotAtStamp& robot,
                              std::span<const CarriedAtStamp> carried,
                              const RobotMargins& margins) {
  Scratch& scratch = *scratch_;
  const DepthCamera& camera = *frame.camera;
  RobotSighting sighting;
  scratch.bodies.clear();
  scratch.carried_ids.clear();
  for (const CarriedAtStamp& item : carried) scratch.carried_ids.push_back(item.body->id);
  ClaimFrame claims{.camera = &camera,
                    .image = frame.image,
                    .blocks = &scratch.blocks,
                    .tolerance = DepthTolerance(frame.noise, camera.greatest_range_m),
                    .expected = {frame.expected_m, frame.expected_body, scratch.carried_ids}};
  if (robot.source == StateSource::kMissing) {
    sighting.fault = RobotStateFault::kMissing;
    sighting.mask = scratch.ReachMask(claims, frame.X_WC, robot.reach_W);
    return sighting;
  }
  scratch.KeepSurfaces(carried);
  for (const CarriedAtStamp& item : carried) {
    const LinkAtStamp& link = robot.links[static_cast<std::size_t>(item.link)];
    const LinkAtStamp pose{.X_WL = item.body->X_WB,
                           .V_WL = VelocityAt(link, item.body->X_WB.translation())};
    scratch.AddBody(*scratch.carried[item.body->model], item.link, pose, true, frame, robot.late_s,
                    margins);
  }
  scratch.carried_count = scratch.bodies.size();
  for (std::size_t i = 0; i < robot.links.size(); ++i) {
    scratch.AddBody(surface_->links()[i], static_cast<int>(i), robot.links[i], false, frame,
                    robot.late_s, margins);
  }
  if (scratch.bodies.empty()) return sighting;
  PixelBounds bounds;
  for (const BodyInView& body : scratch.bodies) bounds.Extend(body.bounds);
  bounds = PaddedBy(bounds, 2 * kSilhouetteCell_px, camera);

  scratch.blocks.Compute(*frame.image, bounds);
  sighting.mask.pixels.assign(camera.pixel_count(), 0);
  ClaimPixels(claims, scratch.CarriedBodies(), scratch.CarriedBodies(), sighting.mask.pixels);
  ClaimPixels(claims, scratch.LinkBodies(), scratch.CarriedBodies(), sighting.mask.pixels);
  scratch.silhouette.Reset(camera);
  for (std::size_t i = 0; i < scratch.bodies.size(); ++i) {
    scratch.silhouette.Draw(*scratch.bodies[i].surface, scratch.bodies[i].X_CL,
                            static_cast<std::int16_t>(i));
  }
  scratch.CountThrough(claims, sighting.mask.pixels, sighting);
  scratch.nearest_m = scratch.silhouette.near_m();
  scratch.AddMeasured(*frame.image, bounds, sighting.mask.pixels);
  if (sighting.fault == RobotStateFault::kWrong) {
    bounds = {.u_end = camera.width, .v_end = camera.height};
    scratch.Widen(claims, bounds, sighting.mask);
  }
  DilateNearest(scratch.silhouette.columns(), 1, scratch.nearest_m);
  scratch.ClassOutlines(claims, bounds, sighting.mask.pixels);
  FitRectangle(bounds, camera, sighting.mask);
  return sighting;
}

}  // namespace cwm::perception
