// The order and the times in which frames and joint states arrive: late, doubled, swapped, lost.
#pragma once

#include <cstddef>
#include <vector>

#include "perception/simulation/sequence_script.h"

namespace cwm::perception {

// Stamps and deliveries count from the same moment as SequenceScript::start_stamp_s; deliveries are
// by the true clock, stamps by the clock of the sensor or of the robot.
struct FrameDelivery {
  int frame = 0;
  double stamp_s = 0;
  double delivery_s = 0;
};

// The frames of a sensor in the order of delivery. Lost frames do not appear, doubled ones twice;
// all choices are drawn from the script's seed.
std::vector<FrameDelivery> FrameDeliveries(const SequenceScript& script, std::size_t sensor);

struct JointStateDelivery {
  double stamp_s = 0;
  double delivery_s = 0;
  std::vector<double> values = {};  // by variable of the robot
};

// The states of a robot in the order of delivery, from 0.1 s before the script's begin, so that
// there is one before the first frame, to its end.
std::vector<JointStateDelivery> JointStateDeliveries(const SequenceScript& script,
                                                     std::size_t robot);

}  // namespace cwm::perception
