#include "clients/cli/scan_arguments.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "clients/cli/enum_names.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/number_list.h"
#include "clients/cli/progress.h"
#include "clients/cpp/cloud_upload.h"
#include "clients/formats/cloud_reader.h"
#include "clients/formats/depth_image.h"
#include "clients/formats/file_bytes.h"
#include "clients/formats/frame_sequence.h"
#include "clients/formats/pcd.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

absl::StatusOr<pb::CloudFrame> ParseFrame(const std::string& text) {
  static const std::map<std::string, pb::CloudFrame> kNames = ShortNames<pb::CloudFrame>();
  if (const auto named = kNames.find(text); named != kNames.end()) return named->second;
  return UsageError(absl::StrCat("--frame: \"", text, "\" must be sensor or world"));
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

absl::StatusOr<pb::SensorModel> ParseSensorModel(const std::string& text) {
  static const std::map<std::string, pb::SensorModel::Kind> kModels =
      ShortNames<pb::SensorModel::Kind>();
  pb::SensorModel model;
  if (const auto named = kModels.find(text);
      named != kModels.end() && text != "constant" && text != "quadratic") {
    model.set_kind(named->second);
    return model;
  }
  const auto numbers = ParseNumbers(text, "--sensor-model", "SIGMA[,QUADRATIC]");
  const auto is_valid = [](double number) { return std::isfinite(number) && number >= 0; };
  if (!numbers.ok() || numbers->size() > 2 || !std::ranges::all_of(*numbers, is_valid) ||
      std::ranges::all_of(*numbers, [](double number) { return number == 0; })) {
    return UsageError(
        absl::StrCat("--sensor-model: \"", text,
                     "\" must be kinect, realsense, time_of_flight, tilting_laser, a standard "
                     "deviation in metres, or A,B for A + B z^2 metres at depth z"));
  }
  model.set_kind(numbers->size() == 1 ? pb::SensorModel::KIND_CONSTANT
                                      : pb::SensorModel::KIND_QUADRATIC);
  model.set_sigma_m(numbers->front());
  if (numbers->size() == 2) model.set_quadratic_per_m(numbers->back());
  return model;
}

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
                  "kinect (default), realsense, time_of_flight, tilting_laser, sigma in m, or A,B: "
                  "sigma = A + B z^2 at depth z")
      ->type_name("MODEL|SIGMA|A,B");
  command.add_option("--sensor", scan.sensor, "names the sensor whose estimated pose is kept")
      ->type_name("NAME");
  command
      .add_option("--clusters", scan.clusters,
                  "objects (default), or none: clutter that nothing tells apart")
      ->type_name("objects|none");
  command
      .add_option("--frame", scan.frame,
                  "of the points: sensor (default), or world: z is up and no pose is needed")
      ->type_name("sensor|world");
  command
      .add_option("--viewpoint", scan.viewpoint,
                  "where the points were seen from, in their frame (m); default: its origin, or "
                  "unknown in the world's frame")
      ->type_name("X,Y,Z");
  AddIntrinsicsOption(command, scan.intrinsics);
}

void AddIntrinsicsOption(CLI::App& command, std::string& intrinsics) {
  command
      .add_option("--intrinsics,--camera", intrinsics,
                  "of depth images, in pixels or as a file (JSON, YAML, a matrix); default: the "
                  "camera.json or camera-intrinsics.txt beside them")
      ->type_name("FX,FY,CX,CY|FILE");
}

void AddScaleOption(CLI::App& command, ScanArguments& scan) {
  command
      .add_option(
          "--scale", scan.scale,
          "metres per unit of the coordinates: 0.001 for millimetres, which depth images of "
          "integers have without it")
      ->type_name("FACTOR");
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
  const auto frame = ParseFrame(scan.frame);
  if (!frame.ok()) return frame.status();
  header.set_frame(*frame);
  if (!scan.viewpoint.empty()) {
    const auto viewpoint = ParseVector(scan.viewpoint, "--viewpoint");
    if (!viewpoint.ok()) return viewpoint.status();
    *header.mutable_viewpoint() = *viewpoint;
  }
  header.set_scale(scan.scale);
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

bool HasViewpoint(const formats::CloudFile& cloud) {
  return cloud.viewpoint != formats::CloudFile{}.viewpoint;
}

absl::StatusOr<formats::DepthCamera> ReadCamera(const std::string& path) {
  const auto text = formats::ReadFileBytes(path);
  if (!text.ok()) return text.status();
  return formats::ParseDepthCamera(*text, path);
}

// Programs disagree about the meaning of VIEWPOINT for a file's points: some turn the points by it
// for display, in others it is a place in the points' own frame. So it is not used by itself.
void WarnAboutViewpoint(Session& session, const formats::CloudFile& cloud,
                        const std::string& file) {
  const std::array<double, 7>& v = cloud.viewpoint;
  if (!HasViewpoint(cloud)) return;
  session.Warn(absl::StrCat(
      file, ": VIEWPOINT is not used; if it is the sensor's pose and the points are in its frame, ",
      "say --x-world-sensor ", absl::StrJoin({v[0], v[1], v[2], v[4], v[5], v[6], v[3]}, ","),
      "; if the points are in the world's frame, say --frame world"));
}

}  // namespace

