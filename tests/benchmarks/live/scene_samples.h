// The samples of figures over many scenes. Each scene adds its lines to a file, so that a part can
// be measured in several calls: each goes on after the scenes that the file has.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tests/benchmarks/report.h"

namespace cwm::benchmarks {

class SceneSamples {
 public:
  // Reads the scenes of a part from the file, which need not exist. An empty path keeps samples in
  // memory alone. InvalidArgument for a line that this class did not write.
  static absl::StatusOr<SceneSamples> Read(const std::string& path, const std::string& part);

  int scene_count() const { return scene_count_; }
  // Adds a sample of the scene in progress; `key` has no spaces.
  void Add(const std::string& key, double value) { scene_[key].push_back(value); }
  // Takes the samples of the scene in progress to those of the others, and writes them.
  absl::Status EndScene();

  // Of all ended scenes; empty for an unknown key.
  std::vector<double> Of(const std::string& key) const;
  double Sum(const std::string& key) const;

 private:
  using Samples = std::map<std::string, std::vector<double>>;

  std::string path_, part_;
  int scene_count_ = 0;
  Samples ended_, scene_;
};

struct SceneOptions {
  double minutes = 0;        // after which no scene begins; one is measured at least
  std::string samples = {};  // the file of SceneSamples; empty: none
};

// Measures scenes, by numbers from that after the ended ones up to `max_count`, and ends each of
// them. `measure` adds the samples of a scene; its false is a failure that it reported. Empty after
// a failure.
std::optional<SceneSamples> MeasureScenes(
    const SceneOptions& options, const std::string& part, int max_count, Report& report,
    const std::function<bool(int scene, SceneSamples& samples)>& measure);

}  // namespace cwm::benchmarks
