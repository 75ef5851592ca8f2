// ./dev bench: figures with their rivals by group, or micro-benchmarks by name.
//   cwm-bench [main|perception|perception-quick|collision|collision-(pairs|robots|samples|worlds)|people|server] [--json FILE]
//   cwm-bench scene FAMILY SEED      one of the random scenes, shape by shape
//   cwm-bench REGEX                  micro-benchmarks whose names match
#include <benchmark/benchmark.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/server/server_benchmarks.h"

namespace {

using cwm::benchmarks::Report;

const std::map<std::string, std::vector<std::function<void(Report&)>>>& Groups() {
  using namespace cwm::benchmarks;
  static const std::map<std::string, std::vector<std::function<void(Report&)>>> groups = {
      {"main", {MeasureInterpreter, MeasureEngines, MeasureService}},
      {"perception",
       {MeasureInterpreter, MeasureScans, MeasureShapes, MeasureHandles, MeasureClaims,
        MeasureFitting, MeasureBadInput, MeasureGrowth}},
      {"perception-quick", {MeasureShapesQuickly}},
      {"perception-shapes", {MeasureShapes}},
      {"perception-handles", {MeasureHandles}},
      {"perception-scans", {MeasureScans}},
      {"perception-claims", {MeasureClaims}},
      {"perception-fit", {MeasureFitting}},
      {"perception-bad", {MeasureBadInput}},
      {"perception-growth", {MeasureGrowth}},
      {"collision",
       {MeasureOracles, MeasurePairs, MeasureEngines, MeasureSamples, MeasureWorlds,
        MeasurePublishing, MeasureLargeMesh, MeasureRobots, MeasureUnexplained, MeasureSpheres,
        MeasureMotions, MeasureRobotStream, MeasureRobotLatency}},
      {"collision-pairs", {MeasureOracles, MeasurePairs}},
      {"collision-robots", {MeasureRobots, MeasureUnexplained, MeasureRobotStream}},
      {"collision-spheres", {MeasureSpheres}},
      {"collision-motions", {MeasureMotions}},
      {"collision-latency", {MeasureRobotLatency}},
      {"collision-samples", {MeasureSamples}},
      {"collision-worlds", {MeasureWorlds, MeasurePublishing, MeasureLargeMesh}},
      {"people", {MeasurePython, MeasurePlanning, MeasureGrasps, MeasureViewer}},
      {"people-grasps", {MeasureGrasps}},
      {"people-planner", {MeasurePlanning}},
      {"people-viewer", {MeasureViewer}},
      {"server", {MeasureServer}},
      {"server-amplification", {MeasureAmplification}},
      {"server-listener", {MeasureListener}},
      {"server-memory", {MeasureMemoryReturned}},
      {"server-overload", {MeasureOverload}},
      {"server-stops", {MeasureStops}},
  };
  return groups;
}

int RunMatching(char* program, const std::string& regex) {
  std::string filter = "--benchmark_filter=" + regex;
  std::vector<char*> arguments = {program, filter.data()};
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  return benchmark::RunSpecifiedBenchmarks() > 0 ? 0 : 1;
}

int Replay(const std::vector<std::string>& words) {
  if (words.size() != 3) {
    std::printf("scene takes a family (table, clutter, kitchen or vessels) and a seed\n");
    return 1;
  }
  Report report;
  cwm::benchmarks::ReplayScene(words[1], std::strtoull(words[2].c_str(), nullptr, 10), "", report);
  return report.failed() ? 1 : 0;
}

int RunGroup(const std::string& name, const std::string& json) {
  const std::vector<std::function<void(Report&)>>& measures = Groups().at(name);
  Report report;
  if (measures.empty()) std::printf("no benchmark of the group %s exists yet\n", name.c_str());
  for (const auto& measure : measures) measure(report);
  report.Print();
  if (!json.empty()) report.WriteJson(json);
  return report.failed() ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> words;
  std::string json;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--json") == 0 && i + 1 < argc) {
      json = argv[++i];
    } else {
      words.emplace_back(argv[i]);
    }
  }
  if (words.empty()) words.emplace_back("main");
  if (words[0] == "scene") return Replay(words);
  return Groups().count(words[0]) ? RunGroup(words[0], json) : RunMatching(argv[0], words[0]);
}
