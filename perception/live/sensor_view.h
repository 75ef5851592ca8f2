// The view of one running sensor: compares each frame with what is known, and learns what is at
// rest.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "perception/live/expected_view.h"
#include "perception/live/frame_evidence.h"
#include "perception/live/robot_mask.h"

namespace cwm::perception {

// A frame as it came, ready to be compared.
struct SensorFrame {
  Stamp stamp = {};
  Pose X_WC = Pose::Identity();
  std::shared_ptr<const DepthImage> image = {};  // of the camera's size
  PoseSigma pose_sigma = {};                     // of X_WC; zero: exact
  bool may_move = false;  // the pose is one of the frame, and not of the sensor
};

// Not thread safe. Deterministic: its state follows from the calls alone.
class SensorView {
 public:
  SensorView(std::string sensor, const DepthCamera& camera, const SensorNoise& noise);
  ~SensorView();

  // The view of the bodies that the next frame will be compared with, for those who need it before
  // Observe, such as the robot's mask. Observe does not render it again, unless it corrects the
  // pose of a sensor that moves.
  const ExpectedView& Expect(std::span<const KnownBody> bodies, const Pose& X_WC);

  // Compares the frame with the bodies and with the reference, and lets the reference learn from
  // pixels at rest. Frames come in the order of their stamps. A change of X_WC forgets the
  // reference. The bodies have different ids.
  //
  // The pose of a sensor that moves is corrected, within its standard deviations, by the known
  // surfaces that the frame shows (EstimatePose); the evidence has the corrected pose. The
  // correction stays while the sensor then stands.
  //
  // Until the reference is usable (three frames), and while the sensor moves, frames are compared
  // with the expected view alone. The first frames become the reference except where they
  // contradict a known body; such places stay hot until the world or Accept resolves it.
  // When a body is given another pose, the reference moves with it; when a body comes, goes or
  // changes, the reference is kept in pixels that still look as before, and learnt anew in others.
  FrameEvidence Observe(const SensorFrame& frame, std::span<const KnownBody> bodies,
                        const RobotMask& robots);

  // Remembers what an earlier frame showed in these blocks: it was interpreted, and the world holds
  // these bodies now. While the sensor moves, surfaces that were seen before are consistent,
  // modelled or not.
  void Remember(const FrameEvidence& frame, std::span<const std::int32_t> blocks,
                std::span<const KnownBody> bodies);

  // Takes the last frame as the reference in these blocks: what they show was interpreted, and the
  // world holds what could be told of it. Not in pixels of robots, nor while the sensor moves.
  void Accept(std::span<const std::int32_t> blocks);

  // Tells that bodies may have been made of what this earlier frame showed in these blocks. Where
  // the reference holds something else, that has left since: such a body is not explained by what
  // looks as before, and is told to be seen through.
  void NoteInterpreted(const FrameEvidence& frame, std::span<const std::int32_t> blocks);

  // The pixels in which robots hid what an earlier frame might have shown were not interpreted with
  // it: the reference knows nothing there, so that what has come to light since is told.
  void ForgetHidden(const FrameEvidence& frame);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cwm::perception
