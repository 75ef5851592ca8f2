// The default memory limit of the server.
#pragma once

#include <cstdint>

namespace cwm::server {

// Bytes available to this process: the smallest of the machine's memory, the limits of its control
// groups (version 1 and 2, all levels) and its address space limit (RLIMIT_AS).
std::int64_t AvailableMemory();

// Three quarters of the available memory at the first call: the rest is for the transport, the
// allocator's waste and other programs.
std::int64_t DefaultMemoryLimit();

}  // namespace cwm::server
