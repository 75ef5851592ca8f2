// SHA-256, which names blobs and checks clouds.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace cwm {

// The digest of bytes that are added piece by piece. Hex() ends it.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;

  void Add(const void* data, std::size_t size);
  // Returns the digest in lower-case hex.
  std::string Hex();

 private:
  void* const context_;  // a context of OpenSSL, whose header is not included here
};

// The digest of all bytes in lower-case hex.
std::string Sha256Hex(std::string_view bytes);

}  // namespace cwm
