// Recognises the beginning of an HTTP/2 connection (RFC 9113, section 3.4).
#pragma once

#include <cstddef>
#include <string_view>

namespace cwm::server {

// The client's preface, and the size of it with the header of the SETTINGS frame that must follow.
inline constexpr std::string_view kHttp2Preface = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";
inline constexpr std::size_t kHttp2BeginningBytes = kHttp2Preface.size() + 9;

enum class Http2Beginning { kIncomplete, kWrong, kComplete };

// `said`: the first bytes of a connection, at most kHttp2BeginningBytes.
inline Http2Beginning LookAtHttp2Beginning(std::string_view said) {
  if (!said.starts_with(kHttp2Preface.substr(0, said.size()))) return Http2Beginning::kWrong;
  if (said.size() < kHttp2BeginningBytes) return Http2Beginning::kIncomplete;
  // Length in three bytes, type, flags, and the stream in four bytes, whose first bit is reserved.
  const std::string_view frame = said.substr(kHttp2Preface.size());
  constexpr char kSettings = 4;
  const bool is_of_connection =
      (frame[5] & 0x7F) == 0 && frame[6] == 0 && frame[7] == 0 && frame[8] == 0;
  return frame[3] == kSettings && is_of_connection ? Http2Beginning::kComplete
                                                   : Http2Beginning::kWrong;
}

}  // namespace cwm::server
