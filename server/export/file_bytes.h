// Appends numbers in binary form.
#pragma once

#include <bit>
#include <cstring>
#include <string>
#include <type_traits>

namespace cwm::server {

static_assert(std::endian::native == std::endian::little);

// Little-endian.
template <class Number>
void AppendBytes(Number number, std::string& out) {
  static_assert(std::is_arithmetic_v<Number>);
  char bytes[sizeof(Number)];
  std::memcpy(bytes, &number, sizeof(Number));
  out.append(bytes, sizeof(Number));
}

}  // namespace cwm::server
