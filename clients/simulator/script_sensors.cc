#include <utility>

#include "absl/strings/str_cat.h"
#include "clients/simulator/pose_yaml.h"
#include "clients/simulator/script_yaml.h"
#include "clients/simulator/sensor_text.h"

namespace cwm::simulator {
namespace {

using perception::FrameChoice;
using perception::PinholeCamera;
using perception::SensorModel;
using perception::SequenceScript;
using perception::SequenceSensor;

absl::StatusOr<perception::SensorNoise> ReadDepthSensor(const YamlNode& node) {
  if (!node.present()) return perception::SensorNoise{};
  const auto text = node.ReadText();
  if (!text.ok()) return text.status();
  const auto noise = ParseSensorModel(*text);
  if (noise && noise->model != SensorModel::kTiltingLaser &&
      noise->model != SensorModel::kSickLms400) {
    return *noise;
  }
  return node.Error(
      "must be a depth camera: kinect, realsense, time_of_flight, or a standard deviation in "
      "metres");
}

absl::StatusOr<std::vector<perception::TimedPose>> ReadCameraWaypoints(const YamlNode& list,
                                                                       double duration_s) {
  const auto times_s = ReadTimes(list, duration_s);
  if (!times_s.ok()) return times_s.status();
  std::vector<perception::TimedPose> waypoints;
  for (std::size_t i = 0; i < list.size(); ++i) {
    absl::Status status = list[i].CheckKeys({"time_s", "pose", "look_at"});
    if (!status.ok()) return status;
    const auto X_WC = ReadViewpoint(list[i]);
    if (!X_WC.ok()) return X_WC.status();
    waypoints.push_back({.time_s = (*times_s)[i], .X_WB = *X_WC});
  }
  return waypoints;
}

absl::StatusOr<perception::MountedOnLink> ReadLinkMount(const YamlNode& node,
                                                        const SequenceScript& script) {
  absl::Status status = node.CheckKeys({"robot", "link", "pose"});
  if (!status.ok()) return status;
  const auto link = ReadLinkRef(node, script);
  if (!link.ok()) return link.status();
  const auto X_LC = ReadPose(node["pose"]);
  if (!X_LC.ok()) return X_LC.status();
  return perception::MountedOnLink{.link = *link, .X_LC = *X_LC};
}

absl::StatusOr<perception::SensorMount> ReadMount(const YamlNode& node,
                                                  const PinholeCamera& view_camera,
                                                  const SequenceScript& script) {
  int count = 0;
  for (const char* key : {"pose", "look_at", "waypoints", "on_link"}) count += node.Has(key);
  if (count > 1) return node.Error("must hold one of pose, look_at, waypoints and on_link");
  if (node.Has("waypoints")) {
    auto waypoints = ReadCameraWaypoints(node["waypoints"], script.duration_s);
    if (!waypoints.ok()) return waypoints.status();
    return *std::move(waypoints);
  }
  if (node.Has("on_link")) {
    const auto mounted = ReadLinkMount(node["on_link"], script);
    if (!mounted.ok()) return mounted.status();
    return *mounted;
  }
  if (count == 0) return view_camera.X_WC;
  const auto X_WC = ReadViewpoint(node);
  if (!X_WC.ok()) return X_WC.status();
  return *X_WC;
}

absl::Status ReadChoice(const YamlNode& node, int frame_count, FrameChoice& choice) {
  const auto rate = ReadNumberOr(node["rate"], 0);
  if (!rate.ok()) return rate.status();
  if (*rate < 0 || *rate > 1) return node["rate"].Error("must be from 0 to 1");
  choice.rate = *rate;
  const YamlNode frames = node["frames"];
  if (frames.present() && !frames.is_list()) return frames.Error("must be a list of frames");
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto frame = frames[i].ReadInteger(0, frame_count - 1);
    if (!frame.ok()) return frame.status();
    choice.frames.push_back(*frame);
  }
  return absl::OkStatus();
}

absl::Status ReadFaults(const YamlNode& node, int frame_count, SequenceSensor& sensor) {
  for (const auto& [key, choice] : {std::pair<const char*, FrameChoice*>("lost", &sensor.lost),
                                    {"doubled", &sensor.doubled},
                                    {"swapped", &sensor.swapped}}) {
    if (!node[key].present()) continue;
    absl::Status status = node[key].CheckKeys({"frames", "rate"});
    if (status.ok()) status = ReadChoice(node[key], frame_count, *choice);
    if (!status.ok()) return status;
  }
  const YamlNode late = node["late"];
  if (!late.present()) return absl::OkStatus();
  absl::Status status = late.CheckKeys({"frames", "rate", "by_s"});
  if (status.ok()) status = ReadChoice(late, frame_count, sensor.late);
  if (!status.ok()) return status;
  const auto by_s = ReadSecondsOr(late["by_s"], sensor.late_by_s);
  if (!by_s.ok()) return by_s.status();
  sensor.late_by_s = *by_s;
  return absl::OkStatus();
}

absl::Status ReadClock(const YamlNode& node, double duration_s, SequenceSensor& sensor) {
  const auto rate = ReadRateOr(node["rate_hz"], sensor.rate_hz);
  if (!rate.ok()) return rate.status();
  sensor.rate_hz = *rate;
  const auto start = node["start_s"].present() ? ReadTime(node["start_s"], duration_s) : 0.0;
  if (!start.ok()) return start.status();
  sensor.start_s = *start;
  const auto offset = ReadNumberOr(node["clock_offset_s"], 0);
  if (!offset.ok()) return offset.status();
  sensor.clock_offset_s = *offset;
  const auto latency = ReadSecondsOr(node["latency_s"], 0);
  if (!latency.ok()) return latency.status();
  sensor.latency_s = *latency;
  return absl::OkStatus();
}

absl::Status ReadSensor(const YamlNode& node, const PinholeCamera& view_camera,
                        SequenceScript& script) {
  absl::Status status =
      node.CheckKeys({"name", "model", "width", "height", "focal_px", "center_px", "pose",
                      "look_at", "waypoints", "on_link", "rate_hz", "start_s", "clock_offset_s",
                      "latency_s", "device_seed", "lost", "doubled", "late", "swapped"});
  if (!status.ok()) return status;
  std::vector<std::string> taken;
  for (const SequenceSensor& sensor : script.sensors) taken.push_back(sensor.name);
  const auto name = ReadNewName(node["name"], taken);
  if (!name.ok()) return name.status();
  const auto noise = ReadDepthSensor(node["model"]);
  if (!noise.ok()) return noise.status();
  SequenceSensor sensor{.name = *name, .noise = *noise, .camera = view_camera};
  if (node.Has("width") || node.Has("height") || node.Has("focal_px") || node.Has("center_px")) {
    if (status = ReadLens(node, sensor.camera); !status.ok()) return status;
  }
  auto mount = ReadMount(node, view_camera, script);
  if (!mount.ok()) return mount.status();
  sensor.mount = *std::move(mount);
  if (status = ReadClock(node, script.duration_s, sensor); !status.ok()) return status;
  if (node["device_seed"].present()) {
    const auto seed = node["device_seed"].ReadInteger(0, 2'147'483'647);
    if (!seed.ok()) return seed.status();
    sensor.device_seed = static_cast<std::uint64_t>(*seed);
  } else {
    sensor.device_seed = script.sensors.size() + 1;  // sensors differ
  }
  const int frame_count = perception::FrameCount(script, sensor);
  if (frame_count == 0) return node["start_s"].Error("leaves no frame before duration_s");
  if (status = ReadFaults(node, frame_count, sensor); !status.ok()) return status;
  script.sensors.push_back(std::move(sensor));
  return absl::OkStatus();
}

}  // namespace

absl::Status ReadSensors(const YamlNode& node, const PinholeCamera& view_camera,
                         SequenceScript& script) {
  if (node.size() == 0 || node.size() > kMaxSensors) {
    return node.Error(absl::StrCat("must be a list of 1 to ", kMaxSensors, " sensors"));
  }
  for (std::size_t i = 0; i < node.size(); ++i) {
    if (absl::Status status = ReadSensor(node[i], view_camera, script); !status.ok()) {
      return status;
    }
  }
  return absl::OkStatus();
}

}  // namespace cwm::simulator
