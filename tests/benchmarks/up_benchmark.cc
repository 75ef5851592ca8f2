// Up as it is found without help: scenes, mountings and frames of points that nobody tuned for.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "perception/cloud/parallel_for.h"
#include "perception/interpret_scene.h"
#include "perception/simulation/angles.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/quality/up_settings.h"

namespace cwm::benchmarks {
namespace {

constexpr int kUpThreads = 2;
constexpr double kRight_deg = 2;

struct UpOutcome {
  std::string failure;
  double error_deg = 0;
  bool is_warned = false;

  bool IsRight() const { return error_deg <= kRight_deg; }
};

bool IsOfUp(const std::string& warning) {
  return warning.find("up is") != std::string::npos || warning.find("up may") != std::string::npos;
}

UpOutcome Try(const UpSetting& setting) {
  const UpScan scan = ScanSetting(setting);
  perception::InterpretOptions options;
  options.max_threads = 1;
  const auto found = perception::InterpretScene(scan.cloud, options);
  if (!found.ok())
    return {.failure = setting.name() + ": " + std::string(found.status().message())};
  const Vector3 up = found->X_WC.linear().row(2);
  return {.failure = {},
          .error_deg = std::acos(std::clamp(up.dot(scan.up_C), -1.0, 1.0)) / perception::Radians(1),
          .is_warned = std::ranges::any_of(found->report.warnings, IsOfUp)};
}

struct UpTally {
  int all = 0, right = 0, wrong_unwarned = 0, right_warned = 0;
  void Add(const UpOutcome& outcome) {
    ++all;
    right += outcome.IsRight();
    wrong_unwarned += !outcome.IsRight() && !outcome.is_warned;
    right_warned += outcome.IsRight() && outcome.is_warned;
  }
};

std::string LineOf(const std::string& name, const UpTally& tally) {
  char text[160];
  std::snprintf(text, sizeof(text), "  %-24s %4d: %4d right, %3d wrong unwarned, %3d right warned",
                name.c_str(), tally.all, tally.right, tally.wrong_unwarned, tally.right_warned);
  return text;
}

}  // namespace

void MeasureUpOn(const Seeds& seeds, Report& report) {
  const std::vector<UpSetting> settings = UpSettings(seeds.first, seeds.count);
  std::vector<UpOutcome> outcomes(settings.size());
  perception::ParallelFor(settings.size(), 1, {.max_threads = kUpThreads},
                          [&](std::size_t begin, std::size_t end) {
                            for (std::size_t k = begin; k < end; ++k)
                              outcomes[k] = Try(settings[k]);
                          });
  UpTally total;
  std::map<std::string, UpTally> parts;
  std::vector<std::string> remarks;
  for (std::size_t k = 0; k < settings.size(); ++k) {
    const UpSetting& setting = settings[k];
    const UpOutcome& outcome = outcomes[k];
    if (!outcome.failure.empty()) {
      report.Fail(outcome.failure);
      continue;
    }
    total.Add(outcome);
    parts[std::string(kPlaceNames[static_cast<std::size_t>(setting.place)])].Add(outcome);
    parts[std::string(kMountingNames[static_cast<std::size_t>(setting.mounting)])].Add(outcome);
    parts[setting.is_list ? "lists" : "images"].Add(outcome);
    if (outcome.IsRight() && !outcome.is_warned) continue;
    char text[160];
    std::snprintf(text, sizeof(text), "%s: %.1f deg%s", setting.name().c_str(), outcome.error_deg,
                  outcome.is_warned ? ", warned" : "");
    remarks.emplace_back(text);
  }
  for (const auto& [name, tally] : parts) report.Detail(LineOf(name, tally));
  report.Attach("up_settings.txt", remarks);
  const std::string how =
      "of " + std::to_string(total.all) +
      " simulated settings: rooms, bins, shelves, tables, single things, kitchens; "
      "images and lists";
  const double wrong = std::max(1, total.all - total.right);
  report.Add({.key = "up_within_2deg",
              .value = static_cast<double>(total.right) / std::max(1, total.all),
              .unit = "1",
              .how = how});
  report.Add({.key = "up_unwarned",
              .value = total.wrong_unwarned / wrong,
              .unit = "1",
              .how = "wrong ones without a warning, " + how});
  report.Add({.key = "up_false_alarms",
              .value = static_cast<double>(total.right_warned) / std::max(1, total.right),
              .unit = "1",
              .how = "right ones with a warning, " + how});
}

void MeasureUp(Report& report) { MeasureUpOn(kSeedsOfUp, report); }

}  // namespace cwm::benchmarks
