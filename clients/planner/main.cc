#include <csignal>
#include <iostream>
#include <string>
#include <vector>

#include "clients/planner/command.h"

int main(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);
  return cwm::planner::Run(std::vector<std::string>(argv + 1, argv + argc), std::cout, std::cerr);
}
