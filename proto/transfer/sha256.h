// SHA-256, by which blobs are named and clouds are checked.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace cwm {

// Of bytes that come piece by piece. Hex() ends it.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;

  void Add(const void* data, std::size_t size);
  // In lower case.
  std::string Hex();

 private:
  void* const context_;  // OpenSSL's, whose header stays out of this one
};

// Of all bytes at once, in lower-case hex.
std::string Sha256Hex(std::string_view bytes);

}  // namespace cwm
