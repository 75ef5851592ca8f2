// The number types of cloud and mesh files, and their strict text form.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace cwm::formats {

enum class Scalar { kI8, kU8, kI16, kU16, kI32, kU32, kI64, kU64, kF32, kF64 };

std::size_t SizeOf(Scalar type);

// "int8", "uint32", "float64", ...
std::string_view NameOf(Scalar type);

// Writes the number that the whole `text` spells, as little-endian bytes of the type. False if it
// is not a number or out of the type's range. "nan" and "inf" are accepted only for float types.
// Independent of the locale.
[[nodiscard]] bool ParseScalar(std::string_view text, Scalar type, char* bytes);

// The number as a double. 64-bit integers may lose their last bits.
double ToDouble(const char* bytes, Scalar type);

// The shortest text that reads back as the same number.
std::string FormatNumber(double value);

}  // namespace cwm::formats
