// Writes a sequence as a folder of depth images with their truth. The format: sequence_format.md.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "clients/simulator/script_file.h"
#include "perception/simulation/sequence_renderer.h"

namespace cwm::simulator {

// derived: the unit of the depth images: 65535 of it are 13 m, beyond the range of the sensors, and
// it is finer than their noise.
inline constexpr double kDepthUnit_m = 0.0002;

// The values of label images besides 0, nothing, and i + 1, the i-th object of the scene. Hands and
// robots count from these values on; more than kMaxLabelled share the last one.
inline constexpr std::uint16_t kHandLabel = 60'000;
inline constexpr std::uint16_t kRobotLabel = 61'000;
inline constexpr std::uint16_t kMixedLabel = 65'000;  // between two surfaces
inline constexpr std::size_t kMaxLabelled = 1'000;

// Per pixel of a frame, in units of kDepthUnit_m; 0: no return.
std::vector<std::uint16_t> DepthImageOf(const perception::SequenceFrame& frame);
std::vector<std::uint16_t> LabelImageOf(const perception::SequenceFrame& frame,
                                        const std::vector<perception::SequenceBody>& bodies);

// Writes the folder, which is made if it does not exist; files in it of the same names are
// replaced.
absl::Status WriteSequence(const std::string& folder, const ScriptFile& file, bool with_labels);

}  // namespace cwm::simulator
