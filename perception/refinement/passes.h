// All passes, in the order in which they run, and their names.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "perception/refinement/refine.h"

namespace cwm::perception {

// All passes. To add one, add a pair of files in one of the subfolders and a line here.
const Passes& RefinementPasses();

// The names that InterpretOptions::disabled_passes may contain: attachments, passes, completion.
std::vector<std::string> PassNames();

inline constexpr std::string_view kCompleteBelow = "complete.below";
inline constexpr std::string_view kCutRims = "complete.rims";

}  // namespace cwm::perception
