// Where a server listens, and a client looks for it, when nobody says otherwise.
#pragma once

#include <string>

namespace cwm {

// $CWM_ADDR, else "unix:${XDG_RUNTIME_DIR:-/tmp}/cwm-$UID.sock". Empty variables count as unset.
std::string DefaultAddress();

}  // namespace cwm