absl::StatusOr<formats::DepthCamera> ReadCameraOf(const std::string& image,
                                                  const std::string& intrinsics) {
  if (intrinsics.empty()) {
    const std::string beside =
        formats::FindCameraFile(std::filesystem::path(image).parent_path().string());
    if (!beside.empty()) return ReadCamera(beside);
    return UsageError(absl::StrCat(image,
                                   " is a depth image: give --intrinsics FX,FY,CX,CY in "
                                   "pixels, or its camera's file"));
  }
  if (!StartsWithNumber(intrinsics)) return ReadCamera(intrinsics);
  const auto k = ParseNumbers(intrinsics, {"--intrinsics", "FX,FY,CX,CY (pixels)", 4});
  if (!k.ok()) return k.status();
  const bool finite = std::ranges::all_of(*k, [](double number) { return std::isfinite(number); });
  if (!finite || (*k)[0] <= 0 || (*k)[1] <= 0) {
    return UsageError(
        absl::StrCat("--intrinsics: \"", intrinsics, "\" must be finite, FX and FY positive"));
  }
  return formats::DepthCamera{
      .fx_px = (*k)[0], .fy_px = (*k)[1], .cx_px = (*k)[2], .cy_px = (*k)[3]};
}

pb::DepthLayout DepthLayoutOf(const formats::DepthImage& image, const formats::DepthCamera& camera,
                              std::optional<double> unit_m) {
  pb::DepthLayout layout;
  layout.set_type(image.type == formats::Scalar::kU16 ? pb::DEPTH_TYPE_U16 : pb::DEPTH_TYPE_F32);
  layout.set_width(static_cast<int>(image.width));
  layout.set_height(static_cast<int>(image.height));
  layout.set_unit_m(unit_m ? *unit_m : camera.unit_m.value_or(image.unit_m));
  pb::Pinhole& pinhole = *layout.mutable_pinhole();
  pinhole.set_fx_px(camera.fx_px);
  pinhole.set_fy_px(camera.fy_px);
  pinhole.set_cx_px(camera.cx_px);
  pinhole.set_cy_px(camera.cy_px);
  return layout;
}

absl::StatusOr<formats::CloudFile> ParseScan(std::string_view bytes, const std::string& path,
                                             const ScanArguments& scan,
                                             pb::IngestCloudHeader& header) {
  if (formats::IsDepthImage(bytes)) {
    const auto camera = ReadCameraOf(path, scan.intrinsics);
    if (!camera.ok()) return camera.status();
    header.clear_scale();
    const auto unit_m = scan.scale > 0 ? std::optional(scan.scale) : std::nullopt;
    return formats::ParseDepthImage(bytes, path, *camera, unit_m);
  }
  if (!scan.intrinsics.empty()) {
    return UsageError(absl::StrCat("--intrinsics: ", path, " is no depth image"));
  }
  auto cloud = formats::ParseCloud(bytes, path);
  if (!cloud.ok()) return cloud.status();
  if (header.frame() == pb::CLOUD_FRAME_WORLD && !header.has_viewpoint() && HasViewpoint(*cloud)) {
    header.mutable_viewpoint()->set_x(cloud->viewpoint[0]);
    header.mutable_viewpoint()->set_y(cloud->viewpoint[1]);
    header.mutable_viewpoint()->set_z(cloud->viewpoint[2]);
  }
  return cloud;
}

namespace {

// Shows how much of a scan was sent, as parts of `step` bytes, and when the server works on it.
client::Progress ShowSending(Progress& progress, std::int64_t step, std::int64_t count,
                             const std::string& unit) {
  return [&progress, step, count, unit](std::int64_t sent, std::int64_t total) {
    if (sent >= total) {
      return progress.ShowStage(absl::StrCat("the server interprets ", count, " ", unit));
    }
    Transfer transfer{.action = "sending", .moved_bytes = sent, .total_bytes = total};
    transfer.detail = FormatCount(transfer, step, unit);
    progress.Update(transfer);
  };
}

}  // namespace

absl::StatusOr<pb::IngestCloudResponse> SendScan(Session& session,
                                                 const pb::IngestCloudHeader& header,
                                                 const formats::CloudFile& cloud,
                                                 const std::string& file) {
  const auto geometry = client::SelectGeometry(cloud);
  if (!geometry.ok()) return WithFile(geometry.status(), file);
  const bool is_placed = header.has_x_world_sensor() || header.has_viewpoint();
  if (!is_placed) WarnAboutViewpoint(session, cloud, file);
  Progress progress(session);
  return client::IngestCloud(session.connection(), header, *geometry,
                             ShowSending(progress, static_cast<std::int64_t>(geometry->point_step),
                                         geometry->size(), "points"));
}

absl::StatusOr<pb::IngestCloudResponse> SendDepth(Session& session, pb::IngestCloudHeader header,
                                                  std::string_view bytes, const std::string& path,
                                                  const ScanArguments& scan) {
  const auto camera = ReadCameraOf(path, scan.intrinsics);
  if (!camera.ok()) return camera.status();
  const auto image = formats::ReadDepthImage(bytes, path);
  if (!image.ok()) return image.status();
  const auto unit_m = scan.scale > 0 ? std::optional(scan.scale) : std::nullopt;
  *header.mutable_depth() = DepthLayoutOf(*image, *camera, unit_m);
  header.clear_scale();
  Progress progress(session);
  return client::IngestDepth(
      session.connection(), std::move(header), image->bytes,
      ShowSending(progress, static_cast<std::int64_t>(formats::SizeOf(image->type)),
                  image->width * image->height, "pixels"));
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
