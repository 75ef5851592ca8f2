#include "clients/grasp/sample_shape.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <optional>

namespace cwm::grasp {
namespace {

using Eigen::Vector3d;

// A line along which pads close: its middle, its direction (unit length), and the surfaces at its
// ends.
struct ClosingLine {
  Vector3d middle_S;
  Vector3d direction_S;
  double width_m = 0;
  double tilt_rad = 0;
};

constexpr int kDirectionsAround = 16;  // chosen: 22.5 degrees apart, which includes faces and
                                       // corners of a box

// A direction perpendicular to the line, from which the other directions are counted.
Vector3d Across(const Vector3d& direction, const Vector3d& wanted) {
  Vector3d across = wanted - wanted.dot(direction) * direction;
  if (across.norm() > 1e-3) return across.normalized();
  return direction.unitOrthogonal();
}

Candidate CandidateAt(const ClosingLine& line, const Vector3d& approach_S, const char* strategy) {
  Candidate candidate{.width_m = line.width_m, .tilt_rad = line.tilt_rad, .strategy = strategy};
  Eigen::Matrix3d R_SG;
  R_SG.col(0) = line.direction_S;
  R_SG.col(2) = approach_S;
  R_SG.col(1) = approach_S.cross(line.direction_S);
  candidate.X_FG.linear() = R_SG;
  candidate.X_FG.translation() = line.middle_S;
  return candidate;
}

class Sampler {
 public:
  explicit Sampler(const SamplerOptions& options)
      : options_(options), max_tilt_rad_(std::atan(options.friction)) {}

  // True if the line fits between the pads and friction holds.
  bool Fits(const ClosingLine& line) {
    found_.RecordWidth(line.width_m);
    if (line.width_m > options_.gripper.opening_m - 2 * options_.min_gap_m) return false;
    if (line.tilt_rad <= max_tilt_rad_) return true;
    found_.RecordSlip(line.tilt_rad);
    return false;
  }

  void Add(const ClosingLine& line, const Vector3d& approach_S, const char* strategy) {
    if (Fits(line)) found_.list.push_back(CandidateAt(line, approach_S, strategy));
  }

  // Round objects may be thicker in the middle than fingers are long. There the tips alone may
  // hold, with the pads drawn back from the line as far as the wall stays within the pads and the
  // friction.
  void AddRound(const ClosingLine& line, const Vector3d& first_S, const char* strategy) {
    AddAround(line, first_S, strategy);
    const std::size_t begin = found_.list.size();
    AddAround(line, first_S, strategy);
    for (std::size_t i = begin; i < found_.list.size(); ++i) {
      found_.list[i].retraction_m = 0.3 * options_.gripper.pad_length_m;
      found_.list[i].X_FG.translate(Vector3d(0, 0, -found_.list[i].retraction_m));
    }
  }

  // Adds approaches all around the line, beginning with `first_S`.
  void AddAround(const ClosingLine& line, const Vector3d& first_S, const char* strategy) {
    if (!Fits(line)) return;
    const Vector3d first = Across(line.direction_S, first_S);
    for (int k = 0; k < kDirectionsAround; ++k) {
      const double angle_rad = 2 * std::numbers::pi * k / kDirectionsAround;
      found_.list.push_back(
          CandidateAt(line, Eigen::AngleAxisd(angle_rad, line.direction_S) * first, strategy));
    }
  }

  const SamplerOptions& options() const { return options_; }
  Candidates Take() { return std::move(found_); }

