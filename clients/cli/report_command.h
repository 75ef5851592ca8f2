// cwm report: the only command that needs more than the command line.
#pragma once

#include "clients/cli/command.h"
#include "clients/report/scan_page.h"

namespace cwm::cli {

// The assets are the parts of the page and must outlive the line. Without them the command reports
// that this program cannot make pages.
void AddReportCommand(CommandLine& line, const report::PageAssets& assets);

}  // namespace cwm::cli
