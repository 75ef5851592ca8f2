// The usual value of something that is measured again and again while it rests.
#pragma once

#include <algorithm>

namespace cwm::perception {

struct UsualValue {
  // chosen: the mean of so many frames has an error of a quarter of one
  // frame's. Later the mean follows slow drift, as of a sensor that warms up,
  // within ten seconds at 30 Hz.
  static constexpr int kLearning_frames = 15;
  static constexpr int kMemory_frames = 300;

  float mean = 0;
  int frames = 0;

  bool HasLearnt() const { return frames >= kLearning_frames; }
  void Learn(float value) {
    frames = std::min(frames + 1, kMemory_frames);
    mean += (value - mean) / static_cast<float>(frames);
  }
};

}  // namespace cwm::perception