 private:
  SamplerOptions options_;
  double max_tilt_rad_;
  Candidates found_;
};

// Places along an extent centred at 0, at most half a pad apart if seven places suffice; the
// outermost are half a pad from the ends, so that pads are fully covered.
std::vector<double> PositionsAlong(double extent_m, const Gripper& gripper) {
  const double reach_m = (extent_m - gripper.pad_length_m) / 2;
  if (reach_m <= 0) return {0.0};
  const int steps =
      std::clamp(static_cast<int>(std::ceil(4 * reach_m / gripper.pad_length_m)), 2, 6);
  std::vector<double> slots;
  for (int k = 0; k <= steps; ++k) slots.push_back(reach_m * (2.0 * k / steps - 1));
  return slots;
}

// The wall of a solid of revolution about z.
struct Wall {
  double radius_bottom_m = 0;
  double radius_top_m = 0;
  double length_m = 0;
};

double WallTilt(const Wall& wall) {
  return std::abs(std::atan2(wall.radius_top_m - wall.radius_bottom_m, wall.length_m));
}

void AddAcross(const Wall& wall, const char* strategy, Sampler& sampler) {
  constexpr int kAzimuths = 12;  // chosen: over half a turn, 15 degrees apart
  const double tilt_rad = WallTilt(wall);
  for (const double z_m : PositionsAlong(wall.length_m, sampler.options().gripper)) {
    const double share = z_m / wall.length_m + 0.5;
    const double radius_m =
        wall.radius_bottom_m + share * (wall.radius_top_m - wall.radius_bottom_m);
    for (int k = 0; k < kAzimuths; ++k) {
      const double angle_rad = std::numbers::pi * k / kAzimuths;
      sampler.AddRound({.middle_S = {0, 0, z_m},
                        .direction_S = {std::cos(angle_rad), std::sin(angle_rad), 0},
                        .width_m = 2 * radius_m,
                        .tilt_rad = tilt_rad},
                       Vector3d::UnitZ(), strategy);
    }
  }
}

// Between the two end discs: in the middle, and half way to the edge of the smaller one.
void AddEnds(const Wall& wall, const char* strategy, Sampler& sampler) {
  const double min_radius_m = std::min(wall.radius_bottom_m, wall.radius_top_m);
  if (min_radius_m < sampler.options().gripper.pad_length_m / 4) return;
  sampler.AddAround(
      {.middle_S = Vector3d::Zero(), .direction_S = Vector3d::UnitZ(), .width_m = wall.length_m},
      sampler.options().up_S, strategy);
  for (int k = 0; k < kDirectionsAround; ++k) {
    const double angle_rad = 2 * std::numbers::pi * k / kDirectionsAround;
    const Vector3d out(std::cos(angle_rad), std::sin(angle_rad), 0);
    sampler.Add({.middle_S = 0.5 * min_radius_m * out,
                 .direction_S = Vector3d::UnitZ(),
                 .width_m = wall.length_m},
                -out, strategy);
  }
}

// The radius of a profile at a height, linear between its points; empty outside of it.
std::optional<double> RadiusAt(const Polygon& profile, double z_m) {
  for (Eigen::Index k = 0; k + 1 < profile.cols(); ++k) {
    const Eigen::Vector2d a = profile.col(k), b = profile.col(k + 1);
    if (a.y() == b.y() || (z_m - a.y()) * (z_m - b.y()) > 0) continue;
    return a.x() + (b.x() - a.x()) * (z_m - a.y()) / (b.y() - a.y());
  }
  return std::nullopt;
}

}  // namespace

void Candidates::Append(const Candidates& other) {
  list.insert(list.end(), other.list.begin(), other.list.end());
  if (other.min_width_m >= 0) RecordWidth(other.min_width_m);
  if (other.min_tilt_rad >= 0) RecordSlip(other.min_tilt_rad);
}

void Candidates::RecordWidth(double width_m) {
  min_width_m = min_width_m < 0 ? width_m : std::min(min_width_m, width_m);
}

void Candidates::RecordSlip(double tilt_rad) {
  min_tilt_rad = min_tilt_rad < 0 ? tilt_rad : std::min(min_tilt_rad, tilt_rad);
}

Candidates SampleBox(const Box& box, const SamplerOptions& options) {
  Sampler sampler(options);
  const Vector3d size_m(box.size_x_m, box.size_y_m, box.size_z_m);
  for (int closing = 0; closing < 3; ++closing) {
    const int j = (closing + 1) % 3, k = (closing + 2) % 3;
    for (const double a_m : PositionsAlong(size_m[j], options.gripper)) {
      for (const double b_m : PositionsAlong(size_m[k], options.gripper)) {
        ClosingLine line{.middle_S = Vector3d::Zero(),
                         .direction_S = Vector3d::Unit(closing),
                         .width_m = size_m[closing]};
        line.middle_S[j] = a_m;
        line.middle_S[k] = b_m;
        sampler.AddAround(line, Vector3d::Unit(j), "box faces");
      }
    }
  }
  return sampler.Take();
}

Candidates SampleCylinder(const Cylinder& cylinder, const SamplerOptions& options) {
  Sampler sampler(options);
  const Wall wall{cylinder.radius_m, cylinder.radius_m, cylinder.length_m};
  AddAcross(wall, "cylinder wall", sampler);
  AddEnds(wall, "cylinder ends", sampler);
  return sampler.Take();
}

Candidates SampleCone(const Cone& cone, const SamplerOptions& options) {
  Sampler sampler(options);
  const Wall wall{cone.radius_bottom_m, cone.radius_top_m, cone.length_m};
  AddAcross(wall, "cone wall", sampler);
  AddEnds(wall, "cone ends", sampler);
  return sampler.Take();
}

Candidates SampleCapsule(const Capsule& capsule, const SamplerOptions& options) {
  Sampler sampler(options);
  // A capsule of length 0 is a sphere, whose wall still has a middle.
  const Wall wall{capsule.radius_m, capsule.radius_m, std::max(capsule.length_m, 1e-9)};
  AddAcross(wall, "capsule wall", sampler);
  return sampler.Take();
}

Candidates SampleSphere(const Sphere& sphere, const SamplerOptions& options) {
  constexpr int kAzimuths = 12, kHeights = 3;
  Sampler sampler(options);
  const Vector3d up = options.up_S;
  const Vector3d level = up.unitOrthogonal();
  // Horizontal lines first: a sphere on a table is grasped across its equator.
  for (int height = 0; height < kHeights; ++height) {
    const double rise_rad = std::numbers::pi / 4 * height;
    for (int k = 0; k < (height + 1 == kHeights ? 1 : kAzimuths); ++k) {
      const Vector3d around = Eigen::AngleAxisd(std::numbers::pi * k / kAzimuths, up) * level;
      sampler.AddRound({.middle_S = Vector3d::Zero(),
                        .direction_S = std::cos(rise_rad) * around + std::sin(rise_rad) * up,
                        .width_m = 2 * sphere.radius_m},
                       up, "sphere");
    }
  }
  return sampler.Take();
}

Candidates SampleVessel(const Vessel& vessel, const SamplerOptions& options) {
  constexpr int kAzimuths = 24;
  Sampler sampler(options);
  for (const double below_m : {0.25, 0.5, 0.75}) {
    const double z_m = vessel.height_m / 2 - below_m * options.gripper.pad_length_m;
    const auto outside_m = RadiusAt(vessel.outer_profile, z_m);
    const auto inside_m = RadiusAt(vessel.inner_profile, z_m);
    if (!outside_m || !inside_m) continue;
    for (int k = 0; k < kAzimuths; ++k) {
      const double angle_rad = 2 * std::numbers::pi * k / kAzimuths;
      const Vector3d out(std::cos(angle_rad), std::sin(angle_rad), 0);
      sampler.Add({.middle_S = 0.5 * (*outside_m + *inside_m) * out + z_m * Vector3d::UnitZ(),
                   .direction_S = out,
                   .width_m = *outside_m - *inside_m},
                  -Vector3d::UnitZ(), "rim");
    }
  }
  AddAcross({vessel.foot_radius_m, vessel.rim_radius_m, vessel.height_m}, "vessel wall", sampler);
  return sampler.Take();
}

Candidates SampleHandle(const Box& bounds, const Vector3d& axis_B, const SamplerOptions& options) {
  Sampler sampler(options);
  const Vector3d size_m(bounds.size_x_m, bounds.size_y_m, bounds.size_z_m);
  int length = 0;
  axis_B.cwiseAbs().maxCoeff(&length);
  for (const int closing : {(length + 1) % 3, (length + 2) % 3}) {
    const int other = 3 - length - closing;
    for (const double along : {-0.3, -0.15, 0.0, 0.15, 0.3}) {
      // The bow of a handle is at one side of its bounds.
      for (const double aside : {-0.4, -0.2, 0.0, 0.2, 0.4}) {
        ClosingLine line{.middle_S = Vector3d::Zero(),
                         .direction_S = Vector3d::Unit(closing),
                         .width_m = size_m[closing]};
        line.middle_S[length] = along * size_m[length];
        line.middle_S[other] = aside * size_m[other];
        sampler.AddAround(line, Vector3d::Unit(other), "handle");
      }
    }
  }
  return sampler.Take();
}

}  // namespace cwm::grasp
