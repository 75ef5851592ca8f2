#include "clients/cli/scan_arguments.h"

#include <array>
#include <cmath>
#include <filesystem>
#include <map>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "clients/cli/enum_names.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/number_list.h"
#include "clients/cli/progress.h"
#include "clients/cpp/cloud_upload.h"
#include "clients/formats/file_bytes.h"
#include "clients/formats/pcd.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

absl::StatusOr<pb::SensorModel> ParseSensorModel(const std::string& text) {
  static const std::map<std::string, pb::SensorModel::Kind> kModels =
      ShortNames<pb::SensorModel::Kind>();
  pb::SensorModel model;
  if (const auto named = kModels.find(text); named != kModels.end() && text != "constant") {
    model.set_kind(named->second);
    return model;
  }
  double sigma_m = 0;
  if (!absl::SimpleAtod(text, &sigma_m) || !std::isfinite(sigma_m) || sigma_m <= 0) {
    return UsageError(
        absl::StrCat("--sensor-model: \"", text,
                     "\" must be kinect, realsense, time_of_flight, tilting_laser or a "
                     "standard deviation in metres"));
  }
  model.set_kind(pb::SensorModel::KIND_CONSTANT);
  model.set_sigma_m(sigma_m);
  return model;
}

absl::StatusOr<pb::Clustering> ParseClustering(const std::string& text) {
  static const std::map<std::string, pb::Clustering> kNames = ShortNames<pb::Clustering>();
  if (const auto named = kNames.find(text); named != kNames.end()) return named->second;
  return UsageError(absl::StrCat("--clusters: \"", text, "\" must be objects or none"));
}

absl::Status WithFile(const absl::Status& status, const std::string& file) {
  return absl::Status(status.code(), absl::StrCat(file, ": ", std::string(status.message())));
}

}  // namespace

void AddScanOptions(CLI::App& command, ScanArguments& scan) {
  command
      .add_option("--x-world-sensor", scan.x_world_sensor,
                  "the sensor's pose in the world (m); default: estimated, and kept")
      ->type_name("X,Y,Z,QX,QY,QZ,QW");
  command
      .add_option(
          "--up", scan.up,
          "upwards in the sensor's frame, or auto (default): the largest plane that an upright "
          "camera can see from above; makes a new estimate where a kept one differs, but "
          "overrules no pose that was given")
      ->type_name("auto|X,Y,Z");
  command
      .add_option("--sensor-model", scan.sensor_model,
                  "kinect (default), realsense, time_of_flight, tilting_laser, or sigma in m")
      ->type_name("MODEL|SIGMA");
  command.add_option("--sensor", scan.sensor, "names the sensor whose estimated pose is kept")
      ->type_name("NAME");
  command
      .add_option("--clusters", scan.clusters,
                  "objects (default), or none: clutter that nothing tells apart")
      ->type_name("objects|none");
}

absl::StatusOr<pb::IngestCloudHeader> ParseScanHeader(const ScanArguments& scan,
                                                      const Session& session) {
  pb::IngestCloudHeader header;
  header.set_world(session.world);
  header.set_sensor(scan.sensor);
  if (!scan.x_world_sensor.empty()) {
    const auto pose = ParsePose(scan.x_world_sensor, "--x-world-sensor");
    if (!pose.ok()) return pose.status();
    *header.mutable_x_world_sensor() = PoseToProto(*pose);
  }
  if (scan.up != "auto") {
    const auto up = ParseVector(scan.up, "--up");
    if (!up.ok()) return up.status();
    *header.mutable_up() = *up;
  }
  if (!scan.sensor_model.empty()) {
    const auto model = ParseSensorModel(scan.sensor_model);
    if (!model.ok()) return model.status();
    *header.mutable_sensor_model() = *model;
  }
  if (!scan.clusters.empty()) {
    const auto clustering = ParseClustering(scan.clusters);
    if (!clustering.ok()) return clustering.status();
    header.mutable_options()->set_clustering(*clustering);
  }
  return header;
}

namespace {

// Programs disagree about the meaning of VIEWPOINT for a file's points, so it is not used as a
// pose.
void WarnAboutViewpoint(Session& session, const formats::CloudFile& cloud,
                        const std::string& file) {
  const std::array<double, 7>& v = cloud.viewpoint;
  if (v == formats::CloudFile{}.viewpoint) return;
  session.Warn(absl::StrCat(file, ": VIEWPOINT is not taken for the sensor's pose; if it is, say ",
                            "--x-world-sensor ",
                            absl::StrJoin({v[0], v[1], v[2], v[4], v[5], v[6], v[3]}, ",")));
}

}  // namespace

absl::StatusOr<pb::IngestCloudResponse> SendScan(Session& session,
                                                 const pb::IngestCloudHeader& header,
                                                 const formats::CloudFile& cloud,
                                                 const std::string& file) {
  const auto geometry = client::SelectGeometry(cloud);
  if (!geometry.ok()) return WithFile(geometry.status(), file);
  if (!header.has_x_world_sensor()) WarnAboutViewpoint(session, cloud, file);
  Progress progress(session);
  const auto show = [&](std::int64_t sent, std::int64_t total) {
    if (sent >= total) {
      return progress.ShowStage(
          absl::StrCat("the server interprets ", geometry->size(), " points"));
    }
    Transfer transfer{.action = "sending", .moved_bytes = sent, .total_bytes = total};
    transfer.detail =
        FormatCount(transfer, static_cast<std::int64_t>(geometry->point_step), "points");
    progress.Update(transfer);
  };
  return client::IngestCloud(session.connection(), header, *geometry, show);
}

absl::Status CheckLabelledName(const std::string& argument, const std::string& path) {
  const std::string extension =
      absl::AsciiStrToLower(std::filesystem::path(path).extension().string());
  if (extension.empty() || extension == ".pcd") return absl::OkStatus();
  return UsageError(absl::StrCat(argument, ": \"", path, "\" must end in .pcd"));
}

absl::Status WriteLabelled(Session& session, const pb::IngestCloudResponse& response,
                           const formats::CloudFile& cloud, const std::string& path) {
  const auto labels = client::ReadLabels(session.connection(), response, cloud.size());
  if (!labels.ok()) return labels.status();
  const auto pcd =
      formats::FormatPcd(formats::WithLabels(cloud, *labels), formats::PcdData::kBinaryCompressed);
  if (!pcd.ok()) return WithFile(pcd.status(), path);
  return formats::WriteFileBytes(path, *pcd);
}

}  // namespace cwm::cli
