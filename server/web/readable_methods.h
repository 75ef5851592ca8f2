// What a page may ask: the methods that change nothing.
#pragma once

#include <span>
#include <string_view>

namespace cwm::server {

// "cwm.v1.WorldService/WatchWorld"; ordered.
std::span<const std::string_view> ReadableMethods();
bool IsReadable(std::string_view method);

// Takes what time its reader takes, or has no end of its own.
bool IsStream(std::string_view method);
// Counts as a watcher while it lasts.
bool IsWatch(std::string_view method);

}  // namespace cwm::server
