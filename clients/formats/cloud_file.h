// A point cloud as in a file: named fields of any type, with their bytes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "clients/formats/scalar.h"

namespace cwm::formats {

struct CloudField {
  std::string name;  // "x", "normal_x", "rgb", "label", ...
  Scalar type = Scalar::kF32;
  std::size_t count = 1;   // adjacent numbers of this type
  std::size_t offset = 0;  // bytes from the start of a point

  std::size_t size() const { return count * SizeOf(type); }
  friend bool operator==(const CloudField&, const CloudField&) = default;
};

// Points of `point_step` bytes each, one after the other, with little-endian, unaligned numbers.
// Padding of the file is removed, so that fields are dense and in the file's order. Unmeasured
// points are kept as in the file (mostly NaN).
struct CloudFile {
  std::vector<CloudField> fields = {};
  std::size_t point_step = 0;
  std::int64_t width = 0;  // in an organised cloud (height > 1) points are a row-major image
  std::int64_t height = 1;
  std::array<double, 7> viewpoint = {0, 0, 0, 1, 0, 0, 0};  // tx ty tz qw qx qy qz, as in PCD
  std::string bytes = {};

  std::int64_t size() const { return width * height; }
  // The field of that name, or nullptr.
  const CloudField* Find(std::string_view name) const;
};

// Gives the fields dense offsets in their order; returns the size of a point.
std::size_t AssignOffsets(std::vector<CloudField>& fields);

// The same points with only the named fields, in that order. Every name must be a field.
CloudFile SelectFields(const CloudFile& cloud, const std::vector<std::string>& names);

// The same points with a four-byte unsigned field `label`. An existing `label` is replaced in its
// place, otherwise the new field comes last. `labels` must have one value per point.
CloudFile WithLabels(const CloudFile& cloud, const std::vector<std::uint32_t>& labels);

}  // namespace cwm::formats
