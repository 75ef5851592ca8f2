// Decides which users of this machine may connect to a loopback port.
#pragma once

#include <cstdint>
#include <optional>

namespace cwm::server {

// True for the user that runs the server (`server_uid`), for root, and for everybody if
// `allow_any_local_user` is set. False for a peer whose user is unknown (see PeerUid), unless
// everybody may connect. Only for TCP: the file mode of a Unix socket controls access itself.
bool MayConnect(std::optional<std::uint32_t> peer_uid, std::uint32_t server_uid,
                bool allow_any_local_user);

}  // namespace cwm::server
