// A scan's file into the world: what `cwm ingest` does to each, and `cwm import` to one.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "clients/cli/session.h"
#include "cwm/v1/perception.pb.h"

namespace cwm::cli {

// The bytes of a file of that name, and what is printed above its report (a name among several).
struct ScanFile {
  std::string_view bytes;
  std::string name;
  std::string title = {};
  std::string labels_path = {};  // the labelled cloud goes there; empty: nowhere
};

// Sends the cloud under the header and prints what came of it. A PLY that has faces is taken for its
// vertices, with a warning.
absl::Status IngestScan(Session& session, const cwm::v1::IngestCloudHeader& header,
                        const ScanFile& file);

}  // namespace cwm::cli
