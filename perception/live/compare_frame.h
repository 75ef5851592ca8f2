// Compares a frame with what is known, pixel by pixel.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/live/expected_gates.h"
#include "perception/live/frame_classes.h"
#include "perception/live/known_body.h"
#include "perception/live/pixel_lanes.h"
#include "perception/live/reference_image.h"
#include "perception/live/robot_mask.h"
#include "perception/live/seen_surface.h"

namespace cwm::perception {

struct KnownView {
  const std::vector<float>* expected_m = nullptr;  // infinite where nothing is expected
  const std::vector<BodyId>* body = nullptr;
  const ExpectedGates* gates = nullptr;
  const ReferenceImage* reference = nullptr;  // null: the sensor moves
  // The sensor has just begun to learn its reference: a pixel in which nothing is known makes no
  // block hot.
  bool is_first = false;
  // Only for a sensor that moves: what it saw before is consistent, modelled or not.
  const SeenSurface* seen = nullptr;
  Pose X_WC = Pose::Identity();  // used with `seen`
};

// Pixels by body and class. It keeps counts of those bodies alone that were counted, since ids are
// many and a sensor sees few.
class BodyPixels {
 public:
  BodyPixels();
  // The reference holds until another body is counted.
  PixelCounts& of(BodyId id);
  const PixelCounts& of(BodyId id) const { return counts_[place_[id]]; }
  void Clear();  // all counts are 0

 private:
  std::vector<std::uint32_t> place_;  // in `counts_`, by id; 0: the body was not counted
  std::vector<BodyId> counted_;
  std::vector<PixelCounts> counts_;  // the first one stays 0, the others are of `counted_`
};

// The counts of a block's pixels; `was_over` keeps the blocks that were hot by their own counts,
// which stay hot with half as many. `deviations` is used again from frame to frame.
struct BlockCounts {
  std::vector<std::uint8_t> nearer, farther;
  std::vector<std::uint8_t> was_over;
  std::vector<DeviatingPixels> deviations;
};

// chosen: so many pixels of a block that differ with one sign make it hot. An object of 20 x 20 mm
// at 1 m has a hundred, at least a quarter of them in one block; single pixels at edges differ by
// chance. Blocks with fewer pixels are never hot.
inline constexpr int kHotPixels = 12;

// Classifies the pixels of the image, counts them, by body too (all classes but kConsistent), and
// tells the hot blocks. A pixel of a robot's mask has the mask's class; a depth out of the camera's
// range is kMissing. A pixel with a reference is judged by it alone, others by the expected view.
void CompareFrame(const DepthImage& image, const DepthCamera& camera, const KnownView& known,
                  const RobotMask& robots, FrameClasses& classes, BodyPixels& by_body,
                  BlockCounts& blocks);

}  // namespace cwm::perception
