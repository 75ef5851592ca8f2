#include "server/export/notes.h"

#include <algorithm>
#include <cstddef>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace cwm::server {

void Notes::Add(const std::string& note, const std::string& object) {
  std::vector<std::string>& objects = objects_of_note_[note];
  if (objects.empty() || objects.back() != object) objects.push_back(object);
}

void Notes::AppendTo(std::vector<std::string>& warnings) const {
  constexpr std::size_t kShown = 5;
  for (const auto& [note, objects] : objects_of_note_) {
    const std::size_t shown = std::min(objects.size(), kShown);
    std::string line =
        absl::StrJoin(objects.begin(), objects.begin() + static_cast<std::ptrdiff_t>(shown), ", ");
    if (objects.size() > shown) absl::StrAppend(&line, " and ", objects.size() - shown, " more");
    warnings.push_back(absl::StrCat(line, ": ", note));
  }
}

}  // namespace cwm::server
