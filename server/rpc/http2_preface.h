// Recognises the beginning of an HTTP/2 connection (RFC 9113, section 3.4).
#pragma once

#include <cstddef>
#include <string_view>

namespace cwm::server {

// The client's preface, and the size of it with the header of the SETTINGS frame that must follow.
inline constexpr std::string_view kHttp2Preface = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";
inline constexpr std::size_t kHttp2PrefaceAndHeaderBytes = kHttp2Preface.size() + 9;

enum class Http2PrefaceState { kIncomplete, kWrong, kComplete };

// `received`: the first bytes of a connection, at most kHttp2PrefaceAndHeaderBytes.
inline Http2PrefaceState CheckHttp2Preface(std::string_view received) {
  if (!received.starts_with(kHttp2Preface.substr(0, received.size())))
    return Http2PrefaceState::kWrong;
  if (received.size() < kHttp2PrefaceAndHeaderBytes) return Http2PrefaceState::kIncomplete;
  // Length in three bytes, type, flags, and the stream in four bytes, whose first bit is reserved.
  const std::string_view frame = received.substr(kHttp2Preface.size());
  constexpr char kSettings = 4;
  const bool is_of_connection =
      (frame[5] & 0x7F) == 0 && frame[6] == 0 && frame[7] == 0 && frame[8] == 0;
  return frame[3] == kSettings && is_of_connection ? Http2PrefaceState::kComplete
                                                   : Http2PrefaceState::kWrong;
}

}  // namespace cwm::server
