// Handles of vessels: what stands out from a wall of revolution, slim all along. A wall is
// known where no solid stands for it that a handle could grow from (handles.h).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "perception/cloud/oriented_points.h"
#include "perception/cloud/tolerances.h"
#include "perception/cloud/work.h"
#include "perception/vessels/revolved_wall.h"

namespace cwm::perception {

// derived: fewer points show no handle: two thirds of those of a shape (the paper's "fairly
// large"), since its roots lie within the noise of the wall.
inline constexpr std::size_t kMinHandlePoints = kFiveSamples * 2 / 3;

// What handles are like, of walls and of solids. The paper states no numbers ("fairly large,
// elongated"). Assumed, not measured on a data set: the outer sizes of the handles of cups, mugs,
// pans and jugs for the table, 5 to 15 mm thick, bars of pans up to 25, with some room.

// chosen: along what is seen of a handle.
inline constexpr double kMinHandleLength_m = 0.02, kMaxHandleLength_m = 0.25;
// chosen: length to mean width.
inline constexpr double kMinElongation = 2;
// chosen: the mean width, and what SeenWidth_m has of strips 18 mm wide with ragged edges.
inline constexpr double kMaxHandleWidth_m = 0.03;
// chosen: a hand within a bow, and the bow: what reaches out farther is a bar, which is straight.
inline constexpr double kMaxReachOfBow_m = 0.065;
// chosen: across, where it is widest, as SeenWidth_m has it: a fat pan's, with noise at its edges.
// A bow that returns to its wall is no spout, and neither is a long bar: both may be wider at one
// place.
inline constexpr double kMaxSeenHandleWidth_m = 0.034;

// An object's walls of revolution, and what its handles must be like.
class Vessel {
 public:
  // Indices of points, ascending.
  using Cluster = std::vector<std::uint32_t>;

  // Nothing where the object has no such wall (FitRevolvedWalls).
  static std::optional<Vessel> Find(const OrientedPoints& object, const Work& work);

  // Of a wall that is known to be one of the object's.
  Vessel(const OrientedPoints& object, std::vector<RevolvedWall> walls);

  const std::vector<RevolvedWall>& walls() const { return walls_; }

  // Clusters that stand out from the walls. Spouts end free, as high as the vessel is.
  struct Fixed {
    std::vector<Cluster> handles, spouts;
  };
  // Of those of the object's points for which `among` holds.
  Fixed FindFixed(const OrientedPoints& object, const std::vector<char>& among,
                  const Work& work) const;

  // Which points lie outside the walls, by more than noise explains and no farther than handles reach.
  Cluster StandOut(const OrientedPoints& points, const std::vector<char>& among) const;

  // Clusters of other points than the object's, seen by the same sensor, that are handles of it and
  // begin at its wall: what it touches took them.
  std::vector<Cluster> FindHandlesIn(const OrientedPoints& other, const Work& work) const;

  // From the wall to the nearest of some points, 0 where they reach it.
  double Gap_m(const OrientedPoints& points, const Cluster& cluster) const;

  // Share of such points that lie on one of the walls or within its thickness; 1 of none.
  double ShareOnWalls(const OrientedPoints& other, const std::vector<char>& among) const;

  // Makes one of those that continue each other.
  void Join(const OrientedPoints& object, std::vector<Cluster>& handles) const;

  // Whether other points than the object's, seen by the same sensor, are a handle of it as a whole,
  // or a part of one of which the `known` points are known.
  bool HasHandle(const OrientedPoints& other, const std::vector<Eigen::Vector3f>& known) const;

 private:
  double StandsOut_m(const Eigen::Vector3f& p) const;  // of the wall that it is nearest to
  bool IsHandle(const OrientedPoints& points, const Cluster& cluster, double gap_m) const;
  bool IsSpout(const OrientedPoints& points, const Cluster& cluster) const;
  bool EndsAsSpout(const std::vector<Eigen::Vector3f>& members) const;
  bool BeginsAtWall(const OrientedPoints& points, const Cluster& cluster) const;
  bool Continues(const std::vector<Eigen::Vector3f>& handle,
                 const std::vector<Eigen::Vector3f>& part, const Vector3& viewpoint) const;
  void JoinParts(const OrientedPoints& object, std::vector<Cluster> parts,
                 std::vector<Cluster>& handles) const;

  std::vector<RevolvedWall> walls_;
  double pitch_m_;  // between neighbouring points, across the ray
};

}  // namespace cwm::perception
