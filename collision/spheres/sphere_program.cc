#include "collision/spheres/sphere_program.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "collision/robot/kinematics.h"
#include "collision/spheres/sphere_lanes.h"

namespace cwm::collision {
namespace {

// A rail without limits, and angles that lose digits on the way to [-pi, pi].
constexpr double kFarthestShift_m = 100;
constexpr double kFarthestTurn_rad = 1e4;

constexpr double kRoundedUp = 1 + 4 * kFloatRounding;

// A frame that a joint of the group moves, and what is known of it at every state.
struct Frame {
  std::int32_t index = 0;
  SphereProgram::Ball reach;   // of its origin
  double rotation_error = 0;   // Frobenius norm
  double origin_error_m = 0;
};

// Where a link is, fixed in a frame.
struct Fixed {
  std::size_t frame = 0;  // into Compiler::frames_
  Pose X_FL = Pose::Identity();
};

class Compiler {
 public:
  Compiler(const RobotModel& model, const JointGroup& group, std::span<const double> base)
      : model_(model), column_of_(model.variables.size(), -1), X_BL_(model.links.size()) {
    LinkPoses(model, Pose::Identity(), base, X_BL_);
    for (std::size_t k = 0; k < group.variables.size(); ++k) {
      column_of_[static_cast<std::size_t>(group.variables[k])] = static_cast<int>(k);
    }
  }

  bool AddLinks() {
    program_.lanes.joints.emplace_back();
    frames_.emplace_back();
    links_.push_back({.frame = 0, .X_FL = Pose::Identity()});
    for (std::size_t i = 1; i < model_.links.size(); ++i) {
      if (!AddLink(i)) return false;
    }
    return true;
  }

  void AddSpheres(std::span<const PlacedSphere> spheres) {
    std::map<int, std::vector<std::size_t>> of_link;
    for (std::size_t k = 0; k < spheres.size(); ++k) of_link[spheres[k].link].push_back(k);
    lane_of_.resize(spheres.size());
    cluster_of_.resize(spheres.size());
    for (const auto& [link, some] : of_link) AddCluster(links_[static_cast<std::size_t>(link)], spheres, some);
  }

  void AddPairs(std::span<const PlacedSphere> spheres, std::span<const SpherePair> pairs,
                double margin_m) {
    LaneProgram& lanes = program_.lanes;
    std::map<std::pair<std::int32_t, std::int32_t>, std::vector<SpherePair>> of_clusters;
    for (const SpherePair& pair : pairs) {
      const auto a = static_cast<std::size_t>(pair.first), b = static_cast<std::size_t>(pair.second);
      of_clusters[{cluster_of_[a], cluster_of_[b]}].push_back(pair);
    }
    for (const auto& [clusters, some] : of_clusters) {
      const auto begin = static_cast<std::int32_t>(lanes.sphere_pairs.size());
      for (const SpherePair& pair : some) {
        const auto one = static_cast<std::size_t>(pair.first);
        const auto other = static_cast<std::size_t>(pair.second);
        lanes.sphere_pairs.push_back(
            {lane_of_[one], lane_of_[other],
             static_cast<float>(spheres[one].radius_m + spheres[other].radius_m + margin_m)});
      }
      const LaneCluster& a = lanes.clusters[static_cast<std::size_t>(clusters.first)];
      const LaneCluster& b = lanes.clusters[static_cast<std::size_t>(clusters.second)];
      const double reach_m = double{a.bound.radius_m} + double{b.bound.radius_m} + margin_m;
      const double error_m = double{a.centre_error_m} + double{b.centre_error_m} + Rounding_m(lanes.reach_m);
      lanes.cluster_pairs.push_back(
          {.first = clusters.first,
           .second = clusters.second,
           .reach_m = static_cast<float>(kRoundedUp * reach_m),
           .begin = begin,
           .end = static_cast<std::int32_t>(lanes.sphere_pairs.size()),
           .band = BandOf(error_m, double{a.widest_m} + double{b.widest_m} + margin_m, reach_m)});
    }
  }

  SphereProgram Take() { return std::move(program_); }

