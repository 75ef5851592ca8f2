// cwm-simulator: scans a scene with known ground truth by a noisy sensor, into a PCD file.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <numbers>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "clients/formats/file_bytes.h"
#include "clients/formats/pcd.h"
#include "clients/formats/scalar.h"
#include "clients/simulator/scene_edits.h"
#include "clients/simulator/scene_file.h"
#include "clients/simulator/script_file.h"
#include "clients/simulator/sensor_text.h"
#include "clients/simulator/sequence_files.h"
#include "clients/simulator/simulated_files.h"
#include "manual/manual_page.h"
#include "perception/simulation/several_views.h"
#include "perception/simulation/unorganised.h"
#include "perception/simulation/virtual_scanner.h"

namespace {

namespace perception = cwm::perception;
using cwm::perception::SensorNoise;

constexpr int kUsage = 1;  // the command-line client's exit codes
constexpr int kBadInput = 8;

struct Arguments {
  std::string scene = "kitchen";
  std::string random;
  int object_count = 8;
  std::string sensor = "kinect";
  std::uint64_t seed = 1;
  bool noiseless = false;
  bool labels = false;
  bool shuffle = false;
  bool print_pose = false;
  int view_count = 1;
  double up_error_deg = 0;
  std::string out, truth, write_scene, script;
  cwm::simulator::SceneEdits edits;
};

absl::Status ParseSensor(const std::string& text, SensorNoise& noise) {
  const auto parsed = cwm::simulator::ParseSensorModel(text);
  if (!parsed) {
    return absl::InvalidArgumentError(
        absl::StrCat("--sensor: \"", text,
                     "\" must be kinect, realsense, time_of_flight, tilting_laser, sick_lms400 "
                     "or a standard deviation in metres"));
  }
  noise = *parsed;
  return absl::OkStatus();
}

// Prints x,y,z,qx,qy,qz,qw in the form of `cwm ingest --x-world-sensor`.
void PrintPose(const cwm::Pose& pose) {
  const cwm::Quaternion q(pose.linear());
  const auto& t = pose.translation();
  const char* separator = "";
  for (const double value : {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()}) {
    std::cout << separator << cwm::formats::FormatNumber(value);
    separator = ",";
  }
  std::cout << "\n";
}

std::vector<std::string> FamilyNames() {
  std::vector<std::string> names;
  for (const auto& [name, family] : perception::kSceneFamilies) names.emplace_back(name);
  return names;
}

absl::StatusOr<perception::SimulatedView> MakeView(const Arguments& arguments) {
  for (const auto& [name, family] : perception::kSceneFamilies) {
    if (name == arguments.random) return perception::RandomScene(family, arguments.seed);
  }
  if (arguments.scene == "kitchen") {
    return perception::SimulatedView{.scene = perception::KitchenCounter(),
                                     .camera = perception::KitchenCamera()};
  }
  if (arguments.scene == "table") {
    return perception::SimulatedView{
        .scene = perception::RandomTable(arguments.seed, arguments.object_count),
        .camera = perception::KitchenCamera()};
  }
  return cwm::simulator::ReadScene(arguments.scene);
}

cwm::simulator::SimulatedScan MakeScan(const Arguments& arguments, const SensorNoise& noise,
                                       const perception::SimulatedView& view) {
  const perception::ScanOptions options{
      .noise = noise, .noiseless = arguments.noiseless, .seed = arguments.seed};
  cwm::simulator::SimulatedScan scan;
  if (arguments.view_count > 1) {
    perception::RegisteredViews views =
        perception::ScanFromSeveralViews(view.scene, view.camera, arguments.view_count, options);
    scan = {.cloud = std::move(views.cloud), .X_WC = views.X_WC, .X_CC = views.X_CC};
  } else {
    scan.cloud = perception::Scan(view.scene, view.camera, options);
  }
  if (arguments.shuffle) scan.cloud = perception::Shuffled(scan.cloud, arguments.seed);
  const double error_rad = arguments.up_error_deg * std::numbers::pi / 180;
  scan.up_C = perception::PerturbedUp(error_rad, view.camera.X_WC, arguments.seed);
  return scan;
}

absl::Status WriteScan(const Arguments& arguments, const perception::SimulatedView& view,
                       const cwm::simulator::SimulatedScan& scan) {
  cwm::formats::CloudFile cloud = cwm::simulator::ToCloudFile(scan.cloud.cloud);
  if (arguments.labels) {
    cloud = cwm::formats::WithLabels(cloud, cwm::simulator::TrueLabels(view.scene, scan.cloud));
  }
  const auto pcd = cwm::formats::FormatPcd(cloud, cwm::formats::PcdData::kBinaryCompressed);
  if (!pcd.ok()) return pcd.status();
  absl::Status written = cwm::formats::WriteFileBytes(arguments.out, *pcd);
  if (!written.ok() || arguments.truth.empty()) return written;
  return cwm::formats::WriteFileBytes(arguments.truth,
                                      cwm::simulator::TruthJson(view.scene, view.camera, scan));
}

absl::Status SimulateSequence(const Arguments& arguments) {
  if (arguments.out.empty()) return absl::InvalidArgumentError("--out is missing: the folder");
  const auto file = cwm::simulator::ReadScript(arguments.script);
  if (!file.ok()) return file.status();
  return cwm::simulator::WriteSequence(arguments.out, *file, arguments.labels);
}

absl::Status Simulate(const Arguments& arguments) {
  if (!arguments.script.empty()) return SimulateSequence(arguments);
  SensorNoise noise;
  if (absl::Status status = ParseSensor(arguments.sensor, noise); !status.ok()) return status;
  if (!std::isfinite(arguments.up_error_deg)) {
    return absl::InvalidArgumentError("--up-error-deg: must be a finite number");
  }
  auto view = MakeView(arguments);
  if (!view.ok()) return view.status();
  absl::Status status = cwm::simulator::ApplyEdits(arguments.edits, view->scene);
  if (!status.ok()) return status;
  if (arguments.print_pose) PrintPose(view->camera.X_WC);
  if (!arguments.write_scene.empty()) {
    status = cwm::simulator::WriteScene(arguments.write_scene, *view);
    if (!status.ok()) return status;
  }
  if (!arguments.out.empty()) return WriteScan(arguments, *view, MakeScan(arguments, noise, *view));
  const bool anything = arguments.print_pose || !arguments.write_scene.empty();
  return anything ? absl::OkStatus() : absl::InvalidArgumentError("--out is missing: the PCD file");
}

void AddOptions(CLI::App& app, Arguments& arguments) {
  CLI::Option* scene =
      app.add_option("--scene", arguments.scene,
                     "kitchen (the demo's counter), table (random), or a scene file")
          ->type_name("SCENE|S.yaml");
  app.add_option("--random", arguments.random,
                 "a scene drawn by the seed: " + absl::StrJoin(FamilyNames(), ", "))
      ->check(CLI::IsMember(FamilyNames()).description(""))
      ->excludes(scene)
      ->type_name("FAMILY");
  app.add_option("--write-scene", arguments.write_scene,
                 "write the scene as a scene file, its meshes beside it")
      ->type_name("S.yaml");
  app.add_option("--objects", arguments.object_count, "on the random table, 1 to 64; default 8")
      ->check(CLI::Range(1, 64).description(""))
      ->type_name("N");
  app.add_option("--sensor", arguments.sensor,
                 "kinect, realsense, time_of_flight, tilting_laser, sick_lms400, or sigma in m")
      ->type_name("MODEL|SIGMA");
  app.add_option("--seed", arguments.seed, "of the noise, and of random scenes; default 1")
      ->type_name("N");
  app.add_flag("--noiseless", arguments.noiseless, "a perfect sensor");
  app.add_flag("--labels", arguments.labels, "add the true label of each point");
  app.add_flag("--shuffle", arguments.shuffle, "points in random order, those that returned alone");
  app.add_option("--views", arguments.view_count,
                 "put together from so many places, 1 to 16, registered with errors; default 1")
      ->check(CLI::Range(1, 16).description(""))
      ->type_name("N");
  app.add_option("--up-error-deg", arguments.up_error_deg,
                 "how far the up vector in the truth is off; default 0")
      ->check(CLI::Range(0.0, 180.0).description(""))
      ->type_name("DEG");
  app.add_option("--without", arguments.edits.without, "leave an object out; repeatable")
      ->allow_extra_args(false)
      ->type_name("NAME");
  app.add_option("--move", arguments.edits.moves, "move an object (m); repeatable")
      ->allow_extra_args(false)
      ->type_name("NAME=DX,DY,DZ");
  app.add_flag("--print-pose", arguments.print_pose,
               "print the sensor's pose in the world, for cwm ingest --x-world-sensor");
  app.add_option("--truth", arguments.truth, "what is there, as JSON")->type_name("T.json");
  const std::vector<CLI::Option*> of_scans = app.get_options();
  CLI::Option* script =
      app.add_option("--script", arguments.script,
                     "a sequence instead of a scan: what moves, and the sensors that watch");
  script->type_name("S.yaml");
  for (CLI::Option* option : of_scans) {
    const bool of_both = option == app.get_help_ptr() || option->check_name("--labels") ||
                         option->check_name("--manual-page");
    if (!of_both) script->excludes(option);
  }
  app.add_option("--out", arguments.out,
                 "the PCD file: x y z in the sensor's frame; the folder of a sequence")
      ->type_name("C.pcd|DIR");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "cwm-simulator: a scene with known truth, seen by noisy sensors\n\nExamples:\n"
      "  cwm-simulator --out scan.pcd --truth truth.json\n"
      "  cwm-simulator --without ball --move mug=0.1,0,0 --seed 2 --out later.pcd\n"
      "  cwm-simulator --random clutter --seed 3 --labels --out clutter.pcd --truth truth.json\n"
      "  cwm-simulator --random vessels --seed 7 --write-scene my.yaml --out vessels.pcd\n"
      "  cwm-simulator --scene my.yaml --sensor realsense --views 3 --out my.pcd\n"
      "  cwm-simulator --scene table --objects 12 --sensor realsense --out table.pcd\n"
      "  cwm-simulator --script pushed_mug.yaml --labels --out pushed_mug",
      "cwm-simulator");
  Arguments arguments;
  cwm::manual::AddManualPage(app, {.version = CWM_VERSION});
  AddOptions(app, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUsage;
  }
  const absl::Status status = Simulate(arguments);
  if (status.ok()) return 0;
  std::cerr << "cwm-simulator: " << status.message() << "\n";
  return kBadInput;
}
