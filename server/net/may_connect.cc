#include "server/net/may_connect.h"

namespace cwm::server {

bool MayConnect(std::optional<std::uint32_t> peer_uid, std::uint32_t server_uid,
                bool allow_any_local_user) {
  constexpr std::uint32_t kRoot = 0;
  if (allow_any_local_user) return true;
  return peer_uid == server_uid || peer_uid == kRoot;
}

}  // namespace cwm::server
