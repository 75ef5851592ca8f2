// Converts scans that a world keeps for display.
#pragma once

#include "cwm/v1/perception.pb.h"
#include "server/core/kept_scans.h"

namespace cwm::server {

v1::Scan ScanToProto(const KeptScan& scan);

}  // namespace cwm::server
