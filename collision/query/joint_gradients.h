// Derivatives of a robot's distances by its joints.
//
// The signed distance d of a pair has the derivative dd/dq = -n . (J(p_A) - J(p_B)) by a variable
// q. n is the unit normal from the body A to the object B, p_A and p_B are the witness points, and
// J is the velocity of the point as fixed to its link. This is the envelope theorem: the witness
// points also slide along the surfaces, which changes the distance in second order only. It holds
// apart and overlapping. For an object of the world J(p_B) is 0; for a self pair only the joints
// between the two links count.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "collision/kernels/pair_distance.h"
#include "collision/query/query.h"
#include "collision/query/robot_body.h"

namespace cwm::collision {

// chosen: pairs and points whose distances differ by no more than this count as equally near. It
// lies above the rounding of coordinates, and random states hardly ever come so near to a kink.
inline constexpr double kTieTolerance_m = 1e-9;

// Used by one thread. Refers to the body and the rows.
//
// Joints about an axis turn, in m/rad; prismatic joints and translations of planar and floating
// joints slide, in m/m. A component of a floating joint's quaternion has the derivative of the
// distance by that component, in m, with the quaternion normalised as in the kinematics; it is 0
// along the quaternion itself. A mimic joint adds to the variable that it follows. Attached objects
// move with their link.
class JointGradients {
 public:
  JointGradients(const QueryBody& body, const JointRows& rows);

  std::size_t width() const { return width_; }

  // Computes the joints' axes at the row, where the links have the poses X_WL; further frames are
  // ignored.
  void Place(std::size_t row, std::span<const Pose> X_WL);

  // Appends the derivatives by the variables of a row, in the order of the group. `frame` is that
  // of the body's part. `other_frame` is that of the other part of a self pair, and negative for a
  // pair with the world.
  void Append(const PairDistance& answer, int frame, int other_frame,
              std::vector<double>& column) const;

 private:
  enum class Kind { kTurn, kSlide, kQuaternion };
  // The motion of a link by one variable of the group.
  struct LinkMotion {
    int link = 0;
    Kind kind = Kind::kTurn;
    std::size_t column = 0;  // of the variable in a row
    double multiplier = 1;
    Vector3 axis_J = Vector3::UnitZ();
    int component = 0;  // of a quaternion: 0 to 3 for x, y, z, w
  };
  // The velocity of a point p: angular x (p - origin) + linear.
  struct Twist {
    Vector3 origin_W = Vector3::Zero();
    Vector3 angular_W = Vector3::Zero();
    Vector3 linear_W = Vector3::Zero();
  };

  void AddMotions(int link);
  // The motions of the links from the root to the frame.
  const std::vector<std::size_t>& MotionsOf(int frame) const;
  void AddTo(double* gradient, std::size_t motion, double sign, const Vector3& p_W,
             const Vector3& normal_W) const;

  const QueryBody& body_;
  const JointRows& rows_;
  const std::size_t width_;
  std::vector<LinkMotion> motions_;                // ordered by link
  std::vector<std::vector<std::size_t>> by_link_;  // indices of motions_, from the root
  std::vector<Twist> twists_;                      // of the motions at the row
};

}  // namespace cwm::collision
