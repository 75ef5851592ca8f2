// The whole command line, with the streams passed in.
#pragma once

#include <string>
#include <vector>

#include "clients/cli/exit_code.h"
#include "clients/cli/session.h"
#include "clients/report/scan_page.h"

namespace cwm::cli {

// `arguments` excludes the program's name; CWM_ADDR and NO_COLOR are read from the environment.
// Without page assets `cwm report` is not available.
ExitCode Run(const std::vector<std::string>& arguments, Streams streams,
             const report::PageAssets& page_assets = {});

}  // namespace cwm::cli
