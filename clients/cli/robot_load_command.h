// cwm robot load
#pragma once

#include "clients/cli/command.h"

namespace cwm::cli {

void AddRobotLoadCommand(CommandLine& line, CLI::App& family);

}  // namespace cwm::cli
