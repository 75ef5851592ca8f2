// A fuzz target is a function of untrusted bytes. libFuzzer calls it in the preset `fuzz`;
// replay_main.cc calls it with the files of the corpus in other builds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace cwm::fuzz {

// Defined by each target. Must return for any bytes.
void TestBytes(std::string_view bytes);

// Ends the process if the contract of a reader is broken.
inline void Check(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "fuzz: %s\n", what);
  std::abort();
}

}  // namespace cwm::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
