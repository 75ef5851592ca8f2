// cwm stream
#include <filesystem>
#include <istream>
#include <memory>
#include <ostream>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "clients/cli/commands.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/number_list.h"
#include "clients/cli/one_of.h"
#include "clients/cli/scan_arguments.h"
#include "clients/cli/stream_feed.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

struct StreamArguments {
  std::string frames;  // a folder, or "-": a list on stdin
  std::string sensor, sensor_model, x_world_sensor;
  std::string mount, x_link_sensor;
  std::string intrinsics;
  std::optional<double> scale;
  double min_range_m = 0, max_range_m = 0;
  std::optional<double> rate_hz;
  int rounds = 1;
  bool is_lockstep = false;
  bool no_states = false;
  FeedOptions feed;
};

bool IsList(const StreamArguments& arguments) { return arguments.frames == "-"; }

absl::StatusOr<pb::SensorMount> ParseMount(const StreamArguments& arguments) {
  const std::string& text = arguments.mount;
  const std::size_t separator = text.find_first_of("/:");
  if (separator == 0 || separator == std::string::npos || separator + 1 == text.size()) {
    return UsageError(absl::StrCat("--mount: \"", text, "\" must be ROBOT/LINK or ROBOT:LINK"));
  }
  if (!arguments.x_world_sensor.empty()) {
    return UsageError("--mount and --x-world-sensor: give one, a sensor on a link moves with it");
  }
  pb::SensorMount mount;
  mount.set_robot(text.substr(0, separator));
  mount.set_link(text.substr(separator + 1));
  const auto pose = arguments.x_link_sensor.empty()
                        ? client::PoseRow{0, 0, 0, 0, 0, 0, 1}
                        : ParsePose(arguments.x_link_sensor, "--x-link-sensor");
  if (!pose.ok()) return pose.status();
  *mount.mutable_x_link_sensor() = PoseToProto(*pose);
  return mount;
}

// The name of a folder names its sensor.
std::string SensorName(const StreamArguments& arguments) {
  if (!arguments.sensor.empty()) return arguments.sensor;
  if (IsList(arguments)) return "camera";
  const std::filesystem::path folder =
      std::filesystem::absolute(arguments.frames).lexically_normal();
  return folder.has_filename() ? folder.filename().string()
                               : folder.parent_path().filename().string();
}

// The calibration without the layout of the frames.
absl::StatusOr<pb::SensorCalibration> ParseCalibration(const StreamArguments& arguments,
                                                       const Session& session) {
  pb::SensorCalibration calibration;
  calibration.set_world(session.world);
  calibration.set_sensor(SensorName(arguments));
  if (!arguments.sensor_model.empty()) {
    const auto model = ParseSensorModel(arguments.sensor_model);
    if (!model.ok()) return model.status();
    *calibration.mutable_sensor_model() = *model;
  }
  if (!arguments.x_world_sensor.empty()) {
    const auto pose = ParsePose(arguments.x_world_sensor, "--x-world-sensor");
    if (!pose.ok()) return pose.status();
    *calibration.mutable_x_world_sensor() = PoseToProto(*pose);
  }
  if (!arguments.mount.empty()) {
    const auto mount = ParseMount(arguments);
    if (!mount.ok()) return mount.status();
    *calibration.mutable_mount() = *mount;
  } else if (!arguments.x_link_sensor.empty()) {
    return UsageError("--x-link-sensor belongs to --mount ROBOT/LINK");
  }
  calibration.set_least_range_m(arguments.min_range_m);
  calibration.set_greatest_range_m(arguments.max_range_m);
  calibration.set_lockstep(arguments.is_lockstep);
  return calibration;
}

absl::StatusOr<std::unique_ptr<FrameSource>> MakeSource(const StreamArguments& arguments,
                                                        const Session& session) {
  if (IsList(arguments)) {
    if (arguments.rounds > 1) return UsageError("--loop is for folders: a list is read once");
    return MakeListSource(session.streams.in, "-", arguments.rate_hz);
  }
  auto sequence = formats::ReadFrameFolder(arguments.frames);
  if (!sequence.ok()) return sequence.status();
  return MakeFolderSource(*std::move(sequence), arguments.rate_hz, arguments.rounds);
}

// An error if the server took none of the frames.
absl::Status CheckProcessed(const StreamReport& report) {
  if (report.processed() > 0 || report.answered() == 0) return absl::OkStatus();
  std::vector<std::string> reasons;
  for (const auto& [reason, count] : report.reasons()) reasons.push_back(reason);
  return absl::InvalidArgumentError(
      absl::StrCat("none of ", report.answered(), " frames was processed",
                   reasons.empty() ? "" : ": ", absl::StrJoin(reasons, ", ")));
}

absl::Status Stream(Session& session, const StreamArguments& arguments) {
  auto calibration = ParseCalibration(arguments, session);
  if (!calibration.ok()) return calibration.status();
  const auto source = MakeSource(arguments, session);
  if (!source.ok()) return source.status();
  FrameLoader loader({.intrinsics = arguments.intrinsics,
                      .unit_m = arguments.scale,
                      .use_poses = arguments.mount.empty() && arguments.x_world_sensor.empty(),
                      .use_sensor_model = arguments.sensor_model.empty()});
  FeedOptions options = arguments.feed;
  options.send_states = !arguments.no_states;
  StreamFeed feed(session, **source, loader, options);
  absl::Status status = feed.Run(*calibration);
  if (feed.report().answered() > 0 && session.form == OutputForm::kTable) {
    feed.report().Print(session.streams.out);
  }
  return status.ok() ? CheckProcessed(feed.report()) : status;
}

