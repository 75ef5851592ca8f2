#include "collision/kernels/solid_lanes.h"

#include <cmath>

#include "collision/kernels/kink.h"

// One body for baseline x86-64, AVX2 and AVX-512. Sanitizers are not ready yet when the loader picks
// one.
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define CWM_BEST_VECTORS \
  __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define CWM_BEST_VECTORS
#endif

namespace cwm::collision {
namespace {

// Nearer to a sharp edge than this share of the solid's size, the direction away from it is lost in
// the rounding of poses and a face's normal is used instead (as in signed_distance.cc).
constexpr double kRoundoff = 1e-11;

inline double Greater(double a, double b) { return a > b ? a : b; }
inline double Less(double a, double b) { return a < b ? a : b; }

// Where the pieces of a convex figure's distance are known: `highest` above all its faces.
inline double FromFaces(double squared_outside, double highest) {
  return std::sqrt(squared_outside) + Less(highest, 0);
}

CWM_BEST_VECTORS
void MeasureRound(const LaneSolid& s, const BlockPoints& p, BlockDistances& out) {
  const double *a = s.axis[2], *o = s.origin, radius = s.size[0], half = s.size[1];
  for (int i = 0; i < kBlockLanes; ++i) {
    const double x = p.x[i] - o[0], y = p.y[i] - o[1], z = p.z[i] - o[2];
    const double along = Greater(Less(a[0] * x + a[1] * y + a[2] * z, half), -half);
    const double dx = x - along * a[0], dy = y - along * a[1], dz = z - along * a[2];
    out.lane[i] = std::sqrt(dx * dx + dy * dy + dz * dz) - radius;
  }
}

CWM_BEST_VECTORS
void MeasureBox(const LaneSolid& s, const BlockPoints& p, BlockDistances& out) {
  const double *a = s.axis[0], *b = s.axis[1], *c = s.axis[2], *o = s.origin;
  for (int i = 0; i < kBlockLanes; ++i) {
    const double x = p.x[i] - o[0], y = p.y[i] - o[1], z = p.z[i] - o[2];
    const double u = std::abs(a[0] * x + a[1] * y + a[2] * z) - s.size[0];
    const double v = std::abs(b[0] * x + b[1] * y + b[2] * z) - s.size[1];
    const double w = std::abs(c[0] * x + c[1] * y + c[2] * z) - s.size[2];
    const double outside_u = Greater(u, 0), outside_v = Greater(v, 0), outside_w = Greater(w, 0);
    out.lane[i] = FromFaces(outside_u * outside_u + outside_v * outside_v + outside_w * outside_w,
                            Greater(Greater(u, v), w));
  }
}

CWM_BEST_VECTORS
void MeasureCylinder(const LaneSolid& s, const BlockPoints& p, BlockDistances& out) {
  const double *a = s.axis[2], *o = s.origin;
  for (int i = 0; i < kBlockLanes; ++i) {
    const double x = p.x[i] - o[0], y = p.y[i] - o[1], z = p.z[i] - o[2];
    const double along = a[0] * x + a[1] * y + a[2] * z;
    const double dx = x - along * a[0], dy = y - along * a[1], dz = z - along * a[2];
    const double side = std::sqrt(dx * dx + dy * dy + dz * dz) - s.size[0];
    const double cap = std::abs(along) - s.size[1];
    const double outside_side = Greater(side, 0), outside_cap = Greater(cap, 0);
    out.lane[i] =
        FromFaces(outside_side * outside_side + outside_cap * outside_cap, Greater(side, cap));
  }
}

CWM_BEST_VECTORS
void MeasureHalfSpace(const LaneSolid& s, const BlockPoints& p, BlockDistances& out) {
  const double *a = s.axis[2], *o = s.origin;
  for (int i = 0; i < kBlockLanes; ++i) {
    out.lane[i] = a[0] * (p.x[i] - o[0]) + a[1] * (p.y[i] - o[1]) + a[2] * (p.z[i] - o[2]);
  }
}

struct PlanePoints {
  alignas(64) double u[kBlockLanes];
  alignas(64) double v[kBlockLanes];
};

// Signed, by even and odd crossings of the level line: edge by edge, all lanes.
CWM_BEST_VECTORS
void MeasureProfile(const LaneSolid& s, const PlanePoints& p, BlockDistances& out) {
  alignas(64) double sign[kBlockLanes];
  for (int i = 0; i < kBlockLanes; ++i) out.lane[i] = NearestLanes::kNone;
  for (int i = 0; i < kBlockLanes; ++i) sign[i] = 1;
  for (int k = 0; k < s.edge_count; ++k) {
    const ProfileEdge e = s.edges[k];
    const double b_y = e.a_y + e.along_y;
    for (int i = 0; i < kBlockLanes; ++i) {
      const double u = p.u[i] - e.a_x, v = p.v[i] - e.a_y;
      const double way = Greater(Less((u * e.along_x + v * e.along_y) * e.inverse_length_m2, 1), 0);
      const double du = u - way * e.along_x, dv = v - way * e.along_y;
      out.lane[i] = Less(out.lane[i], du * du + dv * dv);
      const bool level = (e.a_y > p.v[i]) != (b_y > p.v[i]);
      const bool left = u < v * e.slope;
      sign[i] = (level & left) ? -sign[i] : sign[i];
    }
  }
  for (int i = 0; i < kBlockLanes; ++i) out.lane[i] = sign[i] * std::sqrt(out.lane[i]);
}

CWM_BEST_VECTORS
void ToRadial(const LaneSolid& s, const BlockPoints& p, PlanePoints& plane) {
  const double *a = s.axis[2], *o = s.origin;
  for (int i = 0; i < kBlockLanes; ++i) {
    const double x = p.x[i] - o[0], y = p.y[i] - o[1], z = p.z[i] - o[2];
    const double along = a[0] * x + a[1] * y + a[2] * z;
    const double dx = x - along * a[0], dy = y - along * a[1], dz = z - along * a[2];
    plane.u[i] = std::sqrt(dx * dx + dy * dy + dz * dz);
    plane.v[i] = along;
  }
}

CWM_BEST_VECTORS
void ToPlate(const LaneSolid& s, const BlockPoints& p, PlanePoints& plane, double* face) {
  const double *a = s.axis[0], *b = s.axis[1], *c = s.axis[2], *o = s.origin;
  const double half = 0.5 * s.size[0];
  for (int i = 0; i < kBlockLanes; ++i) {
    const double x = p.x[i] - o[0], y = p.y[i] - o[1], z = p.z[i] - o[2];
    plane.u[i] = a[0] * x + a[1] * y + a[2] * z;
    plane.v[i] = b[0] * x + b[1] * y + b[2] * z;
    face[i] = std::abs(c[0] * x + c[1] * y + c[2] * z + half) - half;
  }
}

CWM_BEST_VECTORS
void Extrude(const double* face, BlockDistances& out) {
  for (int i = 0; i < kBlockLanes; ++i) {
    const double border = out.lane[i];
    const double outside_border = Greater(border, 0), outside_face = Greater(face[i], 0);
    out.lane[i] = FromFaces(outside_border * outside_border + outside_face * outside_face,
                            Greater(border, face[i]));
  }
}

// The sample of one lane, in its own terms: loops keep it in registers.
struct Lane {
  double distance, x, y, z, gap;
};

// `one` where the condition holds, else `other`: a sum of products, which leaves nothing to branch on.
inline double Blend(double share, double one, double other) {
  return share * one + (1 - share) * other;
}

inline Lane SampleRound(const LaneSolid& s, double x, double y, double z) {
  const double *a = s.axis[2], *e = s.axis[0], half = s.size[1];
  const double along = Greater(Less(a[0] * x + a[1] * y + a[2] * z, half), -half);
  const double dx = x - along * a[0], dy = y - along * a[1], dz = z - along * a[2];
  const double length = std::sqrt(dx * dx + dy * dy + dz * dz);
  // On the core every direction across it is valid.
  const double off = length > 0 ? 1 : 0;
  const double inverse = 1 / (length + (1 - off));
  return {length - s.size[0], Blend(off, dx * inverse, e[0]), Blend(off, dy * inverse, e[1]),
          Blend(off, dz * inverse, e[2]), 2 * length};
}

// Of alternatives at the faces of a convex solid: two count only where the solid is left or touched.
inline double GapOf(double highest, double second) {
  return highest <= kKinkReach_m ? highest - second : NearestLanes::kNone;
}

inline Lane SampleBox(const LaneSolid& s, double x, double y, double z) {
  const double *a = s.axis[0], *b = s.axis[1], *c = s.axis[2];
  const double at_u = a[0] * x + a[1] * y + a[2] * z, at_v = b[0] * x + b[1] * y + b[2] * z,
               at_w = c[0] * x + c[1] * y + c[2] * z;
  const double u = std::abs(at_u) - s.size[0], v = std::abs(at_v) - s.size[1],
               w = std::abs(at_w) - s.size[2];
  const double highest = Greater(Greater(u, v), w);
  const double middle = Greater(Less(u, v), Less(Greater(u, v), w));
  const double opposite = -Less(Less(std::abs(at_u) + s.size[0], std::abs(at_v) + s.size[1]),
                                std::abs(at_w) + s.size[2]);
  const double out_u = Greater(u, 0), out_v = Greater(v, 0), out_w = Greater(w, 0);
  const double length = std::sqrt(out_u * out_u + out_v * out_v + out_w * out_w);
  const double away =
      length > kRoundoff * Greater(Greater(s.size[0], s.size[1]), s.size[2]) ? 1 : 0;
  const double inverse = 1 / (length + (1 - away));
  const double face_u = u == highest ? 1.0 : 0.0;
  const double face_v = (1 - face_u) * (v == highest ? 1.0 : 0.0);
  const double face_w = 1 - face_u - face_v;
  const double n_u = std::copysign(Blend(away, out_u * inverse, face_u), at_u);
  const double n_v = std::copysign(Blend(away, out_v * inverse, face_v), at_v);
  const double n_w = std::copysign(Blend(away, out_w * inverse, face_w), at_w);
  return {length + Less(highest, 0), n_u * a[0] + n_v * b[0] + n_w * c[0],
          n_u * a[1] + n_v * b[1] + n_w * c[1], n_u * a[2] + n_v * b[2] + n_w * c[2],
          GapOf(highest, Greater(middle, opposite))};
}

inline Lane SampleCylinder(const LaneSolid& s, double x, double y, double z) {
  const double *a = s.axis[2], *e = s.axis[0];
  const double along = a[0] * x + a[1] * y + a[2] * z;
  const double dx = x - along * a[0], dy = y - along * a[1], dz = z - along * a[2];
  const double radial = std::sqrt(dx * dx + dy * dy + dz * dz);
  const double side = radial - s.size[0], cap = std::abs(along) - s.size[1];
  const double highest = Greater(side, cap);
  const double second =
      Greater(Less(side, cap), Greater(-radial - s.size[0], cap - 2 * std::abs(along)));
  const double out_side = Greater(side, 0), out_cap = Greater(cap, 0);
  const double length = std::sqrt(out_side * out_side + out_cap * out_cap);
  const double away = length > kRoundoff * Greater(s.size[0], s.size[1]) ? 1 : 0;
  const double inverse = 1 / (length + (1 - away));
  const double face_side = side == highest ? 1 : 0;
  const double n_side = Blend(away, out_side * inverse, face_side);
  const double n_cap = std::copysign(Blend(away, out_cap * inverse, 1 - face_side), along);
  // On the axis every radial direction is valid.
  const double off = radial > 0 ? 1 : 0;
  const double unit = 1 / (radial + (1 - off));
  const double e_x = Blend(off, dx * unit, e[0]), e_y = Blend(off, dy * unit, e[1]),
               e_z = Blend(off, dz * unit, e[2]);
  return {length + Less(highest, 0), n_side * e_x + n_cap * a[0], n_side * e_y + n_cap * a[1],
          n_side * e_z + n_cap * a[2], GapOf(highest, second)};
}

inline Lane SampleHalfSpace(const LaneSolid& s, double x, double y, double z) {
  const double* a = s.axis[2];
  return {a[0] * x + a[1] * y + a[2] * z, a[0], a[1], a[2], NearestLanes::kNone};
}

// Of a copy, which no output can be a part of. Templates take no clones, hence a macro.
#define CWM_SAMPLE_LANES(Function, Sample)                                                  \
  CWM_BEST_VECTORS void Function(const LaneSolid& solid, const LanePoints<kSampleLanes>& p, \
                                 LaneSamples& out) {                                        \
    const LaneSolid s = solid;                                                              \
    for (int i = 0; i < kSampleLanes; ++i) {                                                \
      const Lane lane =                                                                     \
          Sample(s, p.x[i] - s.origin[0], p.y[i] - s.origin[1], p.z[i] - s.origin[2]);      \
      out.distance_m[i] = lane.distance;                                                    \
      out.gradient_x[i] = lane.x;                                                           \
      out.gradient_y[i] = lane.y;                                                           \
      out.gradient_z[i] = lane.z;                                                           \
      out.gap_m[i] = lane.gap;                                                              \
    }                                                                                       \
  }
CWM_SAMPLE_LANES(SampleRounds, SampleRound)
CWM_SAMPLE_LANES(SampleBoxes, SampleBox)
CWM_SAMPLE_LANES(SampleCylinders, SampleCylinder)
CWM_SAMPLE_LANES(SampleHalfSpaces, SampleHalfSpace)
#undef CWM_SAMPLE_LANES

CWM_BEST_VECTORS
double Keep(const BlockDistances& d, Met met, double limit_m, NearestLanes& nearest) {
  for (int i = 0; i < kBlockLanes; ++i) {
    const double now = d.lane[i], before = nearest.best_m[i];
    const std::int64_t order = nearest.order[i], candidate = nearest.candidate[i];
    const bool nearer = (now < before) | ((now == before) & (met.order < order));
    const double best = nearer ? now : before, other = nearer ? before : now;
    nearest.order[i] = nearer ? met.order : order;
    nearest.candidate[i] = nearer ? met.candidate : candidate;
    nearest.second_m[i] = Less(nearest.second_m[i], other);
    nearest.best_m[i] = best;
    nearest.reach_m.lane[i] = Greater(Less(best, limit_m), -best);
  }
  alignas(64) double reach[kBlockLanes / 2];
  for (int i = 0; i < kBlockLanes / 2; ++i) {
    reach[i] = Greater(nearest.reach_m.lane[i], nearest.reach_m.lane[i + kBlockLanes / 2]);
  }
  for (int width = kBlockLanes / 4; width >= kSampleLanes; width /= 2) {
    for (int i = 0; i < width; ++i) reach[i] = Greater(reach[i], reach[i + width]);
  }
  double farthest = 0;
  for (int i = 0; i < kSampleLanes; ++i) farthest = Greater(farthest, reach[i]);
  return farthest;
}

}  // namespace

void NearestLanes::Clear(double limit_m) {
  for (int i = 0; i < kBlockLanes; ++i) {
    best_m[i] = second_m[i] = kNone;
    reach_m.lane[i] = limit_m;
    order[i] = std::numeric_limits<std::int64_t>::max();
    candidate[i] = -1;
  }
}

void MeasureLanes(const LaneSolid& solid, const BlockPoints& points, BlockDistances& distances_m) {
  PlanePoints plane;
  alignas(64) double face[kBlockLanes];
  switch (solid.form) {
    case LaneSolid::Form::kRound:
      return MeasureRound(solid, points, distances_m);
    case LaneSolid::Form::kBox:
      return MeasureBox(solid, points, distances_m);
    case LaneSolid::Form::kCylinder:
      return MeasureCylinder(solid, points, distances_m);
    case LaneSolid::Form::kHalfSpace:
      return MeasureHalfSpace(solid, points, distances_m);
    case LaneSolid::Form::kRevolved:
      ToRadial(solid, points, plane);
      return MeasureProfile(solid, plane, distances_m);
    case LaneSolid::Form::kPlate:
      ToPlate(solid, points, plane, face);
      MeasureProfile(solid, plane, distances_m);
      return Extrude(face, distances_m);
  }
}

double KeepNearest(const BlockDistances& distances_m, const Met& met, double limit_m,
                   NearestLanes& nearest) {
  return Keep(distances_m, met, limit_m, nearest);
}

void SampleLanes(const LaneSolid& solid, const LanePoints<kSampleLanes>& points,
                 LaneSamples& samples) {
  switch (solid.form) {
    case LaneSolid::Form::kRound:
      return SampleRounds(solid, points, samples);
    case LaneSolid::Form::kBox:
      return SampleBoxes(solid, points, samples);
    case LaneSolid::Form::kCylinder:
      return SampleCylinders(solid, points, samples);
    case LaneSolid::Form::kHalfSpace:
      return SampleHalfSpaces(solid, points, samples);
    case LaneSolid::Form::kRevolved:
    case LaneSolid::Form::kPlate:
      break;
  }
}

}  // namespace cwm::collision
