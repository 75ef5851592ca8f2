#include "server/core/heap_memory.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstddef>
#include <cstring>
#include <fstream>
#include <memory>
#include <thread>
#include <vector>

namespace cwm::server {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kHasOwnHeap = true;  // the sanitizer's heap
#elif defined(__has_feature)
constexpr bool kHasOwnHeap = __has_feature(address_sanitizer) || __has_feature(thread_sanitizer);
#else
constexpr bool kHasOwnHeap = false;
#endif

std::size_t ResidentBytes() {
  std::ifstream statm("/proc/self/statm");
  std::size_t size = 0, resident = 0;
  statm >> size >> resident;
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

using Blocks = std::vector<std::unique_ptr<char[]>>;

// Blocks too small to be mapped on their own, all touched.
Blocks MakeBlocks(std::size_t bytes) {
  constexpr std::size_t kBlock_bytes = 100'000;
  Blocks blocks;
  for (std::size_t made = 0; made < bytes; made += kBlock_bytes) {
    blocks.push_back(std::make_unique<char[]>(kBlock_bytes));
    std::memset(blocks.back().get(), 1, kBlock_bytes);
  }
  return blocks;
}

// Worlds are created by one thread and freed by another.
TEST(ReturnFreedMemory, GivesBackWhatThreadsHaveFreed) {
  if (kHasOwnHeap) GTEST_SKIP() << "the sanitizer has a heap of its own";
  KeepFreedMemory();
  constexpr std::size_t kEach_bytes = 32 << 20;
  const std::size_t before = ResidentBytes();
  std::vector<Blocks> all(4);
  for (Blocks& blocks : all) {
    std::thread([&blocks] { blocks = MakeBlocks(kEach_bytes); }).join();
  }
  const std::size_t full = ResidentBytes();
  ASSERT_GT(full - before, 3 * kEach_bytes);
  std::thread([&all] { all.clear(); }).join();
  ReturnFreedMemory();
  const std::size_t after = ResidentBytes();
  EXPECT_LT(static_cast<double>(after) - static_cast<double>(before),
            0.2 * static_cast<double>(full - before));
}

}  // namespace
}  // namespace cwm::server
