#include "clients/cli/scan_ingest.h"

#include <ostream>

#include "absl/strings/str_cat.h"
#include "clients/cli/scan_report.h"
#include "clients/formats/depth_image.h"
#include "clients/formats/ply.h"

namespace cwm::cli {

absl::Status IngestScan(Session& session, const ScanArguments& scan,
                        cwm::v1::IngestCloudHeader header, const ScanFile& file) {
  // The points of a depth image are needed for its labels alone.
  const bool is_sent_as_image = formats::IsDepthImage(file.bytes) && file.labels_path.empty();
  const auto cloud = is_sent_as_image ? absl::StatusOr<formats::CloudFile>(formats::CloudFile())
                                      : ParseScan(file.bytes, file.name, scan, header);
  if (!cloud.ok()) return cloud.status();
  if (formats::HasPlyFaces(file.bytes)) {
    session.Warn(absl::StrCat(file.name,
                              ": has faces, its vertices are taken as a scan; `cwm import` puts it "
                              "as a mesh"));
  }
  auto response = is_sent_as_image ? SendDepth(session, header, file.bytes, file.name, scan)
                                   : SendScan(session, header, *cloud, file.name);
  if (!response.ok()) return response.status();
  if (!file.labels_path.empty()) {
    absl::Status written = WriteLabelled(session, *response, *cloud, file.labels_path);
    if (!written.ok()) return written;
    response->clear_labels();  // they are in the labelled file
  }
  session.Print(*response, [&] {
    if (!file.title.empty()) session.streams.out << file.title << "\n";
    PrintScanReport(*response, session.table_style(), session.streams.out);
    if (!file.title.empty()) session.streams.out << "\n";
  });
  session.streams.out.flush();
  return absl::OkStatus();
}

}  // namespace cwm::cli
