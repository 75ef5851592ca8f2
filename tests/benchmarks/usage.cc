#include "tests/benchmarks/usage.h"

#include <algorithm>
#include <cstdio>
#include <string_view>

namespace cwm::benchmarks {

bool PrintsUsage(int argc, char** argv, const char* usage) {
  const bool asks = std::any_of(argv + 1, argv + argc, [](std::string_view word) {
    return word == "--help" || word == "-h";
  });
  if (asks) std::fputs(usage, stdout);
  return asks;
}

}  // namespace cwm::benchmarks
