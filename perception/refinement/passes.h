// All passes, in the order in which they run, and their names.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "perception/refinement/refine.h"

namespace cwm::perception {

// A new pass gets a file pair in one of the rooms and a line here.
const Passes& RefinementPasses();

// Names that InterpretOptions::disabled_passes may have: of attachments, refinement and completion.
std::vector<std::string> PassNames();

inline constexpr std::string_view kCompleteBelow = "complete.below";
inline constexpr std::string_view kCutRims = "complete.rims";

}  // namespace cwm::perception
