#include <unistd.h>

#include <csignal>
#include <iostream>

#include "clients/cli/run.h"
#include "clients/web/report_assets.h"

int main(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);  // so that `cwm objects | head` ends quietly
  std::ios::sync_with_stdio(false);
  std::cin.tie(nullptr);  // a thread that reads must not flush what another one is writing
  const cwm::cli::Streams streams{.in = std::cin,
                                  .out = std::cout,
                                  .err = std::cerr,
                                  .in_is_terminal = ::isatty(STDIN_FILENO) != 0,
                                  .out_is_terminal = ::isatty(STDOUT_FILENO) != 0,
                                  .err_is_terminal = ::isatty(STDERR_FILENO) != 0};
  return static_cast<int>(cwm::cli::Run(std::vector<std::string>(argv + 1, argv + argc), streams,
                                        cwm::web::ReportAssets()));
}
