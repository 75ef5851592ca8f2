// What the programs here say when they are asked how they are called.
#pragma once

namespace cwm::benchmarks {

// True when an argument is --help or -h: `usage` was printed then, and nothing is to be measured.
bool PrintsUsage(int argc, char** argv, const char* usage);

}  // namespace cwm::benchmarks
