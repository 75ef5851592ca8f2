// Prints the result of a scan as a table.
#pragma once

#include <iosfwd>

#include "clients/cli/table.h"
#include "cwm/v1/perception.pb.h"

namespace cwm::cli {

// Counts, changes, objects with their labels, and the time of each stage.
void PrintScanReport(const cwm::v1::IngestCloudResponse& response, TableStyle style,
                     std::ostream& out);

}  // namespace cwm::cli
