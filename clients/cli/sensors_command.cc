// cwm sensors, cwm sensors set
#include <google/protobuf/util/time_util.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <ostream>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "clients/cli/commands.h"
#include "clients/cli/enum_names.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/number_list.h"
#include "clients/cli/quantity.h"
#include "clients/cli/table.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

struct SetArguments {
  std::string name, x_world_sensor;
  bool use_estimate = false;
};

std::string StateOf(const pb::Sensor& sensor) {
  if (sensor.is_streaming()) return "streams";
  if (!sensor.has_last_frame()) return "no frame";
  return absl::StrCat("until ", google::protobuf::util::TimeUtil::ToString(sensor.last_frame()));
}

std::string Degrees(double angle_rad) {
  return absl::StrCat(FormatFixed(angle_rad * 180 / std::numbers::pi, 2), " deg");
}

// "3.2 mm, 0.11 deg": from the used pose to the one that objects at rest suggest.
std::string PoseErrorOf(const pb::Sensor& sensor) {
  if (!sensor.has_estimate()) return "";
  return absl::StrCat(FormatLength(sensor.estimate().translation_error_m()), ", ",
                      Degrees(sensor.estimate().rotation_error_rad()));
}

std::string MountOf(const pb::Sensor& sensor) {
  if (!sensor.has_mount()) return "";
  return absl::StrCat(sensor.mount().robot(), ":", sensor.mount().link());
}

// The estimate and the contradictions, below the row.
std::string NoteOf(const pb::Sensor& sensor) {
  std::vector<std::string> notes;
  if (sensor.has_estimate()) {
    const pb::SensorPoseEstimate& estimate = sensor.estimate();
    notes.push_back(absl::StrCat("estimated at ", FormatPose(estimate.x_world_sensor()), ", sigma ",
                                 FormatLength(estimate.sigma_m()), " and ",
                                 Degrees(estimate.sigma_rad()), ", from ", estimate.surface_count(),
                                 estimate.surface_count() == 1 ? " surface" : " surfaces"));
  }
  if (!sensor.estimate_note().empty()) notes.push_back(sensor.estimate_note());
  notes.insert(notes.end(), sensor.conflicts().begin(), sensor.conflicts().end());
  return absl::StrJoin(notes, "; ");
}

void PrintSensors(const pb::ListSensorsResponse& response, TableStyle style, std::ostream& out) {
  static const std::vector<Column> kColumns = {{"NAME"},
                                               {"STATE"},
                                               {"ON"},
                                               {"RATE /s", Align::kRight},
                                               {"LATENCY ms", Align::kRight},
                                               {"P95 ms", Align::kRight},
                                               {"DELAY ms", Align::kRight},
                                               {"PROCESSED", Align::kRight},
                                               {"DROPPED", Align::kRight},
                                               {"REFUSED", Align::kRight},
                                               {"POSE ERROR"},
                                               {"POSE"}};
  std::vector<TableRow> rows;
  for (const pb::Sensor& sensor : response.sensors()) {
    const bool is_timed = sensor.frame_rate() > 0;
    rows.push_back({{sensor.name(), StateOf(sensor), MountOf(sensor),
                     is_timed ? FormatFixed(sensor.frame_rate(), 1) : "",
                     is_timed ? FormatFixed(sensor.latency_p50_ms(), 1) : "",
                     is_timed ? FormatFixed(sensor.latency_p95_ms(), 1) : "",
                     sensor.has_delay_ms() ? FormatFixed(sensor.delay_ms(), 1) : "",
                     absl::StrCat(sensor.processed_count()), absl::StrCat(sensor.dropped_count()),
                     absl::StrCat(sensor.refused_count()), PoseErrorOf(sensor),
                     sensor.has_x_world_sensor() ? FormatPose(sensor.x_world_sensor()) : ""},
                    NoteOf(sensor)});
  }
  if (rows.empty()) {
    out << "no sensors\n";
  } else {
    PrintTable(kColumns, rows, style, out);
  }
  out << "revision " << response.revision() << "\n";
}

absl::Status List(Session& session) {
  pb::ListSensorsRequest request;
  request.set_world(session.world);
  const client::Connection& connection = session.connection();
  const auto response =
      connection.Call(&pb::PerceptionService::Stub::ListSensors, connection.perception(), request);
  if (!response.ok()) return response.status();
  session.PrintList(
      *response,
      [&] {
        for (const pb::Sensor& sensor : response->sensors()) session.PrintLine(sensor);
      },
      [&] { PrintSensors(*response, session.table_style(), session.streams.out); });
  return absl::OkStatus();
}

absl::Status Set(Session& session, const SetArguments& arguments) {
  pb::SetSensorPoseRequest request;
  request.set_world(session.world);
  request.set_sensor(arguments.name);
  if (arguments.use_estimate == !arguments.x_world_sensor.empty()) {
    return UsageError("give --x-world-sensor or --estimate");
  }
  if (arguments.use_estimate) {
    request.set_use_estimate(true);
  } else {
    const auto pose = ParsePose(arguments.x_world_sensor, "--x-world-sensor");
    if (!pose.ok()) return pose.status();
    *request.mutable_x_world_sensor() = PoseToProto(*pose);
  }
  const client::Connection& connection = session.connection();
  const auto response = connection.Call(&pb::PerceptionService::Stub::SetSensorPose,
                                        connection.perception(), request);
  if (!response.ok()) return response.status();
  session.Print(*response, [&] {
    session.streams.out << arguments.name << " at " << FormatPose(response->x_world_sensor())
                        << "\n";
  });
  return absl::OkStatus();
}

}  // namespace

void AddSensorsCommand(CommandLine& line) {
  CLI::App& sensors = AddCommand(
      line,
      {"sensors",
       "the running sensors of the world: pose, rate, latency, errors",
       {"cwm sensors", "cwm sensors -o json", "cwm sensors set wrist --estimate"},
       "The pose error is the distance between the used pose and the one that surfaces at rest "
       "suggest;\n"
       "cwm sensors set applies it. The delay is the least one between stamps and arrival, and "
       "negative where\n"
       "the sensor's clock is ahead."},
      [](Session& session) { return List(session); });
  const auto arguments = std::make_shared<SetArguments>();
  CLI::App& set = AddCommand(line, sensors,
                             {"set",
                              "sets the pose of a sensor in the world",
                              {"cwm sensors set table --x-world-sensor 0,0,1.2,1,0,0,0",
                               "cwm sensors set table --estimate"},
                              "Later frames use it, unless they bring poses of their own."},
                             [arguments](Session& session) { return Set(session, *arguments); });
  set.add_option("NAME", arguments->name, "of the sensor")->required();
  set.add_option("--x-world-sensor", arguments->x_world_sensor, "the sensor's pose (m)")
      ->type_name("X,Y,Z,QX,QY,QZ,QW");
  set.add_flag("--estimate", arguments->use_estimate, "the pose that cwm sensors reports");
}

}  // namespace cwm::cli
