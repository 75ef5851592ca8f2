// How much freed memory the process keeps, and when the system gets it back.
#pragma once

namespace cwm::server {

// Keeps what messages and answers use, so that the next ones need not fault it in again. Once, before
// the process has threads.
void KeepFreedMemory();

// Gives freed memory back to the system: after worlds are gone. Takes milliseconds. Thread safe.
void ReturnFreedMemory();

}  // namespace cwm::server
