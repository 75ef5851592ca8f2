// cwm report: the only command that needs more than the command line.
#pragma once

#include "clients/cli/command.h"
#include "clients/report/scan_page.h"

namespace cwm::cli {

// Adds `cwm report`. `assets` are the scripts and styles of its pages; they must outlive `line`. If
// they are empty, the command says that this program was built without pages.
void AddReportCommand(CommandLine& line, const report::PageAssets& assets);

}  // namespace cwm::cli
