// cwm report: the one command that needs something of the program beside the command line.
#pragma once

#include "clients/cli/command.h"
#include "clients/report/scan_page.h"

namespace cwm::cli {

// The assets are what pages are made of and must outlive the line. Without them the command says that
// this program makes no pages.
void AddReportCommand(CommandLine& line, const report::PageAssets& assets);

}  // namespace cwm::cli
