// The ranges that the sensor saw in each direction; decides if a place is occupied, hidden or free.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "perception/cloud/pinhole.h"
#include "perception/cloud/point_cloud.h"

namespace cwm::perception {

// The verdict on a place by the ray from the sensor through it.
enum class RayVerdict {
  kUnknown,  // out of view, or no return
  kHidden,   // the ray ended before the place
  kHit,      // the ray ended at the place
  kThrough   // the ray passed the place: it is free
};

// chosen: fewer samples, each with its own error, give no information about an object.
inline constexpr int kMinInformed = 8;

// The number of points of a surface with each verdict.
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

// Estimates the pinhole model of an organised cloud by least squares over its points. Empty if the
// cloud is not organised or its rows and columns do not fit to one pixel (rms).
std::optional<Pinhole> EstimatePinhole(const PointCloud& cloud);

// Immutable. An organised cloud is stored as its own image, any other cloud as the six faces of a
// cube around the sensor, divided according to the number of points.
class RangeView {
 public:
  explicit RangeView(const PointCloud& cloud);

  // `p_C` is in the sensor's frame. Neighbouring directions are included: the ray passes only if no
  // neighbour returned from the point's range +- tolerance.
  RayVerdict VerdictAt(const Vector3& p_C, double tolerance_m) const;

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
