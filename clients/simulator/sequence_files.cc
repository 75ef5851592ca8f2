#include "clients/simulator/sequence_files.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "clients/formats/file_bytes.h"
#include "clients/formats/format_error.h"
#include "clients/simulator/png_writer.h"
#include "clients/simulator/scene_file.h"
#include "clients/simulator/sensor_text.h"
#include "perception/simulation/deliveries.h"

namespace cwm::simulator {
namespace {

using Json = nlohmann::ordered_json;
using perception::SequenceBody;
using perception::SequenceFrame;
using perception::SequenceRenderer;
using perception::SequenceScript;
using perception::SequenceSensor;

// x, y, z, qx, qy, qz, qw
Json PoseRow(const Pose& pose) {
  const Quaternion q(pose.linear());
  const auto& t = pose.translation();
  return {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
}

Json CarrierJson(const perception::Carrier& carrier, const SequenceScript& script) {
  if (const auto* hand = std::get_if<perception::HandRef>(&carrier)) {
    return {{"hand", script.hands[hand->hand].name}};
  }
  const auto& link = std::get<perception::LinkRef>(carrier);
  const perception::SimulatedRobot& robot = script.robots[link.robot];
  return {{"robot", robot.name}, {"link", robot.links[link.link].name}};
}

Json CameraJson(const SequenceSensor& sensor) {
  const perception::PinholeCamera& camera = sensor.camera;
  Json json = {{"width", camera.width},
               {"height", camera.height},
               {"fx", camera.focal_px},
               {"fy", camera.focal_px},
               {"cx", camera.center_x_px},
               {"cy", camera.center_y_px},
               {"depth_unit_m", kDepthUnit_m},
               {"depth_scale_m", kDepthUnit_m},
               {"min_range_m", perception::RangeOf(sensor.noise.model).nearest_m},
               {"max_range_m", std::min(perception::RangeOf(sensor.noise.model).farthest_m,
                                        perception::kMaxCameraDepth_m)},
               {"sensor_model", SensorModelName(sensor.noise.model)},
               {"frame", sensor.name}};
  if (sensor.noise.model == perception::SensorModel::kGiven) {
    json["sigma_m"] = sensor.noise.given_sigma_m;
  }
  return json;
}

std::string ImageName(int frame) { return absl::StrFormat("%06d.png", frame); }

Json TruthJson(const SequenceFrame& frame, const SequenceScript& script) {
  Json objects = Json::array();
  for (std::size_t i = 0; i < frame.objects.size(); ++i) {
    const perception::ObjectTruth& truth = frame.objects[i];
    Json object = {{"name", script.scene.objects[i].name}, {"present", truth.state.is_present},
                   {"moving", truth.state.is_moving},      {"pose", PoseRow(truth.state.X_WO)},
                   {"pixels", truth.pixel_count},          {"visible_share", truth.visible_share}};
    if (truth.state.carrier) object["carried_by"] = CarrierJson(*truth.state.carrier, script);
    objects.push_back(std::move(object));
  }
  Json json = {{"frame", frame.index},
               {"file", ImageName(frame.index)},
               {"time", frame.time_s},
               {"stamp", frame.stamp_s},
               {"pose", PoseRow(frame.camera.X_WC)},
               {"hand_pixels", frame.hand_pixel_count},
               {"robot_pixels", frame.robot_pixel_count},
               {"mixed_pixels", frame.mixed_pixel_count},
               {"objects", std::move(objects)}};
  if (!script.robots.empty()) {
    Json joints = Json::object();
    for (std::size_t i = 0; i < script.robots.size(); ++i) {
      joints[script.robots[i].name] = frame.joint_values[i];
    }
    json["joint_values"] = std::move(joints);
  }
  return json;
}

std::string JointStateLines(const SequenceScript& script) {
  struct Line {
    double delivery_s = 0;
    std::string text;
  };
  std::vector<Line> lines;
  for (std::size_t i = 0; i < script.robots.size(); ++i) {
    const perception::SimulatedRobot& robot = script.robots[i];
    for (const perception::JointStateDelivery& state :
         perception::JointStateDeliveries(script, i)) {
      const Json json = {{"robot", robot.name},
                         {"stamp", state.stamp_s},
                         {"delivery", state.delivery_s},
                         {"joints", robot.variables},
                         {"values", state.values}};
      lines.push_back({.delivery_s = state.delivery_s, .text = json.dump() + "\n"});
    }
  }
  std::stable_sort(lines.begin(), lines.end(),
                   [](const Line& a, const Line& b) { return a.delivery_s < b.delivery_s; });
  std::string text;
  for (const Line& line : lines) text += line.text;
  return text;
}

std::string SequenceJson(const ScriptFile& file) {
  const SequenceScript& script = file.script;
  Json sensors = Json::array();
  for (const SequenceSensor& sensor : script.sensors) {
    Json json = {{"name", sensor.name},
                 {"rate_hz", sensor.rate_hz},
                 {"device_seed", sensor.device_seed},
                 {"clock_offset_s", sensor.clock_offset_s}};
    if (const auto* mounted = std::get_if<perception::MountedOnLink>(&sensor.mount)) {
      json["on_link"] = CarrierJson(mounted->link, script);
      json["on_link"]["pose"] = PoseRow(mounted->X_LC);
    }
    sensors.push_back(std::move(json));
  }
  Json robots = Json::array();
  for (std::size_t i = 0; i < script.robots.size(); ++i) {
    robots.push_back({{"name", script.robots[i].name},
                      {"urdf", file.robots[i].urdf_path},
                      {"packages", file.robots[i].package_folders},
                      {"pose", PoseRow(file.robots[i].X_WB)},
                      {"joints", script.robots[i].variables}});
  }
  Json objects = Json::array();
  for (std::size_t i = 0; i < script.scene.objects.size(); ++i) {
    objects.push_back({{"name", script.scene.objects[i].name},
                       {"label", i + 1},
                       {"is_support", script.scene.objects[i].is_support}});
  }
  Json hands = Json::array();
  for (const perception::SimulatedHand& hand : script.hands) hands.push_back(hand.name);
  const Json json = {{"duration_s", script.duration_s},
                     {"start_stamp_s", script.start_stamp_s},
                     {"seed", script.seed},
                     {"scene", "scene.yaml"},
                     {"sensors", sensors},
                     {"robots", robots},
                     {"hands", hands},
                     {"objects", objects}};
  return json.dump(1) + "\n";
}

absl::Status MakeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error) return absl::OkStatus();
  return formats::FileError(
      folder.string(),
      {.field = "the folder", .value = "", .rule = "cannot be made: " + error.message()});
}

absl::Status WriteImage(const std::filesystem::path& path, const SequenceFrame& frame,
                        const std::vector<std::uint16_t>& values) {
  const auto png = FormatPng16(frame.depth.width, frame.depth.height, values);
  if (!png.ok()) return png.status();
  return formats::WriteFileBytes(path.string(), *png);
}

absl::Status WriteSensor(const std::filesystem::path& folder, const SequenceRenderer& renderer,
                         std::size_t sensor_index, bool with_labels) {
  const SequenceScript& script = renderer.script();
  const SequenceSensor& sensor = script.sensors[sensor_index];
  absl::Status status = MakeFolder(with_labels ? folder / "labels" : folder);
  if (!status.ok()) return status;
  std::set<int> delivered;
  std::string frames;
  for (const perception::FrameDelivery& delivery :
       perception::FrameDeliveries(script, sensor_index)) {
    delivered.insert(delivery.frame);
    const double time_s = perception::FrameTime_s(sensor, delivery.frame);
    const Json json = {{"file", ImageName(delivery.frame)},
                       {"stamp", delivery.stamp_s},
                       {"delivery", delivery.delivery_s},
                       {"pose", PoseRow(perception::CameraAt(script, sensor, time_s).X_WC)}};
    frames += json.dump() + "\n";
  }
  std::string truth;
  for (const int k : delivered) {
    const SequenceFrame frame = renderer.Render(sensor_index, k);
    status = WriteImage(folder / ImageName(k), frame, DepthImageOf(frame));
    if (status.ok() && with_labels) {
      status = WriteImage(folder / "labels" / ImageName(k), frame,
                          LabelImageOf(frame, renderer.bodies()));
    }
    if (!status.ok()) return status;
    truth += TruthJson(frame, script).dump() + "\n";
  }
  std::vector<std::pair<std::string, std::string>> texts = {
      {"camera.json", CameraJson(sensor).dump(1) + "\n"},
      {"frames.jsonl", frames},
      {"truth.jsonl", truth}};
  if (!script.robots.empty()) texts.emplace_back("joint_states.jsonl", JointStateLines(script));
  for (const auto& [name, text] : texts) {
    status = formats::WriteFileBytes((folder / name).string(), text);
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

std::uint16_t LabelOf(const SequenceBody& body) {
  const auto index = static_cast<std::uint16_t>(std::min(body.index, kMaxLabelled - 1));
  switch (body.kind) {
    case SequenceBody::Kind::kObject:
      return static_cast<std::uint16_t>(std::min<std::size_t>(body.index + 1, kHandLabel - 1));
    case SequenceBody::Kind::kHand:
      return kHandLabel + index;
    case SequenceBody::Kind::kRobot:
      break;
  }
  return kRobotLabel + index;
}

}  // namespace

std::vector<std::uint16_t> DepthImageOf(const SequenceFrame& frame) {
  std::vector<std::uint16_t> values;
  values.reserve(frame.depth.depth_m.size());
  for (const float depth_m : frame.depth.depth_m) {
    const double units = std::round(static_cast<double>(depth_m) / kDepthUnit_m);
    values.push_back(static_cast<std::uint16_t>(std::clamp(units, 0.0, 65'535.0)));
  }
  return values;
}

std::vector<std::uint16_t> LabelImageOf(const SequenceFrame& frame,
                                        const std::vector<SequenceBody>& bodies) {
  std::vector<std::uint16_t> of_body;
  for (const SequenceBody& body : bodies) of_body.push_back(LabelOf(body));
  std::vector<std::uint16_t> labels;
  labels.reserve(frame.depth.object.size());
  for (const std::int32_t object : frame.depth.object) {
    if (object >= 0) {
      labels.push_back(of_body[static_cast<std::size_t>(object)]);
    } else {
      labels.push_back(object == perception::kMixedPixel ? kMixedLabel : 0);
    }
  }
  return labels;
}

absl::Status WriteSequence(const std::string& folder, const ScriptFile& file, bool with_labels) {
  const std::filesystem::path path(folder);
  absl::Status status = MakeFolder(path);
  if (!status.ok()) return status;
  const SequenceScript& script = file.script;
  status = WriteScene(
      (path / "scene.yaml").string(),
      {.scene = script.scene, .camera = perception::CameraAt(script, script.sensors[0], 0)});
  if (!status.ok()) return status;
  status = formats::WriteFileBytes((path / "sequence.json").string(), SequenceJson(file));
  if (!status.ok()) return status;
  const SequenceRenderer renderer(script);
  for (std::size_t i = 0; i < script.sensors.size(); ++i) {
    status = WriteSensor(path / script.sensors[i].name, renderer, i, with_labels);
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace cwm::simulator
