// The life of gRPC in our processes.
#pragma once

#include <grpc/grpc.h>

#include <mutex>

namespace cwm {

// Keeps gRPC initialized for the life of the process. Its cleanup after its last object waits for
// up to 10 s (1.51) for a poll left behind by a message that the socket did not take at once.
inline void KeepGrpcInitialized() {
  static std::once_flag once;
  std::call_once(once, grpc_init);
}

}  // namespace cwm
