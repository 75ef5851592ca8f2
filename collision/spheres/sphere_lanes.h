// States of a robot of spheres against obstacles and itself, one state a lane of the machine's
// widest vectors: taken at run time, by Highway.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "collision/spheres/lane_program.h"

namespace cwm::collision {

enum class LaneVerdict : std::uint8_t {
  kFree,
  kHit,   // some sphere surely touches
  kOpen,  // too near to contact for single precision, or near a hull
};

// What LoadStates says of a state.
enum class StateMark : std::uint8_t {
  kReady = 0,
  kTooFar = 1,       // a value that lanes cannot take
  kOutOfLimits = 2,  // or not a number
};

// Values of `count` rows, each `width` wide, as JudgeStates takes them: joint after joint, `stride`
// apart. What moves is found in double precision. Of values beyond `count` up to `stride`, which is a
// multiple of kMostLanes, nothing is known.
void LoadStates(std::span<const LaneInput> inputs, const double* rows, std::size_t width,
                std::size_t count, std::size_t stride, float* values, StateMark* marks);

// Memory of one thread's calls.
struct LaneMemory {
  std::vector<float> numbers;
  std::vector<std::int32_t> indices;
};

// `values` hold the joints' values frame after frame from frame 1 on, each `stride` apart, angles
// within [-pi, pi]; `count` states of them are answered. A lane's answer depends on that lane
// alone, and on the instruction set in kOpen alone.
void JudgeStates(const LaneProgram& program, const LaneScene& scene, const float* values,
                 std::size_t stride, std::size_t count, LaneMemory& memory, LaneVerdict* verdicts);

// Where a state is not shown to be free, by tag.
struct LaneOpen {
  std::uint64_t worlds = 0;  // of clusters that may meet obstacles
  std::uint64_t pairs = 0;   // of pairs of clusters that may meet
};

// The same for spheres that contain what is asked about: what they are clear of is free, and
// nothing is known of the rest.
void FindOpen(const LaneProgram& program, const LaneScene& scene, const float* values,
              std::size_t stride, std::size_t count, LaneMemory& memory, LaneOpen* open);

// The greatest number of lanes that a machine has: `stride` is a multiple.
inline constexpr std::size_t kMostLanes = 16;

// Of the instruction set that answers, e.g. "AVX3".
const char* LaneTarget();

// No sine or cosine of JudgeStates is off by more, its angle's rounding included.
inline constexpr double kSineError = 2.5e-7;

// For tests: what JudgeStates takes for the sines and cosines of `count` angles.
void LaneSines(const float* angles, std::size_t count, float* sines, float* cosines);

// Cells of one value's range, each with bits of a key.
struct CellKeys {
  float lower = 0, cells_per_unit = 0;
  std::vector<std::uint32_t> key_of_cell;  // at least one; of what lies beyond, the first and last
};
// Sets in each key the bits of the cell that its value, a finite one, lies in.
void AddKeys(const CellKeys& cells, const float* values, std::size_t count, std::uint32_t* keys);

}  // namespace cwm::collision
