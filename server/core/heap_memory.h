// Controls how much freed memory the process keeps, and when the system gets it back.
#pragma once

namespace cwm::server {

// Keeps freed memory of messages and answers, so that the next ones need not fault it in again.
// Call once, before the process has threads.
void KeepFreedMemory();

// Returns freed memory to the system, after worlds were deleted. Takes milliseconds. Thread safe.
void ReturnFreedMemory();

}  // namespace cwm::server
