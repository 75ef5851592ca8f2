// CRC-32C (Castagnoli), as RFC 3720 appendix B.4 defines it.
#pragma once

#include <cstdint>
#include <string_view>

namespace cwm::client {

std::uint32_t Crc32c(std::string_view bytes);

}  // namespace cwm::client
