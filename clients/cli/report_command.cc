#include "clients/cli/report_command.h"

#include <google/protobuf/util/time_util.h>

#include <filesystem>
#include <memory>
#include <ostream>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/message_json.h"
#include "clients/cli/progress.h"
#include "clients/cli/quantity.h"
#include "clients/cli/scan_arguments.h"
#include "clients/cpp/cloud_upload.h"
#include "clients/cpp/geometry_transfer.h"
#include "clients/formats/file_bytes.h"
#include "clients/report/scan_page.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;
using Meshes = std::map<std::string, formats::MeshFile>;

struct ReportArguments {
  std::string scan_file, page_file;
  ScanArguments scan;
};

absl::Status CheckPageName(const std::string& path) {
  const std::string extension =
      absl::AsciiStrToLower(std::filesystem::path(path).extension().string());
  if (extension == ".html" || extension == ".htm") return absl::OkStatus();
  return UsageError(absl::StrCat("OUT: \"", path, "\" must end in .html"));
}

void CollectHashes(const pb::Object& object, Meshes& meshes) {
  for (const pb::ShapePart& part : object.shapes()) {
    if (part.has_mesh()) meshes[part.mesh().hash()];
    if (part.has_convex()) meshes[part.convex().hash()];
  }
  for (const pb::SurfacePart& surface : object.surfaces()) meshes[surface.hash()];
  for (const pb::Handle& handle : object.handles()) {
    if (!handle.hash().empty()) meshes[handle.hash()];
  }
}

// Reads every mesh that the reply names.
absl::StatusOr<Meshes> FetchMeshes(Session& session, const pb::IngestCloudResponse& response) {
  Meshes meshes;
  for (const pb::Object& support : response.supports()) CollectHashes(support, meshes);
  for (const pb::Object& object : response.objects()) CollectHashes(object, meshes);
  for (auto& [hash, mesh] : meshes) {
    const auto blob = client::ReadGeometry(session.connection(), hash);
    if (!blob.ok()) return blob.status();
    auto decoded = client::DecodeMesh(blob->bytes);
    if (!decoded.ok()) return decoded.status();
    mesh = *std::move(decoded);
  }
  return meshes;
}

// The server's result for the scan in the page's form.
absl::StatusOr<report::ScanRecord> Record(Session& session, const ReportArguments& arguments,
                                          const report::LabelledCloud& scan,
                                          pb::IngestCloudResponse response) {
  response.clear_labels();  // they are sent with the points
  auto meshes = FetchMeshes(session, response);
  if (!meshes.ok()) return meshes.status();
  return report::ScanRecord{
      .file = std::filesystem::path(arguments.scan_file).filename().string(),
      .made = google::protobuf::util::TimeUtil::ToString(
          google::protobuf::util::TimeUtil::TimeTToTimestamp(std::time(nullptr))),
      .program = "cwm " CWM_VERSION,
      .sensor_model = arguments.scan.sensor_model.empty() ? "kinect" : arguments.scan.sensor_model,
      .response_json = ToJson(response, JsonStyle::kOneLine),
      .points = report::PackPoints(scan),
      .meshes = *std::move(meshes)};
}

absl::Status Report(Session& session, const ReportArguments& arguments,
                    const report::PageAssets& assets) {
  if (assets.script.empty()) {
    return absl::UnimplementedError("this program was built without the pages of clients/web");
  }
  absl::Status name = CheckPageName(arguments.page_file);
  if (!name.ok()) return name;
  auto header = ParseScanHeader(arguments.scan, session);
  if (!header.ok()) return header.status();
  header->set_mode(pb::INGEST_MODE_SEGMENT_ONLY);
  header->set_want_point_labels(true);
  const auto bytes = formats::ReadFileBytes(arguments.scan_file);
  if (!bytes.ok()) return bytes.status();
  const auto cloud = ParseScan(*bytes, arguments.scan_file, arguments.scan, *header);
  if (!cloud.ok()) return cloud.status();
  auto response = SendScan(session, *header, *cloud, arguments.scan_file);
  if (!response.ok()) return response.status();
  const auto labels = client::ReadLabels(session.connection(), *response, cloud->size());
  if (!labels.ok()) return labels.status();
  const double scale = header->scale() > 0 ? header->scale() : 1;
  const auto record =
      Record(session, arguments, {.cloud = *cloud, .labels = *labels, .scale = scale}, *response);
  if (!record.ok()) return record.status();
  const std::string page = report::FormatScanPage(*record, assets);
  absl::Status written = formats::WriteFileBytes(arguments.page_file, page);
  if (!written.ok()) return written;
  response->clear_labels();
  session.Print(*response, [&] {
    session.streams.out << arguments.page_file << ": "
                        << FormatBytes(static_cast<double>(page.size())) << ", supports "
                        << response->supports_size() << ", objects " << response->objects_size()
                        << "; open it in a browser\n";
  });
  return absl::OkStatus();
}

}  // namespace

void AddReportCommand(CommandLine& line, const report::PageAssets& assets) {
  const auto arguments = std::make_shared<ReportArguments>();
  CLI::App& command = AddCommand(
      line,
      {"report",
       "a page with pictures and figures of a scan; the world stays as it is",
       {"cwm report scan.pcd scan.html", "cwm report scan.ply scan.html --sensor-model 0.002"},
       "Writes one self-contained page: the scan's segmentation, its shapes, its surfaces and the "
       "hybrid of\n"
       "both, to be turned with the mouse; the coefficients of every shape with their quality; "
       "counts and the\n"
       "time of each stage. The page needs a browser with WebGL 2 and no network."},
      [arguments, assets](Session& session) { return Report(session, *arguments, assets); });
  command.add_option("SCAN", arguments->scan_file, "a PCD, PLY, XYZ or NPY file, or a depth image")
      ->required();
  command.add_option("OUT", arguments->page_file, "the page, *.html")->required();
  AddScanOptions(command, arguments->scan);
  AddScaleOption(command, arguments->scan);
}

}  // namespace cwm::cli
