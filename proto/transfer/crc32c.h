// CRC-32C (Castagnoli), the checksum of upload chunks: reflected polynomial 0x82F63B78, as in RFC
// 3720, appendix B.4.
#pragma once

#include <cstdint>
#include <string_view>

namespace cwm {

std::uint32_t Crc32c(std::string_view bytes);

}  // namespace cwm
