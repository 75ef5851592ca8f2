// SHA-256, by which blobs are named.
#pragma once

#include <string>
#include <string_view>

namespace cwm::client {

// In lower-case hex.
std::string Sha256Hex(std::string_view bytes);

}  // namespace cwm::client
