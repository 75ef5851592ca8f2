#include "server/export/notes.h"

#include <algorithm>
#include <cstddef>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace cwm::server {

void Notes::Add(const std::string& note, const std::string& thing) {
  std::vector<std::string>& things = things_[note];
  if (things.empty() || things.back() != thing) things.push_back(thing);
}

void Notes::AppendTo(std::vector<std::string>& warnings) const {
  constexpr std::size_t kShown = 5;
  for (const auto& [note, things] : things_) {
    const std::size_t shown = std::min(things.size(), kShown);
    std::string line =
        absl::StrJoin(things.begin(), things.begin() + static_cast<std::ptrdiff_t>(shown), ", ");
    if (things.size() > shown) absl::StrAppend(&line, " and ", things.size() - shown, " more");
    warnings.push_back(absl::StrCat(line, ": ", note));
  }
}

}  // namespace cwm::server
