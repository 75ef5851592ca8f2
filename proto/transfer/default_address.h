// The address at which a server listens, and a client calls, if none is given.
#pragma once

#include <string>

#include "absl/status/status.h"

namespace cwm {

// The rule of DefaultAddress, for the help texts of programs.
inline constexpr char kDefaultAddressRule[] =
    "$CWM_ADDR, else unix:$XDG_RUNTIME_DIR/cwm-$UID.sock, else unix:/tmp/cwm-$UID/cwm.sock";

// Returns the first address of kDefaultAddressRule whose variable is set; empty variables count as
// unset.
std::string DefaultAddress();

// Makes sure that only this user and root can have put a socket at DefaultAddress(). A program that
// listens or dials there without an explicit address calls it first. XDG_RUNTIME_DIR must be a
// directory of this user or root that group and others cannot write to. /tmp/cwm-$UID must be a
// directory of this user with mode 0700; it is created if it is missing, by clients too, because
// another user could create it between the check and the connection. $CWM_ADDR is the user's own
// choice and is not checked.
//
// PermissionDenied names the path, what is wrong with it and how to choose another address;
// Unavailable if XDG_RUNTIME_DIR does not exist. Thread-safe as long as the environment does not
// change.
absl::Status PrepareDefaultAddress();

}  // namespace cwm
