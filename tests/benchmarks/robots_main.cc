// The figures of robots in planning problems: quick to build while working on collision. Prints the
// same figures as ./dev bench collision-robots, collision-motions, collision-spheres and
// collision-latency; also the stream alone.
#include <string>
#include <vector>

#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/usage.h"

int main(int argc, char** argv) {
  constexpr char kUsage[] =
      "cwm-bench-robots [meshes|differences|motions|edges|ik|spheres|stream|latency|large|python] "
      "[--json FILE]\n";
  if (cwm::benchmarks::PrintsUsage(argc, argv, kUsage)) return 0;
  std::string part = "spheres", json;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--json" && i + 1 < argc) {
      json = argv[++i];
    } else {
      part = word;
    }
  }
  cwm::benchmarks::Report report;
  if (part == "meshes") {
    cwm::benchmarks::MeasureRobots(report);
  } else if (part == "differences") {
    cwm::benchmarks::MeasureUnexplained(report);
  } else if (part == "spheres") {
    cwm::benchmarks::MeasureSpheres(report);
  } else if (part == "motions") {
    cwm::benchmarks::MeasureMotions(report);
  } else if (part == "edges") {
    cwm::benchmarks::MeasureEdges(report);
  } else if (part == "ik") {
    cwm::benchmarks::MeasureInverseKinematics(report);
  } else if (part == "stream") {
    cwm::benchmarks::MeasureRobotStream(report);
  } else if (part == "latency") {
    cwm::benchmarks::MeasureRobotLatency(report);
  } else if (part == "large") {
    cwm::benchmarks::MeasureLargeMesh(report);
  } else if (part == "python") {
    cwm::benchmarks::MeasurePython(report);
  } else {
    report.Fail(
        "takes meshes, differences, motions, edges, ik, spheres, stream, latency, large or python");
  }
  report.Print();
  if (!json.empty()) report.WriteJson(json);
  return report.failed() ? 1 : 0;
}
