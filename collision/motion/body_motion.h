// A body on its way from one row to another, and how fast its parts can move meanwhile.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "collision/query/query.h"
#include "collision/query/robot_body.h"

namespace cwm::collision {

// One edge. Times are fractions of it, 0 to 1. Immutable.
class BodyMotion {
 public:
  virtual ~BodyMotion() = default;
  // Sets X_WF, one pose for each frame of the body but those of what it carries.
  virtual void Place(double fraction, std::span<Pose> X_WF) const = 0;
  // No point of the part travels farther, in the world, than this times the share of the edge.
  virtual double Travel_m(std::int32_t part) const = 0;
  // The same along a unit vector of the world: as much, or less where the part is known to move past
  // it, and below zero where it moves away. Backwards along the edge it is that of the opposite
  // vector.
  virtual double TravelAlong_m(std::int32_t part, const Vector3&) const { return Travel_m(part); }
  // The same of a self pair: of a point of one part as the other one sees it.
  virtual double RelativeTravel_m(const PartPair& pair) const = 0;
};

// A rigid body: the origin moves linearly, the rotation is the short way at constant speed (slerp).
class RigidMotion : public BodyMotion {
 public:
  RigidMotion(const QueryBody& body, const Pose& X_WB_from, const Pose& X_WB_to);

  void Place(double fraction, std::span<Pose> X_WF) const override;
  double Travel_m(std::int32_t part) const override {
    return step_m_.norm() + sweep_m_[static_cast<std::size_t>(part)];
  }
  double TravelAlong_m(std::int32_t part, const Vector3& nhat_W) const override;
  double RelativeTravel_m(const PartPair&) const override { return 0; }

 private:
  const Pose from_;
  const Vector3 step_m_;
  const Eigen::AngleAxisd turn_;  // in the frame of `from_`
  std::vector<double> sweep_m_;   // by part: how far the turn alone takes its points at most
};

// A robot whose joints move linearly, continuous ones the short way, but for those that a joint
// follows which a whole turn would leave elsewhere. Planar and floating joints move as a rigid body
// does: straight ahead, while they turn the short way at constant speed; of half a turn either way is
// as short.
class JointMotion : public BodyMotion {
 public:
  // A body of the robot (BodyFromRobot, BodyFromSpheres) and what it carries; all variables of the
  // model, at the start and at the end. Refers to the model and to the body.
  JointMotion(const RobotModel& model, const QueryBody& body, const Pose& X_WB,
              std::span<const double> from, std::span<const double> to);

  void Place(double fraction, std::span<Pose> X_WL) const override;
  double Travel_m(std::int32_t part) const override;
  double TravelAlong_m(std::int32_t part, const Vector3& nhat_W) const override;
  double RelativeTravel_m(const PartPair& pair) const override;

 private:
  // What a joint does to its link over the whole edge.
  struct JointTravel {
    Vector3 slide_W = Vector3::Zero();  // of the link's origin
    double turn_rad = 0;
    Vector3 axis_W = Vector3::UnitZ();  // of that turn
    double arm_m = 0;                   // from the joint's origin to the link's, at most
    bool is_steady = true;  // no joint above it turns: else the vectors are those of the start
  };
  // Of a floating joint.
  struct Turn {
    std::size_t first;  // of the variables of its quaternion
    Quaternion from;
    Eigen::AngleAxisd whole;  // in the frame of `from`
  };

  // Of the joint above the link, with vectors in the joint's frame.
  JointTravel TravelOf(const ModelLink& link, std::span<const double> to);
  // Of the quaternion from variable `first` on; nullptr where it stays as it is.
  const Turn* AddTurn(std::size_t first, std::span<const double> to);
  // The link that the part hangs on: of what is carried the one that it is fixed to.
  int LinkOf(std::int32_t part) const;
  // How far any of its points is from the origin of that link.
  double Reach_m(std::int32_t part) const;
  // Of a part, by the joints above its link down to, and without, that of the link `above`.
  double TravelBelow_m(std::int32_t part, int above) const;
  template <class Of>
  double SumBelow_m(std::int32_t part, int above, Of&& of) const;
  int CommonAncestor(int link, int other) const;

  const RobotModel& model_;
  const QueryBody& body_;
  const Pose X_WB_;
  std::vector<double> from_, step_;  // of the variables; of quaternions see `turns_`
  std::vector<Turn> turns_;
  std::vector<JointTravel> joints_;  // by link, of the joint above it
};

}  // namespace cwm::collision
