// Ingests a scan's file into the world; used by `cwm ingest` for each file and by `cwm import`.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "clients/cli/scan_arguments.h"
#include "clients/cli/session.h"
#include "cwm/v1/perception.pb.h"

namespace cwm::cli {

// The bytes of a file of that name, and the title printed above its report (if there are several).
struct ScanFile {
  std::string_view bytes;
  std::string name;
  std::string title = {};
  std::string labels_path = {};  // the path of the labelled cloud; empty: none
};

// Sends the cloud with the header, made of the options `scan`, and prints the result. The vertices
// of a PLY with faces are used as a cloud, with a warning.
absl::Status IngestScan(Session& session, const ScanArguments& scan,
                        cwm::v1::IngestCloudHeader header, const ScanFile& file);

}  // namespace cwm::cli