 private:
  bool AddLink(std::size_t index) {
    const ModelLink& link = model_.links[index];
    const Fixed& parent = links_[static_cast<std::size_t>(link.parent)];
    const bool moves = link.kind != JointKind::kFixed &&
                       column_of_[static_cast<std::size_t>(link.variable)] >= 0;
    if (!moves) {
      const Pose X_PL = X_BL_[static_cast<std::size_t>(link.parent)].inverse() * X_BL_[index];
      links_.push_back({.frame = parent.frame, .X_FL = parent.X_FL * X_PL});
      return true;
    }
    if (link.kind == JointKind::kPlanar || link.kind == JointKind::kFloating) return false;
    AddJoint(link, parent);
    return true;
  }

  void AddJoint(const ModelLink& link, const Fixed& parent) {
    const bool turns = link.kind != JointKind::kPrismatic;
    const Matrix3 to_axis = BasisFromZ(link.axis_J);
    Pose X_PF = parent.X_FL * link.X_PJ;
    X_PF.linear() = X_PF.linear() * to_axis;
    LaneJoint joint{.parent = frames_[parent.frame].index, .turns = turns};
    for (int i = 0; i < 9; ++i) joint.rotation[i] = static_cast<float>(X_PF.linear()(i / 3, i % 3));
    for (int i = 0; i < 3; ++i) joint.shift_m[i] = static_cast<float>(X_PF.translation()[i]);
    const Variable& variable = model_.variables[static_cast<std::size_t>(link.variable)];
    const double farthest_variable =
        std::max(std::abs(variable.lower), std::abs(variable.upper)) * std::abs(link.multiplier) +
        std::abs(link.offset);
    const double farthest =
        turns ? kFarthestTurn_rad : std::min(farthest_variable, kFarthestShift_m);
    program_.inputs.push_back(
        {.column = static_cast<std::size_t>(column_of_[static_cast<std::size_t>(link.variable)]),
         .multiplier = link.multiplier,
         .offset = link.offset,
         .turns = turns,
         .farthest = farthest});
    frames_.push_back(Below(frames_[parent.frame], X_PF.translation(), turns ? 0.0 : farthest));
    program_.lanes.joints.push_back(joint);
    Pose X_FL = Pose::Identity();
    X_FL.linear() = to_axis.transpose();
    links_.push_back({.frame = frames_.size() - 1, .X_FL = X_FL});
  }

  // Rounding errors to first order, each count a little more than what the products and sums of
  // Hung and Place (sphere_lanes.cc) make: u is kFloatRounding, norms are Frobenius'.
  Frame Below(const Frame& parent, const Vector3& shift, double travel_m) const {
    constexpr double u = kFloatRounding;
    Frame frame;
    frame.index = static_cast<std::int32_t>(frames_.size());
    const double shift_m = shift.norm();
    if (parent.index == 0) {
      frame.reach = {shift, travel_m};
    } else {
      frame.reach = {parent.reach.centre, parent.reach.radius_m + shift_m + travel_m};
    }
    const double out_m = frame.reach.centre.norm() + frame.reach.radius_m;
    // The fixed rotation: its own rounding, and a product of 3 x 3. The turn: two columns, each of
    // two products by numbers that are off by kSineError.
    const double product = parent.rotation_error + 12 * u;
    frame.rotation_error = product + 3 * kSineError + 6 * u;
    frame.origin_error_m = parent.origin_error_m + product * (shift_m + travel_m) +
                           8 * u * (shift_m + travel_m + out_m);
    return frame;
  }

