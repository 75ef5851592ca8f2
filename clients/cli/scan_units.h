// Whether a cloud is in metres, as far as one can tell.
#pragma once

#include <optional>
#include <string>

#include "clients/formats/cloud_file.h"

namespace cwm::cli {

// Half of the measured points are farther away than any sensor of close range sees: what to say of
// it. `cloud` has the fields x y z, one number each.
std::optional<std::string> DoubtsAboutUnits(const formats::CloudFile& cloud);

}  // namespace cwm::cli
