// Checks states of a robot of spheres against obstacles and the robot itself, one state per SIMD
// lane. Highway chooses the widest vectors of the machine at run time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "collision/spheres/lane_program.h"

namespace cwm::collision {

enum class LaneVerdict : std::uint8_t {
  kFree,
  kHit,         // some sphere certainly touches
  kUnresolved,  // too near to contact for single precision, or near a hull
};

// The result of LoadStates for a state.
enum class StateMark : std::uint8_t {
  kReady = 0,
  kTooFar = 1,       // a value outside the range of the SIMD code
  kOutOfLimits = 2,  // or not a number
};

// Converts `count` rows of `width` numbers into the layout that CheckStates takes: one joint after
// the other, `stride` values apart. The joints' values are computed in double precision. `stride`
// is a multiple of kMaxLanes; values from `count` to `stride` are undefined.
void LoadStates(std::span<const LaneInput> inputs, const double* rows, std::size_t width,
                std::size_t count, std::size_t stride, float* values, StateMark* marks);

// Working memory for the calls of one thread.
struct LaneMemory {
  std::vector<float> numbers;
  std::vector<double> reals;
  std::vector<std::int32_t> indices;
};

// The clusters and pairs for which a state is not shown to be free, by tag.
struct UnresolvedTags {
  std::uint64_t worlds = 0;  // of clusters that may touch obstacles
  std::uint64_t pairs = 0;   // of pairs of clusters that may touch
};

// Computes the verdicts of `count` states, and for those that are kUnresolved what is left to be
// tested. `values` has the values of the joints, one frame after the other from frame 1 on,
// `stride` values apart, with angles within [-pi, pi]. The verdict of a state depends on that state
// alone; the instruction set can only affect whether it is kUnresolved.
void CheckStates(const LaneProgram& program, const LaneScene& scene, const float* values,
                 std::size_t stride, std::size_t count, LaneMemory& memory, LaneVerdict* verdicts,
                 UnresolvedTags* open);

// The largest number of lanes of any machine; `stride` is a multiple of it.
inline constexpr std::size_t kMaxLanes = 16;

// The name of the instruction set in use, e.g. "AVX3".
const char* LaneTarget();

// A bound on the error of a sine or cosine in CheckStates, including the rounding of the angle.
inline constexpr double kSineError = 2.5e-7;

// The sines and cosines of `count` angles as CheckStates computes them, for tests.
void LaneSines(const float* angles, std::size_t count, float* sines, float* cosines);

// Equal cells of a value's range, each with some bits of a key.
struct CellKeys {
  float lower = 0, cells_per_unit = 0;
  std::vector<std::uint32_t> key_of_cell;  // at least one; values outside take the first or last
};
// Sets in each key the bits of its value's cell. The values are finite.
void AddKeys(const CellKeys& cells, const float* values, std::size_t count, std::uint32_t* keys);

}  // namespace cwm::collision
