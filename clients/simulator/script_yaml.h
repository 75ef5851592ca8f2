// The parts of a script's reader. Each reads one list of the script and adds to what was read
// before.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "clients/simulator/script_file.h"
#include "clients/simulator/yaml_node.h"

namespace cwm::simulator {

// Numbers with a rule; `otherwise` is returned if the node is not present.
absl::StatusOr<double> ReadPositive(const YamlNode& node);
absl::StatusOr<double> ReadNumberOr(const YamlNode& node, double otherwise);
absl::StatusOr<double> ReadSecondsOr(const YamlNode& node, double otherwise);  // at least 0
absl::StatusOr<double> ReadRateOr(const YamlNode& node, double otherwise);     // (0, kMaxRate_hz]
// A time of the script, from 0 to its duration.
absl::StatusOr<double> ReadTime(const YamlNode& node, double duration_s);

// The time_s of each element of a list, which is not empty; times ascend.
absl::StatusOr<std::vector<double>> ReadTimes(const YamlNode& list, double duration_s);

// The index of the text of `node` among names of a kind; the error lists them.
absl::StatusOr<std::size_t> ReadNameOf(const YamlNode& node, const std::string& kind,
                                       const std::vector<std::string>& names);

// A name, not among `taken`, of letters, digits, '_', '-' and '.', so that it may be a folder's.
absl::StatusOr<std::string> ReadNewName(const YamlNode& node,
                                        const std::vector<std::string>& taken);

std::vector<std::string> RobotNames(const perception::SequenceScript& script);
std::vector<std::string> HandNames(const perception::SequenceScript& script);

// "robot" and "link" of a map.
absl::StatusOr<perception::LinkRef> ReadLinkRef(const YamlNode& node,
                                                const perception::SequenceScript& script);

// `view_camera` is that of the scene: what a sensor does not tell.
absl::Status ReadSensors(const YamlNode& node, const perception::PinholeCamera& view_camera,
                         perception::SequenceScript& script);
absl::Status ReadRobots(const YamlNode& node, ScriptFile& file);
absl::Status ReadHands(const YamlNode& node, perception::SequenceScript& script);
absl::Status ReadEvents(const YamlNode& node, perception::SequenceScript& script);

}  // namespace cwm::simulator