  void AddCluster(const Fixed& fixed, std::span<const PlacedSphere> spheres,
                  const std::vector<std::size_t>& some) {
    LaneProgram& lanes = program_.lanes;
    const Frame& frame = frames_[fixed.frame];
    LaneCluster cluster{.frame = frame.index,
                        .first = static_cast<std::int32_t>(lanes.spheres.size()),
                        .count = static_cast<std::int32_t>(some.size())};
    std::vector<Vector3> centres_F;
    for (std::size_t k : some) {
      centres_F.push_back(fixed.X_FL * spheres[k].centre_L);
      lane_of_[k] = static_cast<std::int32_t>(lanes.spheres.size());
      cluster_of_[k] = static_cast<std::int32_t>(lanes.clusters.size());
      lanes.spheres.push_back(InLanes(frame, centres_F.back(), spheres[k].radius_m, cluster));
      cluster.widest_m = std::max(cluster.widest_m, lanes.spheres.back().radius_m);
    }
    Vector3 middle = Vector3::Zero();
    const auto farthest = [&] {
      std::pair<double, std::size_t> most{-1, 0};
      for (std::size_t i = 0; i < some.size(); ++i) {
        most = std::max(most, std::pair((centres_F[i] - middle).norm() + spheres[some[i]].radius_m, i));
      }
      return most;
    };
    // Towards the farthest, by ever smaller steps (Badoiu and Clarkson 2003).
    constexpr int kSteps = 12;
    for (const Vector3& centre : centres_F) middle += centre / static_cast<double>(some.size());
    auto best = std::pair(farthest().first, middle);
    for (int step = 2; step < kSteps; ++step) {
      middle += (centres_F[farthest().second] - middle) / step;
      if (const double radius_m = farthest().first; radius_m < best.first) best = {radius_m, middle};
    }
    cluster.bound = InLanes(frame, best.second, kRoundedUp * best.first, cluster);
    program_.reach_of_cluster.push_back(
        fixed.frame == 0 ? SphereProgram::Ball{best.second, best.first}
                         : SphereProgram::Ball{frame.reach.centre, frame.reach.radius_m + best.second.norm() + best.first});
    lanes.clusters.push_back(cluster);
  }

  LaneSphere InLanes(const Frame& frame, const Vector3& centre_F, double radius_m,
                     LaneCluster& cluster) {
    constexpr double u = kFloatRounding;
    LaneProgram& lanes = program_.lanes;
    LaneSphere sphere{.centre_m = {}, .radius_m = static_cast<float>(radius_m)};
    for (int i = 0; i < 3; ++i) sphere.centre_m[i] = static_cast<float>(centre_F[i]);
    const double out_m = frame.reach.centre.norm() + frame.reach.radius_m + centre_F.norm();
    const double error_m = frame.origin_error_m + frame.rotation_error * centre_F.norm() + 8 * u * (out_m + centre_F.norm());
    lanes.reach_m = std::max(lanes.reach_m, static_cast<float>(kRoundedUp * out_m));
    cluster.centre_error_m = std::max(cluster.centre_error_m, static_cast<float>(kRoundedUp * error_m));
    return sphere;
  }

  const RobotModel& model_;
  std::vector<int> column_of_;  // by variable; -1: not of the group
  std::vector<Pose> X_BL_;      // at the base state
  std::vector<Frame> frames_;
  std::vector<Fixed> links_;
  std::vector<std::int32_t> lane_of_, cluster_of_;  // by sphere as given
  SphereProgram program_;
};

}  // namespace

std::optional<SphereProgram> CompileSpheres(const RobotModel& model, const JointGroup& group,
                                            std::span<const double> base,
                                            std::span<const PlacedSphere> spheres,
                                            std::span<const SpherePair> pairs,
                                            double pair_margin_m) {
  Compiler compiler(model, group, base);
  if (!compiler.AddLinks()) return std::nullopt;
  compiler.AddSpheres(spheres);
  compiler.AddPairs(spheres, pairs, pair_margin_m);
  return compiler.Take();
}

bool ToLanes(const SphereProgram& program, std::span<const double> row, float* values,
             std::size_t stride) {
  for (const JointInput& input : program.inputs) {
    double value = input.multiplier * row[input.column] + input.offset;
    if (!(std::abs(value) <= input.farthest)) return false;
    if (input.turns && std::abs(value) > std::numbers::pi) {
      value -= 2 * std::numbers::pi * std::nearbyint(value / (2 * std::numbers::pi));
    }
    *values = static_cast<float>(value);
    values += stride;
  }
  return true;
}

double Rounding_m(double coordinate_m) {
  constexpr double kRoundings = 32 * kFloatRounding;
  constexpr double kSlack_m = 1e-8;
  return kRoundings * coordinate_m + kSlack_m;
}

LaneBand BandOf(double error_m, double widest_sphere_m, double widest_bound_m) {
  const auto beyond = [&](double reach_m) {
    return static_cast<float>(1.001 * (2 * reach_m * error_m + error_m * error_m +
                                       16 * kFloatRounding * reach_m * reach_m));
  };
  return {.spheres_m2 = beyond(widest_sphere_m), .bounds_m2 = beyond(widest_bound_m)};
}

}  // namespace cwm::collision
