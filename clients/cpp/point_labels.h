// The meaning of a scan's labels: 0 is nobody; 1 to 9 are the supports (the tenth and later share
// 9); object i (from 1) has 10 (i + 1) + part, where part 0 is the object itself and 1 to 9 are its
// parts, shapes before handles.
#pragma once

#include <cstdint>

namespace cwm::client {

// Indices count from 0, in the order of the reply.
std::uint32_t SupportLabel(int index);
std::uint32_t ObjectLabel(int index);  // of the object itself

struct PointOwner {
  enum class Kind { kNone, kSupport, kObject };
  Kind kind = Kind::kNone;
  int index = 0;  // among the reply's supports, or its objects
  int part = 0;   // of an object, from 1; 0: the object itself

  friend bool operator==(const PointOwner&, const PointOwner&) = default;
};

// kNone for a label that no scan uses.
PointOwner PointOwnerOf(std::uint32_t label);

}  // namespace cwm::client
