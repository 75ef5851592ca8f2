// The usage text of the programs here.
#pragma once

namespace cwm::benchmarks {

// True if an argument is --help or -h: `usage` was printed then, and nothing is to be measured.
bool PrintsUsage(int argc, char** argv, const char* usage);

}  // namespace cwm::benchmarks
