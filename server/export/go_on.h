// Whether work that takes long is still wanted.
#pragma once

#include <functional>

#include "absl/status/status.h"

namespace cwm::server {

// Asked between objects, rules and rows: anything but OK ends the work, which returns it.
using GoOn = std::function<absl::Status()>;

}  // namespace cwm::server
