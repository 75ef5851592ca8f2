#include "clients/cpp/point_labels.h"

#include <algorithm>

namespace cwm::client {
namespace {

constexpr int kLastSupportLabel = 9;
constexpr int kLabelsPerObject = 10;
constexpr int kFirstObject = 2;  // in multiples of kLabelsPerObject

}  // namespace

std::uint32_t SupportLabel(int index) {
  return static_cast<std::uint32_t>(std::min(index + 1, kLastSupportLabel));
}

std::uint32_t ObjectLabel(int index) {
  return static_cast<std::uint32_t>(kLabelsPerObject * (index + kFirstObject));
}

PointOwner PointOwnerOf(std::uint32_t label) {
  const int tens = static_cast<int>(label / kLabelsPerObject);
  const int ones = static_cast<int>(label % kLabelsPerObject);
  if (tens >= kFirstObject) {
    return {.kind = PointOwner::Kind::kObject, .index = tens - kFirstObject, .part = ones};
  }
  if (tens == 0 && ones > 0) return {.kind = PointOwner::Kind::kSupport, .index = ones - 1};
  return {};
}

}  // namespace cwm::client
