// cwm ingest
#include <memory>

#include "clients/cli/commands.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/scan_arguments.h"
#include "clients/cli/scan_ingest.h"
#include "clients/formats/file_bytes.h"

namespace cwm::cli {
namespace {

struct IngestArguments {
  std::vector<std::string> files;
  ScanArguments scan;
  std::string labels;
  std::string request_id;
  bool add = false;
  bool force = false;
};

absl::Status IngestFile(Session& session, const IngestArguments& arguments,
                        const cwm::v1::IngestCloudHeader& header, const std::string& file) {
  const auto bytes = formats::ReadFileBytes(file);
  if (!bytes.ok()) return bytes.status();
  return IngestScan(session, arguments.scan, header,
                    {.bytes = *bytes,
                     .name = file,
                     .title = arguments.files.size() > 1 ? file : "",
                     .labels_path = arguments.labels});
}

absl::Status Ingest(Session& session, const IngestArguments& arguments) {
  if (arguments.files.size() > 1 && !(arguments.labels.empty() && arguments.request_id.empty())) {
    return UsageError("--labels and --request-id belong to one FILE");
  }
  absl::Status name = CheckLabelledName("--labels", arguments.labels);
  if (!name.ok()) return name;
  auto header = ParseScanHeader(arguments.scan, session);
  if (!header.ok()) return header.status();
  header->set_mode(arguments.add ? cwm::v1::INGEST_MODE_ADD : cwm::v1::INGEST_MODE_UPDATE);
  header->set_want_point_labels(!arguments.labels.empty());
  header->set_request_id(arguments.request_id);
  header->set_force(arguments.force);
  for (const std::string& file : arguments.files) {
    if (absl::Status status = IngestFile(session, arguments, *header, file); !status.ok()) {
      return status;
    }
  }
  return absl::OkStatus();
}

}  // namespace

void AddIngestCommand(CommandLine& line) {
  const auto arguments = std::make_shared<IngestArguments>();
  CLI::App& command = AddCommand(
      line,
      {"ingest",
       "scans into the world: what is seen is added, moved, replaced or removed",
       {"cwm ingest scan.pcd", "cwm ingest scan1.pcd scan2.pcd --world kitchen --up 0,-1,0",
        "cwm ingest map.pcd --frame world --scale 0.001",
        "cwm ingest depth.png --intrinsics 525,525,319.5,239.5",
        "cwm ingest scan.ply --x-world-sensor 0,0,1.2,1,0,0,0 --labels labelled.pcd -o json"},
       "Files are PCD, PLY, XYZ or NPY in the sensor's frame, metres, told apart by their content. "
       "XYZ is\n"
       "text, x y z first on each line or columns that its header names; NPY what numpy.save "
       "writes of an\n"
       "array (N, 3), (H, W, 3) or of a structured one. Depth images are PNG of 16 bits, "
       "millimetres, or NPY\n"
       "(H, W). Several files are sent one after another, and the first that fails ends it.\n"
       "A scan that contradicts the world, because all supports would go or everything moved "
       "alike, is refused."},
      [arguments](Session& session) { return Ingest(session, *arguments); });
  command.add_option("FILE", arguments->files, "PCD, PLY, XYZ or NPY files, depth images")
      ->required();
  AddScanOptions(command, arguments->scan);
  AddScaleOption(command, arguments->scan);
  command.add_option("--labels", arguments->labels, "write the labelled cloud to this PCD file")
      ->type_name("OUT.pcd");
  command.add_flag("--add", arguments->add, "only add: nothing is removed or moved");
  command.add_flag("--force", arguments->force, "take a scan that contradicts the world");
  command.add_option("--request-id", arguments->request_id, "a retry under it is done once")
      ->type_name("ID");
}

}  // namespace cwm::cli
