// The motion planner alone: the figures of ./dev bench people-planner, or of a part of the problems
// with other options.
#include <cstdlib>
#include <functional>
#include <map>
#include <string>

#include "tests/benchmarks/planner_benchmarks.h"
#include "tests/benchmarks/usage.h"

int main(int argc, char** argv) {
  constexpr char kUsage[] =
      "cwm-bench-planner [--json FILE] [--first N] [--step N] [--seed N] [--range D]\n"
      "                  [--samples N] [--rounds N] [--cuts N] [--time S] [--fcl 0|1]\n"
      "                  [--certify 0|1]\n";
  if (cwm::benchmarks::PrintsUsage(argc, argv, kUsage)) return 0;
  cwm::benchmarks::PlannerMeasure measure;
  cwm::planner::PlanOptions& options = measure.options;
  std::string json;
  const auto number = [](const std::string& word) { return std::strtod(word.c_str(), nullptr); };
  const auto count = [](const std::string& word) { return std::atoi(word.c_str()); };
  const std::map<std::string, std::function<void(const std::string&)>> words = {
      {"--json", [&](const std::string& word) { json = word; }},
      {"--first", [&](const std::string& word) { measure.first = std::stoul(word); }},
      {"--step", [&](const std::string& word) { measure.step = std::stoul(word); }},
      {"--seed",
       [&](const std::string& word) { options.seed = static_cast<std::uint32_t>(count(word)); }},
      {"--range", [&](const std::string& word) { options.connect.range = number(word); }},
      {"--samples", [&](const std::string& word) { options.connect.samples = count(word); }},
      {"--rounds", [&](const std::string& word) { options.shortening.rounds = count(word); }},
      {"--cuts", [&](const std::string& word) { options.shortening.shortcuts = count(word); }},
      {"--time", [&](const std::string& word) { options.time_limit_s = number(word); }},
      {"--fcl", [&](const std::string& word) { measure.beside_fcl = word != "0"; }},
      {"--certify", [&](const std::string& word) { measure.certify = word != "0"; }}};
  cwm::benchmarks::Report report;
  for (int i = 1; i < argc; i += 2) {
    const auto known = words.find(argv[i]);
    if (known == words.end() || i + 1 == argc) {
      report.Fail(std::string("takes pairs of an option and its value, not ") + argv[i]);
    } else {
      known->second(argv[i + 1]);
    }
  }
  if (!report.failed()) MeasurePlanner(measure, report);
  report.Print();
  if (!json.empty()) report.WriteJson(json);
  return report.failed() ? 1 : 0;
}
