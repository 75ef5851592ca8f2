// The rows of a body as waypoints of its paths.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "collision/motion/body_motion.h"

namespace cwm::collision {

// Thread safe.
class Waypoints {
 public:
  virtual ~Waypoints() = default;
  virtual std::size_t size() const = 0;
  // IsWithinLimits and VariableOutOfLimits are as in BodyRows.
  virtual bool IsWithinLimits(std::size_t) const { return true; }
  virtual std::optional<int> VariableOutOfLimits(std::size_t) const { return std::nullopt; }
  // The rows of a robot; nullptr for other bodies.
  virtual const JointRows* joint_rows() const { return nullptr; }
  // The motion from a row to the next. Refers to everything that the waypoints refer to.
  virtual std::unique_ptr<BodyMotion> MotionFrom(std::size_t row) const = 0;
};

// Waypoints of a rigid body. Refers to the body and the poses.
class PoseWaypoints : public Waypoints {
 public:
  PoseWaypoints(const QueryBody& body, std::span<const Pose> X_WB) : body_(body), X_WB_(X_WB) {}

  std::size_t size() const override { return X_WB_.size(); }
  std::unique_ptr<BodyMotion> MotionFrom(std::size_t row) const override {
    return std::make_unique<RigidMotion>(body_, X_WB_[row], X_WB_[row + 1]);
  }

 private:
  const QueryBody& body_;
  const std::span<const Pose> X_WB_;
};

// Waypoints of a robot, connected by JointMotion. Refers to the model, and to a body of it.
class JointWaypoints : public Waypoints {
 public:
  JointWaypoints(const RobotModel& model, const QueryBody& body, const JointRows& rows)
      : model_(model), body_(body), rows_(rows) {}

  std::size_t size() const override { return rows_.size(); }
  bool IsWithinLimits(std::size_t row) const override { return rows_.IsWithinLimits(row); }
  std::optional<int> VariableOutOfLimits(std::size_t row) const override {
    return rows_.VariableOutOfLimits(row);
  }
  const JointRows* joint_rows() const override { return &rows_; }
  std::unique_ptr<BodyMotion> MotionFrom(std::size_t row) const override {
    return std::make_unique<JointMotion>(model_, body_, rows_.states().X_WB, rows_.State(row),
                                         rows_.State(row + 1));
  }

 private:
  const RobotModel& model_;
  const QueryBody& body_;
  const JointRows rows_;
};

}  // namespace cwm::collision
