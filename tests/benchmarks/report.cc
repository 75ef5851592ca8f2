#include "tests/benchmarks/report.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

namespace cwm::benchmarks {

Figure AsRatio(Figure times) {
  assert(times.ratio.has_value() && times.baseline_value.has_value());
  char text[160];
  std::snprintf(text, sizeof(text), "; ours %.4g %s, %s %.4g %s", times.value, times.unit.c_str(),
                times.baseline.c_str(), *times.baseline_value, times.unit.c_str());
  return {.key = std::move(times.key),
          .value = *times.ratio,
          .unit = "1",
          .baseline = std::move(times.baseline),
          .ratio = times.ratio,
          .how = times.how + text};
}

void Report::Add(Figure figure) { figures_.push_back(std::move(figure)); }

void Report::Detail(const std::string& text) {
  std::printf("%s\n", text.c_str());
  std::fflush(stdout);
}

void Report::Fail(const std::string& text) {
  Detail("FAILED: " + text);
  failed_ = true;
}

void Report::Attach(const std::string& name, std::vector<std::string> lines) {
  attached_.emplace_back(name, std::move(lines));
}

void Report::Print() const {
  if (figures_.empty()) return;
  std::printf("\n%-32s %12s %-8s %-26s %12s %8s\n", "key", "value", "unit", "baseline", "its value",
              "ratio");
  for (const Figure& figure : figures_) {
    std::printf("%-32s %12.4g %-8s %-26s", figure.key.c_str(), figure.value, figure.unit.c_str(),
                figure.baseline.empty() ? "-" : figure.baseline.c_str());
    if (figure.baseline_value) {
      std::printf(" %12.4g", *figure.baseline_value);
    } else if (figure.ratio) {
      std::printf(" %12s", "-");
    }
    if (figure.ratio) std::printf(" %8.2f", *figure.ratio);
    std::printf("\n    %s\n", figure.how.c_str());
  }
}

void Report::WriteJson(const std::string& path) const {
  using nlohmann::json;
  json rows = json::array();
  for (const Figure& figure : figures_) {
    rows.push_back({{"key", figure.key},
                    {"value", figure.value},
                    {"unit", figure.unit},
                    {"rival", figure.baseline.empty() ? json() : json(figure.baseline)},
                    {"rival_value", figure.baseline_value ? json(*figure.baseline_value) : json()},
                    {"ratio", figure.ratio ? json(*figure.ratio) : json()},
                    {"how", figure.how}});
  }
  std::ofstream(path) << rows.dump(2) << "\n";
  for (const auto& [name, lines] : attached_) {
    std::ofstream file(std::filesystem::path(path).replace_filename(name));
    for (const std::string& line : lines) file << line << "\n";
  }
}

double Median(std::vector<double> values) { return Quantile(std::move(values), 0.5); }

double Quantile(std::vector<double> values, double p) {
  if (values.empty()) return std::nan("");
  const auto rank = static_cast<std::size_t>(std::ceil(p * static_cast<double>(values.size())));
  const std::size_t index = std::clamp<std::size_t>(rank, 1, values.size()) - 1;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(index),
                   values.end());
  return values[index];
}

}  // namespace cwm::benchmarks
