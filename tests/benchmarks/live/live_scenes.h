// The simulated scenes of the figures of live sensors: a table with household things, and
// depth cameras on stands.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "perception/simulation/sequence_script.h"

namespace cwm::benchmarks {

struct TableOptions {
  int thing_count = 20;  // at most 20
  double duration_s = 60;
  std::uint64_t seed = 1;
  int sensor_count = 1;  // at most 3: before, left and right of the table
};

inline constexpr double kTableTop_m = 0.75;
// The index of the first thing among the objects of the scene, after the table.
inline constexpr std::size_t kFirstThing = 1;

// Boxes, cans, balls and cups of random sizes in a grid on the table, at least 5 cm apart, all at
// rest. Fixed Kinects of 640 x 480 pixels at 30 Hz. No robots, hands or events.
perception::SequenceScript TableScript(const TableOptions& options);

// That table, with a thing of the front row that goes 8 cm towards the first sensor and back, at 4
// cm/s, again and again from `begin_s` on.
perception::SequenceScript PushedThing(double begin_s, const TableOptions& table);

// Divides the images of all sensors by this in width and height; they show the same.
void ScaleDown(int by, perception::SequenceScript& script);

}  // namespace cwm::benchmarks
