// Many points against one solid, in arrays per coordinate that become vectors: what a batch of
// points is sampled with. Plain numbers without Eigen, since the source is compiled for several
// instruction sets and the machine's best is taken at run time. The formulas are those of
// solid_distance-inl.h; tests hold them to signed_distance.h.
//
// A lane's answer depends on that lane alone, to the same bits on every processor.
#pragma once

#include <cstdint>
#include <limits>

namespace cwm::collision {

inline constexpr int kBlockLanes = 64;  // points that are measured together
inline constexpr int kSampleLanes = 8;  // a multiple of every vector length: loops have no rest

// One side of a plane figure, from (a_x, a_y) along (along_x, along_y).
struct ProfileEdge {
  double a_x, a_y;
  double along_x, along_y;
  double inverse_length_m2;   // 1 / (squared length)
  double out_x, out_y;        // unit, away from the solid
  double slope;               // along_x / along_y; 0 where level
  std::int32_t previous = 0;  // the edge that ends where this one begins, -1: none does
  bool has_next = true;       // an edge begins where this one ends
};

// A placed solid. A point is taken to its frame by axis[i] . (p - origin).
struct LaneSolid {
  enum class Form {
    kRound,      // size: radius, half length along z
    kBox,        // size: half edges
    kCylinder,   // size: radius, half length
    kHalfSpace,  // solid for z <= 0
    kRevolved,   // edges in (radial, z), from the axis to the axis
    kPlate,      // edges in (x, y); size: thickness
  };
  Form form = Form::kRound;
  double axis[3][3] = {};
  double origin[3] = {};
  double size[3] = {};
  const ProfileEdge* edges = nullptr;
  int edge_count = 0;
};

template <int kCount>
struct LanePoints {
  alignas(64) double x[kCount];
  alignas(64) double y[kCount];
  alignas(64) double z[kCount];
};
using BlockPoints = LanePoints<kBlockLanes>;

struct alignas(64) BlockDistances {
  double lane[kBlockLanes];
};

// The nearest and the second nearest of the solids seen so far; equally near ones by their order.
struct NearestLanes {
  static constexpr double kNone = std::numeric_limits<double>::infinity();
  alignas(64) double best_m[kBlockLanes];
  alignas(64) double second_m[kBlockLanes];
  alignas(64) std::int64_t order[kBlockLanes];      // of the nearest
  alignas(64) std::int64_t candidate[kBlockLanes];  // whatever the caller calls it
  // How far a solid may be and still matter: the distance of the nearest so far, the depth where a
  // lane is inside; outside no more than a limit.
  BlockDistances reach_m;

  void Clear(double limit_m);
};

void ComputeDistances(const LaneSolid& solid, const BlockPoints& points,
                      BlockDistances& distances_m);

struct CandidateRef {
  std::int64_t order;
  std::int64_t candidate;
};
// Returns the greatest reach of a lane.
double UpdateNearest(const BlockDistances& distances_m, const CandidateRef& ref, double limit_m,
                     NearestLanes& nearest);

// Distance, gradient in the world frame, and how much farther the nearest other place of this solid
// is that the gradient could point away from. All forms but kRevolved and kPlate.
struct LaneSamples {
  alignas(64) double distance_m[kSampleLanes];
  alignas(64) double gradient_x[kSampleLanes];
  alignas(64) double gradient_y[kSampleLanes];
  alignas(64) double gradient_z[kSampleLanes];
  alignas(64) double gap_m[kSampleLanes];
};
void SampleLanes(const LaneSolid& solid, const LanePoints<kSampleLanes>& points,
                 LaneSamples& samples);

}  // namespace cwm::collision
