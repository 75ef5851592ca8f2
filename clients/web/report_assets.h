// The program and the style of the report's page.
#pragma once

#include "clients/report/scan_page.h"

namespace cwm::web {

// As this build bundled them from src/report; they live as long as the process.
report::PageAssets ReportAssets();

}  // namespace cwm::web
