// Decides which regions one support carries (paper, section IV, figure 5).
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <set>
#include <utility>
#include <vector>

#include "perception/segmentation/sight_map.h"
#include "perception/segmentation/support_planes.h"
#include "perception/segmentation/support_polygon.h"
#include "perception/segmentation/surface_graph.h"

namespace cwm::perception {

// A support's surface and what was seen around it. The constructor's arguments must outlive it.
class SupportSurface {
 public:
  using NodeList = std::vector<std::uint32_t>;

  SupportSurface(const SurfaceGraph& graph, const CoarseCloud& coarse, const SupportPlane& support,
                 const Placed<Plate>& plate, const SightMap& sight);

  // True if the support carries the region, by the rules of FormRegions.
  bool Carries(const NodeList& region) const;

 private:
  using FootprintCell = std::pair<int, int>;

  Vector3 Local(const Eigen::Vector3f& p) const { return X_SL_ * p.cast<double>(); }
  FootprintCell CellOf(const Vector3& local) const;
  Vector2 MiddleOf(const FootprintCell& cell) const;

  NodeList NodesOver(const NodeList& region) const;
  bool HidesItsPlace(const NodeList& region) const;
  bool IsOverHiddenPart(const NodeList& region) const;
  bool HidesItsSupport(const NodeList& region) const;
  Visibility VisibilityAbove(const Vector2& foot, float jump_m) const;
  bool IsHiddenToSupport(const Vector2& from, float jump_m) const;
  bool IsBallOnIt(const NodeList& over) const;
  bool StandsOrIsHidden(const NodeList& over) const;
  bool StandsOrIsHidden(std::uint32_t node, double height, double foot_m) const;
  double Footprint_m2(const NodeList& over) const;
  bool IsHiddenAt(const FootprintCell& cell) const;

  const SurfaceGraph& graph_;
  const Placed<Plate>& plate_;
  const SightMap& sight_;
  Pose X_SL_;
  double cell_m_;
  std::set<FootprintCell> occupied_;
  Eigen::AlignedBox2d extent_;  // of the occupied cells
  int reach_ = 1;
};

}  // namespace cwm::perception
