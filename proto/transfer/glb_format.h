// The numbers of binary glTF 2.0 (GLB) that its writers need.
#pragma once

#include <cstddef>
#include <cstdint>

namespace cwm {

// cited: glTF 2.0, section 4.4 (the container).
inline constexpr std::uint32_t kGlbMagic = 0x46546C67;  // "glTF"
inline constexpr std::uint32_t kGlbVersion = 2;
inline constexpr std::uint32_t kGlbJsonChunk = 0x4E4F534A;
inline constexpr std::uint32_t kGlbBinaryChunk = 0x004E4942;
inline constexpr std::size_t kGlbHeaderBytes = 12;
inline constexpr std::size_t kGlbChunkHeaderBytes = 8;

// cited: glTF 2.0, sections 5.1 and 5.11 (component types, targets of buffer views).
inline constexpr int kGltfUnsignedInt = 5125;
inline constexpr int kGltfFloat = 5126;
inline constexpr int kGltfArrayBuffer = 34962;
inline constexpr int kGltfElementArrayBuffer = 34963;

}  // namespace cwm
