// Passes the files of the given folders to a fuzz target, one after the other. Fails on a crash, on
// a broken contract, and on a file that takes too long.
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <set>
#include <string>

#include "tests/fuzz/fuzz_target.h"

namespace {

// chosen: processor time. A second suffices without sanitizers, which slow down by an order of
// magnitude.
constexpr double kMaxSeconds = 10;

bool Replay(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  std::cout << path.filename().string() << ": " << bytes.size() << " bytes" << std::endl;
  const std::clock_t start = std::clock();
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  if (seconds <= kMaxSeconds) return true;
  std::cerr << "took " << seconds << " s, must take at most " << kMaxSeconds << "\n";
  return false;
}

}  // namespace

int main(int argc, char** argv) {
  std::set<std::filesystem::path> paths;
  for (int i = 1; i < argc; ++i) {
    for (const auto& entry : std::filesystem::directory_iterator(argv[i]))
      paths.insert(entry.path());
  }
  if (paths.empty()) {
    std::cerr << "names no folder with files\n";
    return 1;
  }
  bool all_passed = true;
  for (const auto& path : paths) all_passed = Replay(path) && all_passed;
  return all_passed ? 0 : 1;
}
