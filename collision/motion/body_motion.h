// A body on its way from one row to the next, and bounds on the travel of its parts.
#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "collision/query/query.h"
#include "collision/query/robot_body.h"

namespace cwm::collision {

// The motion along one edge. Times are fractions of the edge, from 0 to 1. Immutable.
class BodyMotion {
 public:
  virtual ~BodyMotion() = default;
  // Sets X_WF, one pose for each frame of the body except those of attached objects.
  virtual void Place(double fraction, std::span<Pose> X_WF) const = 0;
  // An upper bound in metres on the travel of any point of the part, in the world, over the whole
  // edge. The travel over a share of the edge is at most that share of the bound.
  virtual double Travel_m(std::int32_t part) const = 0;
  // The same along a unit vector in the world. It is at most Travel_m: less if the part is known to
  // move sideways to the vector, negative if it moves away. Backwards along the edge, the bound is
  // that of the opposite vector.
  virtual double TravelAlong_m(std::int32_t part, const Vector3&) const { return Travel_m(part); }
  // The same for a self pair: the travel of any point of one part in the frame of the other.
  virtual double RelativeTravel_m(const PartPair& pair) const = 0;

  // The velocity, by fraction of the edge, of the point of the part that is at p_W, where the
  // body's frames are at X_WF.
  virtual Vector3 Velocity_m(std::span<const Pose> X_WF, std::int32_t part,
                             const Vector3& p_W) const = 0;
  // An upper bound on the length of the second derivative of any point of the part, by fraction of
  // the edge, and for a self pair, in the frame of the other part. Infinite if it is not known.
  virtual double Bend_m(std::int32_t part) const = 0;
  virtual double RelativeBend_m(const PartPair& pair) const = 0;
};

// True if a whole turn of the variable leaves the robot in the same configuration, so that it takes
// the short way. This holds for the heading of a planar joint, and for a continuous joint if
// neither it nor a joint that mimics it has limits, and all joints that mimic it are rotary with
// integer multipliers. For other variables the short way would end elsewhere than the row says, or
// pass through states outside the limits.
bool IsCyclic(const RobotModel& model, std::size_t variable);
// The change of a variable on its way.
double StepOf(bool is_cyclic, double from, double to);

// A rigid body whose origin moves linearly and whose rotation takes the short way at constant speed
// (slerp).
class RigidMotion : public BodyMotion {
 public:
  RigidMotion(const QueryBody& body, const Pose& X_WB_from, const Pose& X_WB_to);

  void Place(double fraction, std::span<Pose> X_WF) const override;
  double Travel_m(std::int32_t part) const override {
    return step_m_.norm() + sweep_m_[static_cast<std::size_t>(part)];
  }
  double TravelAlong_m(std::int32_t part, const Vector3& nhat_W) const override;
  double RelativeTravel_m(const PartPair&) const override { return 0; }
  Vector3 Velocity_m(std::span<const Pose> X_WF, std::int32_t part,
                     const Vector3& p_W) const override;
  double Bend_m(std::int32_t part) const override {
    return std::abs(turn_.angle()) * sweep_m_[static_cast<std::size_t>(part)];
  }
  double RelativeBend_m(const PartPair&) const override { return 0; }

 private:
  const Pose from_;
  const Vector3 step_m_;
  const Eigen::AngleAxisd turn_;  // in the frame of `from_`
  std::vector<double> sweep_m_;   // by part: the most that the rotation alone moves a point of it
};

// A robot whose joints move linearly. A continuous joint takes the short way, unless it has limits,
// or a joint mimics it that a whole turn would leave elsewhere. Planar and floating joints move
// like a rigid body: their origin moves straight, their rotation takes the short way at constant
// speed; for half a turn, either direction is possible.
class JointMotion : public BodyMotion {
 public:
  // `body` is a body of the robot (BodyFromRobot, BodyFromSpheres) with its attached objects;
  // `from` and `to` have all variables of the model. Refers to the model and to the body.
  JointMotion(const RobotModel& model, const QueryBody& body, const Pose& X_WB,
              std::span<const double> from, std::span<const double> to);

  void Place(double fraction, std::span<Pose> X_WL) const override;
  double Travel_m(std::int32_t part) const override;
  double TravelAlong_m(std::int32_t part, const Vector3& nhat_W) const override;
  double RelativeTravel_m(const PartPair& pair) const override;
  Vector3 Velocity_m(std::span<const Pose> X_WF, std::int32_t part,
                     const Vector3& p_W) const override;
  double Bend_m(std::int32_t part) const override { return BendBelow_m(part, -1); }
  double RelativeBend_m(const PartPair& pair) const override;

 private:
  // The motion of a link relative to its joint's parent over the whole edge.
  struct JointTravel {
    Vector3 slide_W = Vector3::Zero();  // of the link's origin
    double turn_rad = 0;
    Vector3 axis_W = Vector3::UnitZ();  // of the rotation
    double arm_m = 0;                   // from the joint's origin to the link's, at most
    bool is_steady = true;  // false if a joint above turns; the vectors then hold at the start only
  };
  // The rotation of a floating joint.
  struct Turn {
    std::size_t first;  // its quaternion begins at this variable
    Quaternion from;
    Eigen::AngleAxisd whole;  // in the frame of `from`
  };

  // The motion of the joint above the link, with vectors in the joint's frame.
  JointTravel TravelOf(const ModelLink& link, std::span<const double> to);
  // Adds the rotation of the quaternion that begins at variable `first`; nullptr if it does not
  // change.
  const Turn* AddTurn(std::size_t first, std::span<const double> to);
  // The link of the part; for an attached object, the link that it is attached to.
  int LinkOf(std::int32_t part) const;
  // The largest distance of the part's points from the origin of that link.
  double Reach_m(std::int32_t part) const;
  // A bound on the part's travel in the frame of link `above`, or in the world for -1.
  double TravelBelow_m(std::int32_t part, int above) const;
  // The same for the second derivative (spheres/motion_lanes.h).
  double BendBelow_m(std::int32_t part, int above) const;
  template <class Of>
  double SumBelow_m(std::int32_t part, int above, Of&& of) const;
  int CommonAncestor(int link, int other) const;

  const RobotModel& model_;
  const QueryBody& body_;
  const Pose X_WB_;
  std::vector<double> from_, step_;  // of the variables; `turns_` has the quaternions
  std::vector<Turn> turns_;
  std::vector<JointTravel> joints_;  // by link: the motion of the joint above it
};

}  // namespace cwm::collision
