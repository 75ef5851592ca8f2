// ./dev bench: figures with their baselines by group, or micro-benchmarks by name (see kUsage).
#include <benchmark/benchmark.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/live/live_benchmarks.h"
#include "tests/benchmarks/server/server_benchmarks.h"
#include "tests/benchmarks/store/store_benchmarks.h"
#include "tests/benchmarks/usage.h"

namespace {

using cwm::benchmarks::Report;

constexpr char kUsage[] =
    "cwm-bench [GROUP] [--json FILE]     figures of a group (default: main), also written to FILE\n"
    "cwm-bench scene FAMILY SEED         one of the random scenes, shape by shape; families as of\n"
    "                                    cwm-simulator --random\n"
    "cwm-bench REGEX                     micro-benchmarks whose names match\n";

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
      {"perception-families", {MeasureFamilies}},
      {"perception-ablate", {MeasureAblation}},
      {"strangers", {MeasureUp, MeasureLists, MeasureHidden, MeasureThin, MeasureCost}},
      {"planners", {MeasureInverseKinematics, MeasureEdges}},
      {"perception-labelled", {MeasureLabelledScans}},
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
      {"live", {MeasureLive}},
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
      {"store", {MeasureStore}},
  };
  return groups;
}

std::string GroupList() {
  std::string list = "groups:";
  for (const auto& [name, measures] : Groups()) list += " " + name;
  return list + "\n";
}

int RunMatching(char* program, const std::string& regex) {
  std::string filter = "--benchmark_filter=" + regex;
  std::vector<char*> arguments = {program, filter.data()};
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::RunSpecifiedBenchmarks() > 0) return 0;
  std::fprintf(stderr, "no group and no micro-benchmark is called %s; %s", regex.c_str(),
               GroupList().c_str());
  return 1;
}

int Replay(const std::vector<std::string>& words) {
  if (words.size() != 3) {
    std::printf("scene takes a family, as of cwm-simulator --random, and a seed\n");
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
  const std::string usage = std::string(kUsage) + GroupList();
  if (cwm::benchmarks::PrintsUsage(argc, argv, usage.c_str())) return 0;
  std::vector<std::string> words;
  std::string json;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--json") == 0 && i + 1 < argc) {
      json = argv[++i];
    } else if (argv[i][0] == '-') {  // Google Benchmark's negative filter
      std::fprintf(stderr, "unknown option %s\n%s", argv[i], usage.c_str());
      return 1;
    } else {
      words.emplace_back(argv[i]);
    }
  }
  if (words.empty()) words.emplace_back("main");
  if (words[0] == "scene") return Replay(words);
  return Groups().count(words[0]) ? RunGroup(words[0], json) : RunMatching(argv[0], words[0]);
}
