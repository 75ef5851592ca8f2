// The image of rigid surfaces that a robot moves, as its links' models show it: one value for each
// cell of 2 x 2 pixels, which is as fine as outlines of a measured image are.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "perception/live/depth_image.h"
#include "perception/live/robot_surface.h"

namespace cwm::perception {

inline constexpr int kSilhouetteCell_px = 2;

// Row-major cells. A cell that the image's edge cuts counts as a whole one.
class RobotSilhouette {
 public:
  static constexpr float kNothing_m = std::numeric_limits<float>::infinity();

  // Makes the image empty, for a camera.
  void Reset(const DepthCamera& camera);

  // Draws a surface at X_CL over what is farther. Parts nearer than kNearPlane_m are cut away, and
  // so is what a camera inside of a solid sees of its inner side.
  static constexpr float kNearPlane_m = 0.01F;
  void Draw(const LinkSurface& surface, const Pose& X_CL, std::int16_t body);

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  // Depth along the optical axis at the cell's centre, metres; kNothing_m where nothing was drawn.
  std::vector<float>& near_m() { return near_m_; }
  const std::vector<float>& near_m() const { return near_m_; }
  // The item that was drawn there; -1 for none.
  const std::vector<std::int16_t>& body() const { return body_; }

  // The number of cells, along a row or a column or diagonally, to the nearest one on which no body
  // was drawn, at most 32767: 0 outside, 1 at the inner edge. Cells outside of the image count as
  // drawn, since nobody knows.
  std::vector<std::int16_t> CellsToOutline() const;

 private:
  void DrawTriangle(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c,
                    bool two_sided, std::int16_t body);
  void DrawClipped(const std::array<Eigen::Vector3f, 3>& corners_C, bool two_sided,
                   std::int16_t body);

  // The camera's model in cells.
  float focal_u_ = 0, focal_v_ = 0, center_u_ = 0, center_v_ = 0;
  int columns_ = 0;
  int rows_ = 0;
  std::vector<float> near_m_;
  std::vector<std::int16_t> body_;
  std::vector<Eigen::Vector3f> corners_C_;    // of the surface being drawn
  std::vector<Eigen::Vector3f> projections_;  // u, v in cells, 1 / z
};

// Each cell's least value within `radius` cells along rows and columns. The image has `columns`
// cells in a row.
void DilateNearest(int columns, int radius, std::vector<float>& near_m);

}  // namespace cwm::perception
