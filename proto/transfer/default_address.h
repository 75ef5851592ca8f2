// Where a server listens, and a client looks for it, when nobody says otherwise.
#pragma once

#include <string>

#include "absl/status/status.h"

namespace cwm {

// The rule of DefaultAddress, for the help of programs.
inline constexpr char kDefaultAddressRule[] =
    "$CWM_ADDR, else unix:$XDG_RUNTIME_DIR/cwm-$UID.sock, else unix:/tmp/cwm-$UID/cwm.sock";

// The first of kDefaultAddressRule whose variable is set; empty variables count as unset.
std::string DefaultAddress();

// Makes sure that nobody but this user and root can have put a socket at DefaultAddress(); whoever
// listens or dials there without having been told to calls it first. XDG_RUNTIME_DIR must be a
// directory of this user or root that group and others cannot write to; /tmp/cwm-$UID one of this
// user's own with mode 0700, and is made when it is missing, by clients too: another user could
// make it between the check and the connection. $CWM_ADDR is the user's own choice, and is not
// checked.
//
// PermissionDenied names the path, what is wrong with it and how to choose another; Unavailable
// when XDG_RUNTIME_DIR does not exist. Thread-safe as far as the environment is not changed.
absl::Status PrepareDefaultAddress();

}  // namespace cwm
