#include "perception/object_notes.h"

#include <algorithm>
#include <iterator>
#include <set>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace cwm::perception {
namespace {

// chosen: as many numbers as a line of a terminal holds.
constexpr std::size_t kMaxNumbers = 8;

// "object 3: ", "objects 1, 4 and 9: ", "objects 1, 2, 3, 4, 5, 6, 7, 8 and 12 more: ".
std::string Subject(const std::set<std::size_t>& numbers) {
  if (numbers.empty()) return "";
  if (numbers.size() == 1) return absl::StrCat("object ", *numbers.begin(), ": ");
  const std::size_t listed = std::min(kMaxNumbers, numbers.size() - 1);
  const auto end = std::next(numbers.begin(), static_cast<std::ptrdiff_t>(listed));
  const std::size_t others = numbers.size() - listed;
  return absl::StrCat("objects ", absl::StrJoin(numbers.begin(), end, ", "), " and ",
                      others == 1 ? absl::StrCat(*end) : absl::StrCat(others, " more"), ": ");
}

}  // namespace

std::vector<std::string> NotesByKind(const std::vector<ObjectNote>& notes) {
  std::vector<std::pair<std::string, std::set<std::size_t>>> kinds;
  for (const auto& [number, note] : notes) {
    auto kind = std::ranges::find(kinds, note, [](const auto& known) { return known.first; });
    if (kind == kinds.end()) kind = kinds.insert(kinds.end(), {note, {}});
    if (number > 0) kind->second.insert(number);
  }
  std::vector<std::string> warnings;
  for (const auto& [note, numbers] : kinds) warnings.push_back(Subject(numbers) + note);
  return warnings;
}

}  // namespace cwm::perception
