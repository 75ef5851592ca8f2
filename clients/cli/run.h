// The whole command line, streams passed in.
#pragma once

#include <string>
#include <vector>

#include "clients/cli/exit_code.h"
#include "clients/cli/session.h"
#include "clients/report/scan_page.h"

namespace cwm::cli {

// Arguments without the program's name; the environment gives CWM_ADDR and NO_COLOR. Without page
// assets `cwm report` is not offered.
ExitCode Run(const std::vector<std::string>& arguments, Streams streams,
             const report::PageAssets& page_assets = {});

}  // namespace cwm::cli
