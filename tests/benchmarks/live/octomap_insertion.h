// OctoMap, behind an interface of plain values: its headers are those of another style.
#pragma once

#include <memory>
#include <span>

#include "collision/geometry/pose.h"

namespace cwm::benchmarks {

class OctoMapInsertion {
 public:
  explicit OctoMapInsertion(double voxel_m);
  ~OctoMapInsertion();

  // Inserts points of the world seen from `origin_W`, and returns the milliseconds of processor
  // time that it took.
  double Insert_ms(std::span<const Eigen::Vector3f> points_W, const Vector3& origin_W);

 private:
  struct Map;
  std::unique_ptr<Map> map_;
};

}  // namespace cwm::benchmarks
