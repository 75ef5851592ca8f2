// The viewer's page in a browser, with 2 000 objects, and with 20 that move beside a running
// sensor: a script under Node measures, and this program reports.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/benchmarks/benchmarks.h"
#include "tests/support/process.h"

namespace cwm::benchmarks {
namespace {

using nlohmann::json;

constexpr char kWhere[] =
    "the page in a headless Chromium that draws in software, 1280 x 800, 2 000 objects of five "
    "kinds of shapes; ";

}  // namespace

void MeasureViewer(Report& report) {
  const testing::ScratchDirectory scratch;
  const std::string figures = scratch / "figures.json";
  const auto programs = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  const std::string source = CWM_SOURCE_DIR;
  const testing::ProcessResult run = testing::RunProgram(
      {"/usr/bin/env", "CWM_BIN=" + programs.string(), "CWM_FIGURES=" + figures, "cmake",
       "-DSOURCE_DIR=" + source, "-DBINARY_DIR=" + scratch / "bundle",
       "-DFILE=tests/benchmarks/viewer_figures.ts", "-P", source + "/tests/e2e/viewer/run.cmake"});
  std::ifstream file(figures);
  const json found = json::parse(file, nullptr, /*allow_exceptions=*/false);
  if (run.exit_code != 0 || !found.is_object()) {
    return report.Fail("the viewer's page could not be measured: " + run.err);
  }
  const std::string finished =
      std::to_string(std::lround(found.value("first_picture_finished_ms", 0.0)));
  report.Detail("viewer: the software that draws finishes the first picture after " + finished +
                " ms");
  report.Add({.key = "viewer_first_picture_ms",
              .value = found.value("first_picture_ms", 0.0),
              .unit = "ms",
              .how = std::string(kWhere) +
                     "from the start of the navigation, nothing cached, until the page has issued "
                     "the drawing of all of them, median of 7; drawn in software they are seen "
                     "after " +
                     finished + " ms"});
  report.Add({.key = "viewer_frame_cpu_ms",
              .value = found.value("frame_cpu_ms", 0.0),
              .unit = "ms",
              .how = std::string(kWhere) +
                     "time of the page's script in a frame, median while the camera turns"});
  report.Add({.key = "viewer_draw_calls",
              .value = found.value("draw_calls", 0.0),
              .unit = "1",
              .how = std::string(kWhere) + "draw calls of one frame, floor and axes included"});
  report.Add({.key = "viewer_update_ms",
              .value = found.value("update_ms", 0.0),
              .unit = "ms",
              .how = std::string(kWhere) +
                     "from before the command line is started to move one of them until the "
                     "page has issued the drawing, nothing else being drawn, median of 9"});
  constexpr char kLive[] =
      "the page in the same browser while 20 objects move 30 times a second and a running sensor "
      "of 20 000 points sends 10 frames a second; ";
  report.Add({.key = "viewer_live_frame_cpu_ms",
              .value = found.value("live_frame_cpu_ms", 0.0),
              .unit = "ms",
              .how = std::string(kLive) + "time of the page's script in a frame, median"});
  report.Add({.key = "viewer_live_pictures_hz",
              .value = found.value("live_pictures_hz", 0.0),
              .unit = "1/s",
              .how = std::string(kLive) +
                     "pictures a second, bounded by the software that draws; the page got " +
                     std::to_string(std::lround(found.value("live_updates_hz", 0.0))) +
                     " states and drew " +
                     std::to_string(std::lround(found.value("live_frames_hz", 0.0))) +
                     " frames of " + std::to_string(std::lround(found.value("live_points", 0.0))) +
                     " points a second"});
}

}  // namespace cwm::benchmarks
