// cwm-simulator: a scene with known truth, seen by a noisy sensor, as a PCD file.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <map>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "clients/formats/file_bytes.h"
#include "clients/formats/pcd.h"
#include "clients/formats/scalar.h"
#include "clients/simulator/scene_edits.h"
#include "clients/simulator/simulated_files.h"
#include "perception/simulation/virtual_scanner.h"

namespace {

using cwm::perception::SensorModel;
using cwm::perception::SensorNoise;

constexpr int kUsage = 1;  // as the command line client's exit codes
constexpr int kBadInput = 8;

struct Arguments {
  std::string scene = "kitchen";
  int object_count = 8;
  std::string sensor = "kinect";
  std::uint64_t seed = 1;
  bool noiseless = false;
  bool labels = false;
  bool print_pose = false;
  std::string out, truth;
  cwm::simulator::Edits edits;
};

absl::Status ParseSensor(const std::string& text, SensorNoise& noise) {
  static const std::map<std::string, SensorModel> kModels = {
      {"kinect", SensorModel::kKinect},
      {"realsense", SensorModel::kRealSense},
      {"time_of_flight", SensorModel::kTimeOfFlight},
      {"tilting_laser", SensorModel::kTiltingLaser}};
  if (const auto found = kModels.find(text); found != kModels.end()) {
    noise.model = found->second;
    return absl::OkStatus();
  }
  noise.model = SensorModel::kConstant;
  if (absl::SimpleAtod(text, &noise.constant_sigma_m) && std::isfinite(noise.constant_sigma_m) &&
      noise.constant_sigma_m > 0) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat("--sensor: \"", text,
                   "\" must be kinect, realsense, time_of_flight, tilting_laser or a standard "
                   "deviation in metres"));
}

// x,y,z,qx,qy,qz,qw as `cwm ingest --x-world-sensor` takes it.
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

absl::Status Simulate(const Arguments& arguments) {
  namespace perception = cwm::perception;
  const perception::PinholeCamera camera = perception::KitchenCamera();
  if (arguments.print_pose) PrintPose(camera.X_WC);
  if (arguments.out.empty()) {
    return arguments.print_pose ? absl::OkStatus()
                                : absl::InvalidArgumentError("--out is missing: the PCD file");
  }
  perception::ScanOptions options{
      .noise = {}, .noiseless = arguments.noiseless, .seed = arguments.seed};
  if (absl::Status status = ParseSensor(arguments.sensor, options.noise); !status.ok())
    return status;
  perception::SimulatedScene scene =
      arguments.scene == "kitchen"
          ? perception::KitchenCounter()
          : perception::RandomTable(arguments.seed, arguments.object_count);
  absl::Status edited = cwm::simulator::ApplyEdits(arguments.edits, scene);
  if (!edited.ok()) return edited;
  const perception::SimulatedCloud scan = perception::Scan(scene, camera, options);
  cwm::formats::CloudFile cloud = cwm::simulator::ToCloudFile(scan.cloud);
  if (arguments.labels) {
    cloud = cwm::formats::WithLabels(cloud, cwm::simulator::TrueLabels(scene, scan));
  }
  const auto pcd = cwm::formats::FormatPcd(cloud, cwm::formats::PcdData::kBinaryCompressed);
  if (!pcd.ok()) return pcd.status();
  absl::Status written = cwm::formats::WriteFileBytes(arguments.out, *pcd);
  if (!written.ok() || arguments.truth.empty()) return written;
  return cwm::formats::WriteFileBytes(arguments.truth,
                                      cwm::simulator::TruthJson(scene, camera, scan));
}

void AddOptions(CLI::App& app, Arguments& arguments) {
  app.add_option("--scene", arguments.scene, "kitchen (the demo's counter) or table (random)")
      ->check(CLI::IsMember({"kitchen", "table"}).description(""))
      ->type_name("SCENE");
  app.add_option("--objects", arguments.object_count, "on the random table, 1 to 64; default 8")
      ->check(CLI::Range(1, 64).description(""))
      ->type_name("N");
  app.add_option("--sensor", arguments.sensor,
                 "kinect, realsense, time_of_flight, tilting_laser, or sigma in m")
      ->type_name("MODEL|SIGMA");
  app.add_option("--seed", arguments.seed, "of the noise, and of the random table; default 1")
      ->type_name("N");
  app.add_flag("--noiseless", arguments.noiseless, "a perfect sensor");
  app.add_flag("--labels", arguments.labels, "add the true label of each point");
  app.add_option("--without", arguments.edits.without, "leave an object out; repeatable")
      ->allow_extra_args(false)
      ->type_name("NAME");
  app.add_option("--move", arguments.edits.moves, "move an object (m); repeatable")
      ->allow_extra_args(false)
      ->type_name("NAME=DX,DY,DZ");
  app.add_flag("--print-pose", arguments.print_pose,
               "print the sensor's pose in the world, for cwm ingest --x-world-sensor");
  app.add_option("--out", arguments.out, "the PCD file: x y z in the sensor's frame")
      ->type_name("C.pcd");
  app.add_option("--truth", arguments.truth, "what is there, as JSON")->type_name("T.json");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "cwm-simulator: a scene with known truth, seen by a noisy sensor\n\nExamples:\n"
      "  cwm-simulator --out scan.pcd --truth truth.json\n"
      "  cwm-simulator --without ball --move mug=0.1,0,0 --seed 2 --out later.pcd\n"
      "  cwm-simulator --scene table --objects 12 --sensor realsense --out table.pcd",
      "cwm-simulator");
  Arguments arguments;
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
