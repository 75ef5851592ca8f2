// The methods that a page may call: those that change nothing.
#pragma once

#include <span>
#include <string_view>

namespace cwm::server {

// E.g. "cwm.v1.WorldService/WatchWorld"; sorted.
std::span<const std::string_view> ReadableMethods();
bool IsReadable(std::string_view method);

// True if the call takes as long as its reader needs, or does not end by itself.
bool IsStream(std::string_view method);
// True if the call counts as a watch.
bool IsWatch(std::string_view method);

}  // namespace cwm::server
