#include "clients/cli/scan_units.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "absl/strings/str_cat.h"
#include "clients/cli/quantity.h"

namespace cwm::cli {
namespace {

// A table half a metre before a camera is 500 away in millimetres; tilting lasers, which see farthest
// of the sensors that the server knows, end at 30 m (Hokuyo UTM-30LX).
constexpr double kFarthest_m = 100;

}  // namespace

std::optional<std::string> DoubtsAboutUnits(const formats::CloudFile& cloud) {
  const formats::CloudField* const fields[] = {cloud.Find("x"), cloud.Find("y"), cloud.Find("z")};
  std::vector<double> ranges;
  for (std::int64_t i = 0; i < cloud.size(); ++i) {
    const char* point = cloud.bytes.data() + static_cast<std::size_t>(i) * cloud.point_step;
    double squared = 0;
    for (const formats::CloudField* field : fields) {
      const double coordinate = formats::ToDouble(point + field->offset, field->type);
      squared += coordinate * coordinate;
    }
    if (std::isfinite(squared)) ranges.push_back(std::sqrt(squared));
  }
  if (ranges.empty()) return std::nullopt;
  const auto middle = ranges.begin() + static_cast<std::ptrdiff_t>(ranges.size() / 2);
  std::nth_element(ranges.begin(), middle, ranges.end());
  if (*middle <= kFarthest_m) return std::nullopt;
  return absl::StrCat("half of the points are farther away than ", Fixed(*middle, 0),
                      " m: coordinates are metres, are these millimetres?");
}

}  // namespace cwm::cli
