#include "cwm/internal/columns.h"

namespace cwm::CWM_API::internal {

AnsweredObject FromMessage(const v1::ObjectRef& object) {
  return {.name = object.name(),
          .uid = object.uid(),
          .part_links = {object.part_links().begin(), object.part_links().end()}};
}

void MergedObjects::Renumber(std::size_t reply, Eigen::Index begin, Eigen::Index count,
                             Eigen::VectorXi& column) const {
  const std::vector<int>& places = places_[reply];
  for (int& index : column.segment(begin, count)) {
    if (index < 0) continue;
    if (static_cast<std::size_t>(index) >= places.size()) {
      throw Error(ErrorCode::kDataLoss,
                  absl::StrCat("an answer names object ", index, " of ", places.size()));
    }
    index = places[static_cast<std::size_t>(index)];
  }
}

Eigen::Index LastBegin(const std::string& row_begin) {
  std::uint32_t last = 0;
  if (row_begin.size() < sizeof(last)) return 0;
  std::memcpy(&last, row_begin.data() + row_begin.size() - sizeof(last), sizeof(last));
  return static_cast<Eigen::Index>(last);
}

}  // namespace cwm::CWM_API::internal
