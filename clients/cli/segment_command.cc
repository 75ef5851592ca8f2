// cwm segment
#include <memory>
#include <ostream>

#include "clients/cli/commands.h"
#include "clients/cli/scan_arguments.h"
#include "clients/cli/scan_report.h"
#include "clients/formats/file_bytes.h"

namespace cwm::cli {
namespace {

struct SegmentArguments {
  std::string input, output;
  ScanArguments scan;
};

absl::Status Segment(Session& session, const SegmentArguments& arguments) {
  absl::Status name = CheckLabelledName("OUT", arguments.output);
  if (!name.ok()) return name;
  auto header = ParseScanHeader(arguments.scan, session);
  if (!header.ok()) return header.status();
  header->set_mode(cwm::v1::INGEST_MODE_SEGMENT_ONLY);
  header->set_want_point_labels(true);
  const auto bytes = formats::ReadFileBytes(arguments.input);
  if (!bytes.ok()) return bytes.status();
  const auto cloud = ParseScan(*bytes, arguments.input, arguments.scan, *header);
  if (!cloud.ok()) return cloud.status();
  auto response = SendScan(session, *header, *cloud, arguments.input);
  if (!response.ok()) return response.status();
  absl::Status written = WriteLabelled(session, *response, *cloud, arguments.output);
  if (!written.ok()) return written;
  response->clear_labels();  // they are in the labelled file
  session.Print(*response,
                [&] { PrintScanReport(*response, session.table_style(), session.streams.out); });
  return absl::OkStatus();
}

}  // namespace

void AddSegmentCommand(CommandLine& line) {
  const auto arguments = std::make_shared<SegmentArguments>();
  CLI::App& command =
      AddCommand(line,
                 {"segment",
                  "labels every point of a scan; the world stays as it is",
                  {"cwm segment scan.pcd labelled.pcd",
                   "cwm segment scan.ply labelled.pcd --sensor-model 0.002"},
                  "Writes the input cloud, same points in the same order, with a four-byte "
                  "unsigned `label` field:\n"
                  "0 unexplained, 1 to 9 the supports, object i from 1 on 10 (i + 1) + part. A "
                  "label of the input is\n"
                  "ignored and replaced."},
                 [arguments](Session& session) { return Segment(session, *arguments); });
  command.add_option("IN", arguments->input, "a PCD, PLY, XYZ or NPY file, or a depth image")
      ->required();
  command.add_option("OUT", arguments->output, "the labelled PCD file")->required();
  AddScanOptions(command, arguments->scan);
  AddScaleOption(command, arguments->scan);
}

}  // namespace cwm::cli
