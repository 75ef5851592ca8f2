#include "tests/benchmarks/live/panda_sweep.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collision/robot/kinematics.h"
#include "collision/robot/urdf.h"
#include "perception/simulation/look_at.h"
#include "perception/simulation/range_image.h"
#include "tests/collision/robot/panda_files.h"

namespace cwm::benchmarks {
namespace {

using namespace perception;

constexpr double kHandSpeed_m_s = 0.6;
constexpr double kPeriod_s = 8;  // of the trajectory at rate 1
constexpr double kPath_s = 70;   // of the trajectory that things are placed beside
constexpr std::uint64_t kDeviceSeed = 7;

std::vector<LinkGeometry> GeometriesOf(const collision::RobotModel& model) {
  std::vector<LinkGeometry> geometries;
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    for (const collision::CollisionGeometry& collision : model.links[i].collisions) {
      geometries.push_back(
          {.link = static_cast<int>(i), .X_LG = collision.X_LG, .shape = &collision.shape});
    }
  }
  return geometries;
}

}  // namespace

std::optional<PandaSweep> PandaSweep::Read() {
  const auto files = collision::testing::ReadPandaFiles();
  if (!files) return std::nullopt;
  const auto description = collision::ReadUrdf(files->urdf, files->meshes);
  if (!description.ok()) return std::nullopt;
  const auto model = collision::MakeRobotModel(*description, nullptr);
  if (!model.ok()) return std::nullopt;
  PandaSweep sweep;
  sweep.model_ = *model;
  sweep.surface_ = std::make_shared<RobotSurface>(GeometriesOf(**model),
                                                  static_cast<int>((*model)->links.size()));
  for (const char* name : {"panda_link7", "panda_hand", "panda_leftfinger", "panda_rightfinger"}) {
    if (const auto link = sweep.model_->FindLink(name)) sweep.hand_links_.push_back(*link);
  }
  sweep.pinhole_.X_WC = LookAt(Vector3(1.25, 0.75, 0.95), Vector3(0.3, 0, 0.25));
  sweep.camera_ = {.pinhole = {sweep.pinhole_.focal_px, sweep.pinhole_.focal_px,
                               sweep.pinhole_.center_x_px, sweep.pinhole_.center_y_px},
                   .width = sweep.pinhole_.width,
                   .height = sweep.pinhole_.height};
  sweep.device_ = DrawDeviceErrors(sweep.noise_, sweep.pinhole_, kDeviceSeed);
  // The speed at rate 1 gives the rate.
  constexpr int kSamples = 400;
  double squares = 0;
  const auto hand = static_cast<std::size_t>(sweep.hand_links_.back());
  for (int i = 0; i < kSamples; ++i) {
    const double v_m_s = sweep.LinksAt(kPeriod_s * i / kSamples)[hand].V_WL.linear_W_m_s.norm();
    squares += v_m_s * v_m_s / kSamples;
  }
  sweep.rate_ = kHandSpeed_m_s / std::sqrt(squares);
  sweep.hand_speed_m_s_ = kHandSpeed_m_s;
  sweep.PlaceThings();
  sweep.RenderExpected();
  return sweep;
}

std::vector<Pose> PandaSweep::PosesAt(double time_s) const {
  const double phase = 2 * std::numbers::pi * rate_ * time_s / kPeriod_s;
  std::vector<double> q = collision::DefaultVariables(*model_);
  // A sweep about the base, over the table and up again, with the wrist turning.
  const std::vector<double> arm = {0.9 * std::sin(phase),
                                   0.55 + 0.12 * std::sin(2.7 * phase),
                                   0.15 * std::sin(1.7 * phase),
                                   -1.95 + 0.15 * std::cos(2.1 * phase),
                                   0.2 * std::sin(1.3 * phase),
                                   2.5 + 0.1 * std::sin(0.9 * phase),
                                   0.785 + 0.5 * std::sin(0.7 * phase)};
  for (std::size_t i = 0; i < arm.size(); ++i) {
    const auto link = model_->FindJoint("panda_joint" + std::to_string(i + 1));
    if (link) q[static_cast<std::size_t>(model_->links[*link].variable)] = arm[i];
  }
  std::vector<Pose> X_WL(model_->links.size());
  collision::LinkPoses(*model_, Pose::Identity(), q, X_WL);
  return X_WL;
}

std::vector<LinkAtStamp> PandaSweep::LinksAt(double time_s) const {
  constexpr double kStep_s = 1e-3;
  const std::vector<Pose> now = PosesAt(time_s);
  const std::vector<Pose> before = PosesAt(time_s - 0.5 * kStep_s);
  const std::vector<Pose> after = PosesAt(time_s + 0.5 * kStep_s);
  std::vector<LinkAtStamp> links;
  for (std::size_t i = 0; i < now.size(); ++i) {
    links.push_back({now[i], VelocityBetween(before[i], after[i], kStep_s)});
  }
  return links;
}

