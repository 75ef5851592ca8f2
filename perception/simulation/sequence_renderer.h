// Renders the frames of a script: what each sensor measures, and the truth of that moment.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "perception/simulation/frame_errors.h"
#include "perception/simulation/sequence_script.h"

namespace cwm::perception {

// An object at the moment of a frame, seen from its sensor.
struct ObjectTruth {
  ObjectState state = {};
  std::int64_t pixel_count = 0;  // pixels of the frame that measure it
  // Of the pixels in which an ideal camera would see it if it were alone, the share in which it is
  // the nearest; 0 if there are none.
  double visible_share = 0;
};

struct SequenceFrame {
  int index = 0;
  double time_s = 0;   // of the script
  double stamp_s = 0;  // as the sensor tells it
  PinholeCamera camera = {};
  // `depth.object` is an index into SequenceRenderer::bodies.
  MeasuredDepth depth = {};
  std::vector<ObjectTruth> objects = {};
  std::vector<std::vector<double>> joint_values = {};  // by robot
  std::int64_t hand_pixel_count = 0;
  std::int64_t robot_pixel_count = 0;
  std::int64_t mixed_pixel_count = 0;
};

// A body of the rendered scene: an object of the scene, a hand, or a link of a robot.
struct SequenceBody {
  enum class Kind { kObject, kHand, kRobot };
  Kind kind = Kind::kObject;
  std::size_t index = 0;  // into the script's objects, hands or robots
  std::size_t link = 0;   // of a robot
};

// Immutable once made, so that several threads may render; frames do not depend on the order in
// which they are asked for. A static scene seen by a fixed sensor is rendered once; frames of it
// cost the drawing of what may move, and their noise.
class SequenceRenderer {
 public:
  // The script must be sound: indices exist, names differ, times ascend.
  explicit SequenceRenderer(SequenceScript script);

  const SequenceScript& script() const { return script_; }
  const std::vector<SequenceBody>& bodies() const { return bodies_; }

  // `sensor` is an index into the script's sensors; `frame` is in [0, FrameCount).
  SequenceFrame Render(std::size_t sensor, int frame) const;

 private:
  // A view of bodies, with what they hide of each other.
  struct View {
    RangeImage image;
    std::vector<std::int64_t> alone;  // by body, the pixels that it would have alone
    DeviceReturns returns;
  };

  View RenderAll(const SimulatedScene& scene, const PinholeCamera& camera,
                 const DeviceErrors& device) const;
  // Draws what may move over the view of what does not.
  View RenderOver(const View& still, const SimulatedScene& scene, const PinholeCamera& camera,
                  const DeviceErrors& device) const;
  SimulatedScene BodiesAt(const SequenceState& state) const;
  bool IsStill(std::size_t body) const { return is_still_[body]; }

  SequenceScript script_;
  std::vector<SequenceBody> bodies_;
  SimulatedScene shapes_;                   // of the bodies, in their order
  std::vector<bool> is_still_;              // by body: it never moves
  std::vector<DeviceErrors> devices_;       // by sensor
  std::vector<std::optional<View>> still_;  // by sensor; empty if the sensor moves
};

}  // namespace cwm::perception
