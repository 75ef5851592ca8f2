#include "clients/formats/lzf.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace cwm::formats {
namespace {

constexpr std::size_t kMaxLiterals = 32;
constexpr std::size_t kMaxDistance = 1 << 13;
constexpr std::size_t kMinMatch = 3;
constexpr std::size_t kMaxMatch = 264;
constexpr int kHashBits = 14;  // a table of 64 KiB, which stays in the second-level cache

std::uint32_t Byte(std::string_view bytes, std::size_t i) {
  return static_cast<unsigned char>(bytes[i]);
}

// Multiplicative hash of three bytes (Knuth's golden ratio).
std::size_t HashOf(std::string_view bytes, std::size_t i) {
  const std::uint32_t word = Byte(bytes, i) << 16 | Byte(bytes, i + 1) << 8 | Byte(bytes, i + 2);
  return (word * 2654435761u) >> (32 - kHashBits);
}

std::size_t MatchLength(std::string_view bytes, std::size_t from, std::size_t at) {
  const std::size_t limit = std::min(kMaxMatch, bytes.size() - at);
  std::size_t length = 0;
  while (length < limit && bytes[from + length] == bytes[at + length]) ++length;
  return length;
}

void AppendLiterals(std::string_view literals, std::string& output) {
  while (!literals.empty()) {
    const std::size_t count = std::min(kMaxLiterals, literals.size());
    output.push_back(static_cast<char>(count - 1));
    output.append(literals.substr(0, count));
    literals.remove_prefix(count);
  }
}

void AppendCopy(std::size_t distance, std::size_t length, std::string& output) {
  const std::size_t offset = distance - 1;
  const std::size_t code = length - 2;
  output.push_back(static_cast<char>(std::min<std::size_t>(code, 7) << 5 | offset >> 8));
  if (code >= 7) output.push_back(static_cast<char>(code - 7));
  output.push_back(static_cast<char>(offset & 0xff));
}

}  // namespace

std::string LzfCompress(std::string_view input) {
  std::string output;
  output.reserve(input.size() / 2);
  std::array<std::uint32_t, 1 << kHashBits> last_seen{};  // position + 1; 0: never
  std::size_t literals_begin = 0;
  std::size_t at = 0;
  while (at + kMinMatch <= input.size()) {
    std::uint32_t& seen = last_seen[HashOf(input, at)];
    const std::size_t from = seen == 0 ? at : seen - 1;
    seen = static_cast<std::uint32_t>(at + 1);
    const std::size_t distance = at - from;
    const bool reachable = distance > 0 && distance <= kMaxDistance;
    const std::size_t length = reachable ? MatchLength(input, from, at) : 0;
    if (length < kMinMatch) {
      ++at;
      continue;
    }
    AppendLiterals(input.substr(literals_begin, at - literals_begin), output);
    AppendCopy(distance, length, output);
    at += length;
    literals_begin = at;
  }
  AppendLiterals(input.substr(literals_begin), output);
  return output;
}

std::optional<std::string> LzfDecompress(std::string_view input, std::size_t output_size) {
  if (output_size / kLzfMaxExpansion > input.size()) return std::nullopt;
  std::string output;
  output.reserve(output_size);
  for (std::size_t i = 0; i < input.size();) {
    const std::size_t control = Byte(input, i++);
    if (control < kMaxLiterals) {
      const std::size_t count = control + 1;
      if (count > input.size() - i || count > output_size - output.size()) return std::nullopt;
      output.append(input.substr(i, count));
      i += count;
      continue;
    }
    std::size_t length = (control >> 5) + 2;
    const std::size_t operand_bytes = length == 9 ? 2 : 1;
    if (operand_bytes > input.size() - i) return std::nullopt;
    if (length == 9) length += Byte(input, i++);
    const std::size_t distance = ((control & 0x1f) << 8 | Byte(input, i++)) + 1;
    if (distance > output.size() || length > output_size - output.size()) return std::nullopt;
    // Byte by byte, since a copy may overlap its own output.
    for (std::size_t k = 0; k < length; ++k) output.push_back(output[output.size() - distance]);
  }
  if (output.size() != output_size) return std::nullopt;
  return output;
}

}  // namespace cwm::formats
