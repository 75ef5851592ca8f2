// The frames that the joints of a group move, as SIMD code places them, with bounds on their
// rounding errors.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "collision/robot/robot_model.h"
#include "collision/spheres/lane_program.h"
#include "collision/spheres/revolute_pair.h"
#include "collision/spheres/sphere_program.h"

namespace cwm::collision {

class LaneFrames {
 public:
  // A frame that a joint of the group moves, with bounds that hold in every state.
  struct Frame {
    std::int32_t index = 0;
    std::size_t parent = 0;
    std::optional<RevoluteJoint> turning;  // its joint, if that is rotary
    SphereProgram::Ball reach;             // of its origin
    double rotation_error = 0;             // Frobenius norm
    double origin_error_m = 0;
  };
  // The pose of a link that is fixed in a frame.
  struct Fixed {
    std::size_t frame = 0;
    Pose X_FL = Pose::Identity();
  };

  // `base` has a value for each variable of the model; those of the group are not read. Empty if a
  // planar or floating joint of the group moves a link.
  static std::optional<LaneFrames> Of(const RobotModel& model, const JointGroup& group,
                                      std::span<const double> base,
                                      std::span<const FixedFrame> fixed_frames);

  const std::vector<Frame>& frames() const { return frames_; }  // [0] is the root
  // By link of the model, then by fixed frame.
  const std::vector<Fixed>& links() const { return links_; }
  const std::vector<LaneJoint>& joints() const { return joints_; }  // by frame
  const std::vector<LaneInput>& inputs() const { return inputs_; }  // by frame, from frame 1 on

 private:
  LaneFrames(const RobotModel& model, const JointGroup& group, std::span<const double> base);
  bool AddLinks();
  bool AddLink(std::size_t index);
  void AddJoint(const ModelLink& link, const Fixed& parent);
  Frame Below(const Frame& parent, const Vector3& shift, double travel_m) const;
  void AddFixedFrames(std::span<const FixedFrame> fixed_frames);

  const RobotModel* model_;
  std::vector<int> column_of_;  // by variable; -1: not in the group
  std::vector<Pose> X_BL_;      // in the base state
  std::vector<Frame> frames_;
  std::vector<Fixed> links_;
  std::vector<LaneJoint> joints_;
  std::vector<LaneInput> inputs_;
};

}  // namespace cwm::collision
