// Finds handles of vessels: clusters that stand out from a wall of revolution and are slim all
// along. A wall may be known where there is no solid that a handle could grow from (handles.h).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "perception/cloud/oriented_points.h"
#include "perception/cloud/tolerances.h"
#include "perception/cloud/work.h"
#include "perception/vessels/revolved_wall.h"

namespace cwm::perception {

// derived: the least number of points of a handle: two thirds of those of a shape (the paper's
// "fairly large"), since the roots lie within the noise of the wall.
inline constexpr std::size_t kMinHandlePoints = kFiveSamples * 2 / 3;

// Sizes of handles, for walls and solids alike. The paper states no numbers ("fairly large,
// elongated"). They are assumed, not measured on a data set: the outer sizes of handles of cups,
// mugs, pans and jugs for the table, 5 to 15 mm thick, bars of pans up to 25 mm, with some margin.

// chosen: the length of the visible part of a handle.
inline constexpr double kMinHandleLength_m = 0.02, kMaxHandleLength_m = 0.25;
// chosen: the least ratio of length to mean width.
inline constexpr double kMinElongation = 2;
// chosen: the largest mean width, and the SeenWidth_m of strips 18 mm wide with ragged edges.
inline constexpr double kMaxHandleWidth_m = 0.03;
// chosen: the reach of a bow with room for a hand. A handle that reaches out farther is a bar,
// which is straight.
inline constexpr double kMaxBowReach_m = 0.065;
// chosen: the largest width at the widest place, as SeenWidth_m measures it: that of a thick pan's
// handle, with noise at its edges. Bows that return to the wall, and long bars, are no spouts and
// may be this wide at one place.
inline constexpr double kMaxSeenHandleWidth_m = 0.034;

// The walls of revolution of an object, and the criteria for its handles.
class Vessel {
 public:
  // Indices of points, ascending.
  using Cluster = std::vector<std::uint32_t>;

  // Returns the vessel of the object; empty if it has no wall of revolution (FitRevolvedWalls).
  static std::optional<Vessel> Find(const OrientedPoints& object, const Work& work);

  // A vessel with known walls of the object.
  Vessel(const OrientedPoints& object, std::vector<RevolvedWall> walls);

  const std::vector<RevolvedWall>& walls() const { return walls_; }

  // Clusters that stand out from the walls. Spouts have a free end as high as the vessel.
  struct FixedParts {
    std::vector<Cluster> handles, spouts;
  };
  // Finds handles and spouts among those points of the object whose flag in `among` is set.
  FixedParts FindFixedParts(const OrientedPoints& object, const std::vector<char>& among,
                            const Work& work) const;

  // Returns the points outside the walls, by more than noise explains and no farther than handles
  // reach.
  Cluster ProtrudingPoints(const OrientedPoints& points, const std::vector<char>& among) const;

  // Returns clusters of another object's points, seen by the same sensor, that are handles of this
  // vessel and begin at its wall. The segmentation gave them to an object that touches the vessel.
  std::vector<Cluster> FindHandlesIn(const OrientedPoints& other, const Work& work) const;

  // The distance from the walls to the nearest point of the cluster, 0 if it reaches them.
  double Gap_m(const OrientedPoints& points, const Cluster& cluster) const;

  // The share of the points in `among` that lie on one of the walls or within its thickness; 1 if
  // there are no points.
  double ShareOnWalls(const OrientedPoints& other, const std::vector<char>& among) const;

  // Merges handles that continue each other.
  void MergeHandles(const OrientedPoints& object, std::vector<Cluster>& handles) const;

  // True if another object's points, seen by the same sensor, are as a whole a handle of this
  // vessel, or the rest of one whose `known` points are given.
  bool HasHandle(const OrientedPoints& other, const std::vector<Eigen::Vector3f>& known) const;

 private:
  double Protrusion_m(const Eigen::Vector3f& p) const;  // from the nearest wall
  bool IsHandle(const OrientedPoints& points, const Cluster& cluster, double gap_m) const;
  bool IsSpout(const OrientedPoints& points, const Cluster& cluster) const;
  bool HasSpoutTip(const std::vector<Eigen::Vector3f>& members) const;
  bool BeginsAtWall(const OrientedPoints& points, const Cluster& cluster) const;
  bool Continues(const std::vector<Eigen::Vector3f>& handle,
                 const std::vector<Eigen::Vector3f>& part, const Vector3& viewpoint) const;
  void MergeParts(const OrientedPoints& object, std::vector<Cluster> parts,
                  std::vector<Cluster>& handles) const;

  std::vector<RevolvedWall> walls_;
  double pitch_m_;  // between neighbouring points, across the ray
};

}  // namespace cwm::perception
