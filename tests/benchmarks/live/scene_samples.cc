#include "tests/benchmarks/live/scene_samples.h"

#include <chrono>
#include <fstream>
#include <iomanip>
#include <numeric>
#include <sstream>
#include <utility>

#include "absl/strings/str_cat.h"

namespace cwm::benchmarks {

// A scene is one line, so that a call that is stopped leaves whole scenes: PART KEY COUNT VALUE...
// KEY COUNT VALUE...
absl::StatusOr<SceneSamples> SceneSamples::Read(const std::string& path, const std::string& part) {
  SceneSamples samples;
  samples.path_ = path;
  samples.part_ = part;
  if (path.empty()) return samples;
  std::ifstream file(path);
  int number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    std::istringstream words(line);
    std::string of_part, key;
    words >> of_part;
    if (of_part != part) continue;
    std::size_t count = 0;
    bool is_whole = true;
    while (is_whole && words >> key) {
      std::vector<double>& values = samples.ended_[key];
      is_whole = static_cast<bool>(words >> count);
      double value = 0;
      for (std::size_t i = 0; is_whole && i < count; ++i) {
        is_whole = static_cast<bool>(words >> value);
        values.push_back(value);
      }
    }
    if (!is_whole) {
      return absl::InvalidArgumentError(
          absl::StrCat(path, ", line ", number, ": is no line of samples of ", part));
    }
    ++samples.scene_count_;
  }
  return samples;
}

absl::Status SceneSamples::EndScene() {
  std::ostringstream line;
  line << part_ << std::setprecision(17);
  for (const auto& [key, values] : scene_) {
    line << ' ' << key << ' ' << values.size();
    std::vector<double>& ended = ended_[key];
    for (const double value : values) {
      line << ' ' << value;
      ended.push_back(value);
    }
  }
  scene_.clear();
  ++scene_count_;
  if (path_.empty()) return absl::OkStatus();
  std::ofstream file(path_, std::ios::app);
  file << line.str() << '\n';
  file.flush();
  return file ? absl::OkStatus() : absl::UnavailableError(absl::StrCat("cannot write ", path_));
}

std::vector<double> SceneSamples::Of(const std::string& key) const {
  const auto found = ended_.find(key);
  return found == ended_.end() ? std::vector<double>() : found->second;
}

double SceneSamples::Sum(const std::string& key) const {
  const std::vector<double> values = Of(key);
  return std::accumulate(values.begin(), values.end(), 0.0);
}

std::optional<SceneSamples> MeasureScenes(
    const SceneOptions& options, const std::string& part, int max_count, Report& report,
    const std::function<bool(int scene, SceneSamples& samples)>& measure) {
  auto samples = SceneSamples::Read(options.samples, part);
  if (!samples.ok()) {
    report.Fail(std::string(samples.status().message()));
    return std::nullopt;
  }
  const auto start = std::chrono::steady_clock::now();
  const auto is_late = [&] {
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
    return time.count() >= 60 * options.minutes;
  };
  for (bool is_first = true; samples->scene_count() < max_count && (is_first || !is_late());
       is_first = false) {
    if (!measure(samples->scene_count(), *samples)) return std::nullopt;
    if (const absl::Status ended = samples->EndScene(); !ended.ok()) {
      report.Fail(std::string(ended.message()));
      return std::nullopt;
    }
  }
  return *std::move(samples);
}

}  // namespace cwm::benchmarks
