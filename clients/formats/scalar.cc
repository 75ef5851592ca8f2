#include "clients/formats/scalar.h"

#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>

namespace cwm::formats {
namespace {

static_assert(std::endian::native == std::endian::little, "bytes are copied as they lie in memory");

// Calls `f` with a value of the C++ type of `type`.
template <class F>
auto Visit(Scalar type, F&& f) {
  switch (type) {
    case Scalar::kI8:
      return f(std::int8_t{});
    case Scalar::kU8:
      return f(std::uint8_t{});
    case Scalar::kI16:
      return f(std::int16_t{});
    case Scalar::kU16:
      return f(std::uint16_t{});
    case Scalar::kI32:
      return f(std::int32_t{});
    case Scalar::kU32:
      return f(std::uint32_t{});
    case Scalar::kI64:
      return f(std::int64_t{});
    case Scalar::kU64:
      return f(std::uint64_t{});
    case Scalar::kF32:
      return f(float{});
    case Scalar::kF64:
      break;
  }
  return f(double{});
}

// Text of a number that is not finite as Microsoft's C library wrote it until 2015: "1.#QNAN",
// "-1.#IND", "1.#INF00".
std::optional<double> MicrosoftNonFinite(std::string_view text) {
  const bool is_negative = text.starts_with('-');
  if (is_negative) text.remove_prefix(1);
  if (!text.starts_with("1.#")) return std::nullopt;
  text.remove_prefix(3);
  while (text.ends_with('0')) text.remove_suffix(1);
  if (text == "QNAN" || text == "SNAN" || text == "IND") {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const double infinity = std::numeric_limits<double>::infinity();
  if (text == "INF") return is_negative ? -infinity : infinity;
  return std::nullopt;
}

}  // namespace

std::size_t SizeOf(Scalar type) {
  return Visit(type, [](auto zero) { return sizeof(zero); });
}

std::string_view NameOf(Scalar type) {
  constexpr std::string_view kNames[] = {"int8",   "uint8", "int16",  "uint16",  "int32",
                                         "uint32", "int64", "uint64", "float32", "float64"};
  return kNames[static_cast<int>(type)];
}

bool ParseScalar(std::string_view text, Scalar type, char* bytes) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  return Visit(type, [&](auto value) {
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc() || stop != end) {
      const auto non_finite = MicrosoftNonFinite(text);
      if (!std::is_floating_point_v<decltype(value)> || !non_finite) return false;
      value = static_cast<decltype(value)>(*non_finite);
    }
    std::memcpy(bytes, &value, sizeof(value));
    return true;
  });
}

double ToDouble(const char* bytes, Scalar type) {
  return Visit(type, [&](auto value) {
    std::memcpy(&value, bytes, sizeof(value));
    return static_cast<double>(value);
  });
}

std::string FormatNumber(double value) {
  char text[32];  // the longest shortest form has 24 characters, e.g. -2.2250738585072014e-308
  const auto [end, error] = std::to_chars(text, text + sizeof(text), value);
  return error == std::errc() ? std::string(text, end) : std::string();
}

}  // namespace cwm::formats