void PandaSweep::PlaceThings() {
  const auto add = [&](const Shape& shape, const Pose& X_WO) {
    things_.objects.push_back({.parts = {{Pose::Identity(), shape}}, .X_WO = X_WO});
  };
  add(Box{{2.4, 2.4, 0.04}}, MakeTranslation(0.3, 0, -0.02));  // the table; its top is z = 0
  // Cans below the path of the hand, as tall as leaves 5 to 13 mm between the two.
  std::vector<std::vector<Pose>> path;  // X_LW of the hand's links
  for (double time_s = 0; time_s < kPath_s; time_s += 0.02) {
    const std::vector<Pose> X_WL = PosesAt(time_s);
    std::vector<Pose>& poses = path.emplace_back();
    for (const int link : hand_links_) {
      poses.push_back(X_WL[static_cast<std::size_t>(link)].inverse());
    }
  }
  constexpr int kCans = 9;
  for (int i = 0; i < kCans; ++i) {
    const double azimuth_rad = -0.8 + 1.6 * i / (kCans - 1);
    const double radius_m = 0.022 + 0.002 * i;
    const double from_base_m = 0.48 + 0.03 * (i % 3);
    const Vector3 foot_W(from_base_m * std::cos(azimuth_rad), from_base_m * std::sin(azimuth_rad),
                         0);
    const double gap_m = 0.005 + 0.001 * i;
    double height_m = 0.02;
    while (height_m < 0.3 && IsClear(path, foot_W, radius_m, height_m + 0.004, gap_m)) {
      height_m += 0.004;
    }
    add(Cylinder{.radius_m = radius_m, .length_m = height_m},
        MakeTranslation(foot_W.x(), foot_W.y(), 0.5 * height_m));
  }
}

bool PandaSweep::IsClear(const std::vector<std::vector<Pose>>& path, const Vector3& foot_W,
                         double radius_m, double height_m, double gap_m) const {
  std::vector<Vector3> top_W = {foot_W + Vector3(0, 0, height_m)};
  for (int i = 0; i < 12; ++i) {
    const double angle_rad = i * std::numbers::pi / 6;
    top_W.push_back(
        foot_W + Vector3(radius_m * std::cos(angle_rad), radius_m * std::sin(angle_rad), height_m));
  }
  for (const std::vector<Pose>& X_LW : path) {
    for (std::size_t i = 0; i < X_LW.size(); ++i) {
      const LinkSurface& link = surface_->links()[static_cast<std::size_t>(hand_links_[i])];
      for (const Vector3& p_W : top_W) {
        if (link.IsWithin((X_LW[i] * p_W).cast<float>(), static_cast<float>(gap_m))) return false;
      }
    }
  }
  return true;
}

void PandaSweep::RenderExpected() {
  for (const Sighting& sighting : Render(things_, pinhole_).pixels) {
    expected_m_.push_back(sighting.seen() ? static_cast<float>(sighting.depth_m)
                                          : std::numeric_limits<float>::infinity());
    expected_body_.push_back(sighting.seen() ? static_cast<BodyId>(sighting.object) : kNoBody);
  }
}

SweepFrame PandaSweep::Frame(double time_s, std::uint64_t seed) const {
  SimulatedScene scene = things_;
  const std::vector<Pose> X_WL = PosesAt(time_s);
  for (std::size_t i = 0; i < X_WL.size(); ++i) {
    SimulatedObject& link = scene.objects.emplace_back();
    link.X_WO = X_WL[i];
    for (const collision::CollisionGeometry& geometry : model_->links[i].collisions) {
      link.parts.push_back({geometry.X_LG, geometry.shape});
    }
  }
  const RangeImage image = Render(scene, pinhole_);
  DeviceReturns returns{.width = pinhole_.width, .height = pinhole_.height, .pixels = {}};
  returns.pixels.resize(image.pixels.size());
  ComputeReturns(scene, image, pinhole_, device_, 0, pinhole_.height, returns);
  MeasuredDepth depth = DrawFrame(returns, noise_, seed);
  for (float& depth_m : depth.depth_m) {
    const bool is_in_range =
        depth_m >= camera_.least_range_m && depth_m <= camera_.greatest_range_m;
    if (!is_in_range) depth_m = 0;
  }
  return {.time_s = time_s,
          .image = {pinhole_.width, pinhole_.height, std::move(depth.depth_m)},
          .object = std::move(depth.object)};
}

std::vector<double> PandaSweep::HandDistances_m(const SweepFrame& frame) const {
  constexpr double kFar_m = 0.05;
  std::vector<double> distances_m(things_.objects.size(), kFar_m);
  const std::vector<Pose> X_WL = PosesAt(frame.time_s);
  for (std::size_t pixel = 0; pixel < frame.object.size(); ++pixel) {
    const std::int32_t object = frame.object[pixel];
    if (object < 0 || IsRobot(object)) continue;
    const auto width = static_cast<std::size_t>(pinhole_.width);
    const std::size_t u = pixel % width, v = pixel / width;
    const Vector3 ray_C = RayDirection(pinhole_, static_cast<double>(u), static_cast<double>(v));
    const Vector3 p_W = X_WC() * Vector3(frame.image.depth_m[pixel] * ray_C);
    double& distance_m = distances_m[static_cast<std::size_t>(object)];
    for (const int link : hand_links_) {
      const auto index = static_cast<std::size_t>(link);
      const Vector3 p_L = X_WL[index].inverse() * p_W;
      distance_m =
          std::min(distance_m, surface_->links()[index].Distance_m(p_L.cast<float>(), distance_m));
    }
  }
  return distances_m;
}

}  // namespace cwm::benchmarks
