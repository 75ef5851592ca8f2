#include "proto/transfer/glb_writer.h"

#include <bit>
#include <cstring>

#include "proto/transfer/glb_format.h"

namespace cwm {
namespace {

static_assert(std::endian::native == std::endian::little);

void AppendWord(std::size_t word, std::string& file) {
  const auto value = static_cast<std::uint32_t>(word);
  char bytes[sizeof(value)];
  std::memcpy(bytes, &value, sizeof(value));
  file.append(bytes, sizeof(value));
}

// Chunks begin and end at multiples of four bytes.
std::size_t Padded(std::size_t bytes) { return (bytes + 3) / 4 * 4; }

void AppendChunk(std::uint32_t type, char padding, std::string_view content, std::string& file) {
  const std::size_t size = Padded(content.size());
  AppendWord(size, file);
  AppendWord(type, file);
  file += content;
  file.append(size - content.size(), padding);
}

}  // namespace

std::string JoinGlb(std::string_view json, std::string_view binary) {
  const std::size_t size = kGlbHeaderBytes + kGlbChunkHeaderBytes + Padded(json.size()) +
                           (binary.empty() ? 0 : kGlbChunkHeaderBytes + Padded(binary.size()));
  std::string file;
  file.reserve(size);
  AppendWord(kGlbMagic, file);
  AppendWord(kGlbVersion, file);
  AppendWord(size, file);
  AppendChunk(kGlbJsonChunk, ' ', json, file);
  if (!binary.empty()) AppendChunk(kGlbBinaryChunk, '\0', binary, file);
  return file;
}

}  // namespace cwm
