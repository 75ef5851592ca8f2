// A point cloud as a file holds it: named fields of any type, bytes as they are.
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
  std::size_t count = 1;   // numbers of this type, side by side
  std::size_t offset = 0;  // bytes from the start of a point

  std::size_t size() const { return count * SizeOf(type); }
  friend bool operator==(const CloudField&, const CloudField&) = default;
};

// Points lie one after another, `point_step` bytes each, numbers little-endian and unaligned;
// padding of the file is dropped, so that fields are dense and in the file's order. Points that
// were not measured are there as the file has them (mostly NaN).
struct CloudFile {
  std::vector<CloudField> fields = {};
  std::size_t point_step = 0;
  std::int64_t width = 0;  // of an organised cloud (height > 1) the points are a row-major image
  std::int64_t height = 1;
  std::array<double, 7> viewpoint = {0, 0, 0, 1, 0, 0, 0};  // tx ty tz qw qx qy qz, as PCD has it
  std::string bytes = {};

  std::int64_t size() const { return width * height; }
  // The field of that name, or null.
  const CloudField* Find(std::string_view name) const;
};

// Gives the fields dense offsets in their order; the sum is the size of a point.
std::size_t LayOut(std::vector<CloudField>& fields);

// The same points with only the named fields, in that order. Every name must be a field.
CloudFile Select(const CloudFile& cloud, const std::vector<std::string>& names);

// The same points in the same order with a four-byte unsigned field `label`, one value a point. A
// `label` that was there is replaced in its place, else the new one comes last. `labels` must hold
// one value per point.
CloudFile WithLabels(const CloudFile& cloud, const std::vector<std::uint32_t>& labels);

}  // namespace cwm::formats
