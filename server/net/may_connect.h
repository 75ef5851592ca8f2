// Which of this machine's users may connect to a port of loopback.
#pragma once

#include <cstdint>
#include <optional>

namespace cwm::server {

// True for the user that the server runs as (`server_uid`) and for root, and for everybody when
// `allow_any_local_user`. A peer whose user is not known (see PeerUid) may not. Only for TCP: the
// mode of a Unix socket's file decides by itself.
bool MayConnect(std::optional<std::uint32_t> peer_uid, std::uint32_t server_uid,
                bool allow_any_local_user);

}  // namespace cwm::server
