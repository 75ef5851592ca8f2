// Whom a point belongs to, as the labels of a scan tell it: 0 nobody; 1 to 9 the supports (the tenth
// and later share 9); object i from 1 on 10 (i + 1) + part, part 0 the object as such, 1 to 9 its
// parts, shapes before handles.
#pragma once

#include <cstdint>

namespace cwm::client {

// Indices count from 0, in the order of the reply.
std::uint32_t SupportLabel(int index);
std::uint32_t ObjectLabel(int index);  // of the object as such

struct PointOwner {
  enum class Kind { kNobody, kSupport, kObject };
  Kind kind = Kind::kNobody;
  int index = 0;  // among the reply's supports, or its objects
  int part = 0;   // of an object, from 1 on; 0: the object as such

  friend bool operator==(const PointOwner&, const PointOwner&) = default;
};

// A label that no scan gives is nobody's.
PointOwner OwnerOf(std::uint32_t label);

}  // namespace cwm::client
