#include "perception/segmentation/join_vessels.h"

#include <algorithm>

#include "perception/cloud/tolerances.h"
#include "perception/segmentation/revolution.h"

namespace cwm::perception {
namespace {

// chosen: the least share of a wall's members with steep normals; a piece with fewer is a floor.
constexpr double kMinWallShare = 0.25;
// chosen: the least area of a piece that starts a wall: an espresso cup's outside.
constexpr double kMinWall_m2 = 4e-4;

// chosen: the least share of steep normals that pass a common axis, for tabletop vessels; checked
// on labelled Kinect scans. Noise lets 0.99 pass.
constexpr double kMinAgreement = 0.7;
// chosen: the area of scraps inside a vessel that are too small for a test; checked on the same
// scans.
constexpr double kInnerCap_m2 = 12e-4;

// True if nearly all of the wall faces outwards, or inwards. A piece that runs over a thin rim
// shows both sides of a wall.
bool IsOneSided(const Revolution& r) {
  return r.outward >= kMainShare || r.outward <= 1 - kMainShare;
}

// True if the piece is a wall about the axis. If it shows both sides of a wall, nearly all normals
// must agree, as two objects rarely share an axis. A piece with few steep normals is a floor.
bool IsWall(const Revolution& r) {
  return r.agreement >= (IsOneSided(r) ? kMinAgreement : kNearlyAll) && r.steep >= kMinWallShare &&
         r.radius_m <= kMaxVesselRadius_m;
}

bool IsInner(const Revolution& r) { return r.outward < kMajority; }

bool ShowsInside(const Revolution& r) { return r.outward <= kMainShare; }

bool AreBothSides(const Revolution& a, const Revolution& b) {
  return IsOneSided(a) && IsOneSided(b) && IsInner(a) != IsInner(b);
}

// Share of the sample within `radius_m` of the axis.
double ShareWithin(const OrientedPoints& nodes, const PieceSummary& piece, const Vector2& axis,
                   double radius_m) {
  double within = 0;
  for (std::uint32_t i : piece.sample) {
    within += (nodes.points[i].head<2>().cast<double>() - axis).norm() <= radius_m;
  }
  return within / static_cast<double>(piece.sample.size());
}

double ShareLevel(const OrientedPoints& nodes, const PieceSummary& piece) {
  double level = 0;
  for (std::uint32_t i : piece.sample) level += nodes.normals[i].z() >= kFloor_cos;
  return level / static_cast<double>(piece.sample.size());
}

class VesselJoiner {
 public:
  VesselJoiner(const OrientedPoints& nodes, const PieceSummaries& views, DisjointSets& objects)
      : nodes_(nodes), views_(views), objects_(objects) {}

  // Joins the pieces of the vessel of which `seed` is a wall with this axis.
  void JoinAround(std::size_t seed, const Revolution& wall) {
    std::vector<std::size_t> walls{seed};
    bool open = ShowsInside(wall);
    double radius = wall.radius_m, rim = views_.pieces[seed].high_z_m;
    for (std::size_t p = 0; p < views_.pieces.size(); ++p) {
      if (p == seed || !MayBelong(p, seed, wall)) continue;
      const Revolution r = EvaluateRevolution(nodes_, views_.pieces[p].sample, wall.axis);
      if (!IsWall(r) || r.radius_m > wall.radius_m + kVesselWall_m) continue;
      // Two outsides on one axis are stacked objects unless they touch; an inside needs the rim's
      // height.
      const bool belongs =
          AreBothSides(r, wall)
              ? std::abs(views_.pieces[p].high_z_m - views_.pieces[seed].high_z_m) <= kVesselRim_m
              : AreInContact(views_, p, seed);
      if (!belongs) continue;
      open = open || ShowsInside(r);
      radius = std::max(radius, r.radius_m);
      rim = std::max(rim, views_.pieces[p].high_z_m);
      walls.push_back(p);
    }
    for (std::size_t p : walls) objects_.Join(seed, p);
    if (open) JoinInside(seed, wall.axis, radius, rim);
  }

 private:
  bool MayBelong(std::size_t p, std::size_t seed, const Revolution& wall) const {
    const PieceSummary& piece = views_.pieces[p];
    if (piece.sample.empty() || piece.bounds.isEmpty()) return false;
    return piece.high_z_m <= views_.pieces[seed].high_z_m + kVesselRim_m &&
           ShareWithin(nodes_, piece, wall.axis, wall.radius_m + kVesselWall_m) >= kNearlyAll;
  }

  // Joins the floor and scraps of the walls: within the rim's radius, below its height, and level,
  // facing inwards, or small.
  void JoinInside(std::size_t seed, const Vector2& axis, double radius_m, double rim_m) {
    for (std::size_t p = 0; p < views_.pieces.size(); ++p) {
      const PieceSummary& piece = views_.pieces[p];
      if (piece.sample.empty() || objects_.Root(p) == objects_.Root(seed)) continue;
      if (piece.high_z_m > rim_m + kVesselWall_m) continue;
      // chosen: the least share of the piece within the rim's radius.
      if (ShareWithin(nodes_, piece, axis, radius_m + kVesselWall_m / 2) < 0.95) continue;
      const Revolution r = EvaluateRevolution(nodes_, piece.sample, axis);
      const bool inward = r.steep >= kMinWallShare && r.agreement >= kMajority && IsInner(r);
      // chosen: the least share of a floor's normals that are level.
      if (inward || ShareLevel(nodes_, piece) >= 0.7 || piece.area_m2 <= kInnerCap_m2) {
        objects_.Join(seed, p);
      }
    }
  }

  const OrientedPoints& nodes_;
  const PieceSummaries& views_;
  DisjointSets& objects_;
};

}  // namespace

void JoinVessels(const OrientedPoints& nodes, const PieceSummaries& views, DisjointSets& objects) {
  VesselJoiner joiner(nodes, views, objects);
  for (std::size_t p = 0; p < views.pieces.size(); ++p) {
    if (views.pieces[p].area_m2 < kMinWall_m2) continue;
    const std::optional<Revolution> wall = FitRevolution(nodes, views.pieces[p].sample);
    if (wall && IsWall(*wall)) joiner.JoinAround(p, *wall);
  }
}

}  // namespace cwm::perception