// For Option::check.
std::string PositiveNumber(const std::string& text) {
  double number = 0;
  if (absl::SimpleAtod(text, &number) && number > 0) return "";
  return absl::StrCat("\"", text, "\" must be a number, more than 0");
}

void AddSensorOptions(CLI::App& command, StreamArguments& arguments) {
  command
      .add_option("--sensor", arguments.sensor,
                  "names the sensor; default: the folder's name, or camera")
      ->type_name("NAME");
  command
      .add_option("--x-world-sensor", arguments.x_world_sensor,
                  "the pose of a sensor that stands still (m), in place of those of the frames; "
                  "default: that of its earlier scan, or estimated from the first frame")
      ->type_name("X,Y,Z,QX,QY,QZ,QW");
  command
      .add_option(
          "--mount", arguments.mount,
          "the robot's link that carries the sensor (or ROBOT:LINK); its states place each frame")
      ->type_name("ROBOT/LINK");
  command
      .add_option("--x-link-sensor", arguments.x_link_sensor,
                  "the sensor's pose on that link (m); default: the link's own")
      ->type_name("X,Y,Z,QX,QY,QZ,QW");
  command
      .add_option("--sensor-model", arguments.sensor_model,
                  "kinect, realsense, time_of_flight, tilting_laser, sigma in m, or A,B: sigma = "
                  "A + B z^2 at depth z; default: the camera's, or kinect")
      ->type_name("MODEL|SIGMA|A,B");
  AddIntrinsicsOption(command, arguments.intrinsics);
  command
      .add_option("--scale", arguments.scale,
                  "metres per unit of depth images; default: the camera's, or 0.001 for integers")
      ->check(PositiveNumber)
      ->type_name("FACTOR");
  command
      .add_option("--min-range", arguments.min_range_m,
                  "nearer depths are no return (m); default: the camera's, or the sensor model's")
      ->check(PositiveNumber)
      ->type_name("M");
  command
      .add_option("--max-range", arguments.max_range_m,
                  "farther depths are no return (m); default: the camera's, or the sensor model's")
      ->check(PositiveNumber)
      ->type_name("M");
}

void AddTimeOptions(CLI::App& command, StreamArguments& arguments) {
  command
      .add_option("--rate", arguments.rate_hz,
                  "stamps frames that have no stamps (per second); default: 30 for a folder, and "
                  "a list's frames are stamped when they are sent")
      ->check(PositiveNumber)
      ->type_name("HZ");
  command.add_flag("--realtime", arguments.feed.realtime,
                   "send each frame when it is due, also while another one is processed; default: "
                   "as soon as the one before is answered");
  command.add_option("--loop", arguments.rounds, "send the folder so many times")
      ->check(PositiveNumber)
      ->type_name("N");
  command.add_flag("--keep-stamps", arguments.feed.keep_stamps,
                   "send stamps as they are recorded; default: moved to the present");
  command.add_flag("--lockstep", arguments.is_lockstep,
                   "frames of all sensors take turns, each when everything that the one before "
                   "began is done: such a stream can be replayed to the bit");
  command.add_flag("--no-states", arguments.no_states,
                   "do not send the robots' states beside the frames");
  command.add_flag("--quiet", arguments.feed.quiet, "print the summary alone");
}

}  // namespace

void AddStreamCommand(CommandLine& line) {
  const auto arguments = std::make_shared<StreamArguments>();
  CLI::App& command = AddCommand(
      line,
      {"stream",
       "feeds the frames of a running sensor: what moves, comes or goes is followed",
       {"cwm stream FOLDER --realtime", "cwm stream FOLDER --rate 15 --loop 10",
        "cwm stream FOLDER --x-world-sensor 0,0,1.2,1,0,0,0 --sensor-model realsense -o ndjson",
        "cwm stream FOLDER --mount panda/panda_hand --x-link-sensor 0,0,0.05,0,0,0,1",
        "ls *-depth.png | cwm stream - --sensor table --camera camera.json"},
       "FOLDER has depth images (PNG, NPY) or organised clouds (PCD, PLY), with the camera in "
       "camera.json or\n"
       "camera-intrinsics.txt, poses in NAME.pose.txt, or everything in frames.jsonl, as "
       "cwm-simulator writes it.\n"
       "A list on stdin has a line for each frame: FILE [STAMP [POSE]]. The states of robots in "
       "joint_states.jsonl\n"
       "are sent beside the frames. Prints a summary; -o json and -o ndjson print the answer to "
       "each frame."},
      [arguments](Session& session) { return Stream(session, *arguments); });
  command.add_option("FOLDER", arguments->frames, "folder of frames, or -: a list on stdin")
      ->required();
  AddSensorOptions(command, *arguments);
  AddTimeOptions(command, *arguments);
}

}  // namespace cwm::cli
