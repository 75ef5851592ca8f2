// The view of one running sensor: compares each frame with what is known, and learns what is at
// rest.
#pragma once

#include <memory>
#include <span>

#include "perception/live/frame_evidence.h"
#include "perception/live/robot_mask.h"

namespace cwm::perception {

// A frame as it came, ready to be compared.
struct SensorFrame {
  Stamp stamp = {};
  Pose X_WC = Pose::Identity();
  std::shared_ptr<const DepthImage> image = {};  // of the camera's size
};

// Not thread safe. Deterministic: its state follows from the calls alone.
class SensorView {
 public:
  SensorView(std::string sensor, const DepthCamera& camera, const SensorNoise& noise);
  ~SensorView();

  // Compares the frame with the bodies and with the reference, and lets the reference learn from
  // pixels at rest. Frames come in the order of their stamps. A change of X_WC forgets the
  // reference.
  FrameEvidence Observe(const SensorFrame& frame, std::span<const KnownBody> bodies,
                        const RobotMask& robots);

  // Takes the last frame as the reference in these blocks: what they show was interpreted, and the
  // world holds what could be told of it.
  void Accept(std::span<const std::int32_t> blocks);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cwm::perception
