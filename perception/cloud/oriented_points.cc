#include "perception/cloud/oriented_points.h"

namespace cwm::perception {

OrientedPoints Subset(const OrientedPoints& all, std::span<const std::uint32_t> members) {
  OrientedPoints some;
  some.viewpoint = all.viewpoint;
  some.spread = all.spread;
  some.points_per_sample = all.points_per_sample;
  some.warp_m = all.warp_m;
  some.points.reserve(members.size());
  some.normals.reserve(members.size());
  some.sigma_m.reserve(members.size());
  some.normal_sigma_rad.reserve(members.size());
  some.cloud_index.reserve(members.size());
  for (std::uint32_t i : members) {
    some.points.push_back(all.points[i]);
    some.normals.push_back(all.normals[i]);
    some.sigma_m.push_back(all.sigma_m[i]);
    some.normal_sigma_rad.push_back(all.normal_sigma_rad[i]);
    some.cloud_index.push_back(all.cloud_index[i]);
  }
  return some;
}

}  // namespace cwm::perception
