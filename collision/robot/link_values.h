// A number for each link of a robot, by name.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace cwm::collision {

// The name that stands for all links that are not named.
inline constexpr std::string_view kOtherLinks = "*";

struct LinkValue {
  std::string link;  // or kOtherLinks
  double value = 0;
};
// Each link at most once.
using LinkValues = std::vector<LinkValue>;

inline double ValueOf(const LinkValues& values, std::string_view link, double otherwise) {
  for (const LinkValue& each : values) {
    if (each.link == link) return each.value;
    if (each.link == kOtherLinks) otherwise = each.value;
  }
  return otherwise;
}

}  // namespace cwm::collision
