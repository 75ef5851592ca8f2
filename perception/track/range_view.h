// What the sensor saw along each direction: the oracle for "still there", "hidden" and "gone".
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "perception/cloud/point_cloud.h"

namespace cwm::perception {

// Of a point in space, by the ray from the sensor through it.
enum class RayVerdict {
  kUnknown,  // out of view, or nothing came back from there
  kHidden,   // the ray ended nearer
  kHit,      // the ray ended at the point
  kThrough   // the ray passed on: there is nothing at the point
};

// chosen: fewer samples that err each by itself say nothing of an object.
inline constexpr int kMinInformed = 8;

// How many points of some surface were seen how.
struct SightCounts {
  int unknown = 0;
  int hidden = 0;
  int hit = 0;
  int through = 0;

  void Add(RayVerdict verdict);
  int informed() const { return hidden + hit + through; }
  int visible() const { return hit + through; }
  // Share of the visible points that rays passed through; 0 when none is visible.
  double ThroughShare() const;
};

// u = focal_u x / z + center_u for z > 0, in pixels.
struct Pinhole {
  double focal_u_px = 0;
  double focal_v_px = 0;
  double center_u_px = 0;
  double center_v_px = 0;
};

// The pinhole through which an organised cloud was seen, by least squares over its points. Nothing
// when the cloud is not organised or its rows and columns do not fit one to a pixel (rms).
std::optional<Pinhole> EstimatePinhole(const PointCloud& cloud);

// Immutable. Of an organised cloud its own image; of any other one the six faces of a cube around
// the sensor, as finely divided as the points are dense.
class RangeView {
 public:
  explicit RangeView(const PointCloud& cloud);

  // `p_C` is in the sensor's frame. The neighbouring directions count too, so that a passing ray is
  // only believed where no neighbour returned from the point's range +- tolerance.
  RayVerdict Look(const Vector3& p_C, double tolerance_m) const;

 private:
  struct Cell {
    float nearest_m;
    float farthest_m;
  };
  struct Face {
    Matrix3 R_FC;  // the face's frame: z forward
    Pinhole pinhole;
    int width = 0;
    int height = 0;
    std::vector<Cell> cells;
  };
  struct CellIndex {
    int u = 0;
    int v = 0;
  };

  static std::optional<CellIndex> Project(const Face& face, const Vector3& p_C);
  void AddCube(std::size_t point_count);
  void Insert(const Eigen::Vector3f& p_C);

  std::vector<Face> faces_;
};

}  // namespace cwm::perception
