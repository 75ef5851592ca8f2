// The script and the style of the report's page.
#pragma once

#include "clients/report/scan_page.h"

namespace cwm::web {

// Bundled from src/report at build time; they live as long as the process.
report::PageAssets ReportAssets();

}  // namespace cwm::web
