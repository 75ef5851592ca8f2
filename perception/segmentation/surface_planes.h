// The measured surface of an image as planes of numbers, with loops over eight pixels at once that
// find linked neighbours and creases.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/cloud/image_plane.h"

namespace cwm::perception {

struct SurfacePlanes {
  int width = 0, height = 0;
  float pixel_angle_rad = 0, sample_angle_rad = 0;  // see MeasuredPoints
  ImagePlane x, y, z;                               // metres
  ImagePlane normal_x, normal_y, normal_z;          // unit; NaN where unknown
  ImagePlane range_m;                               // from the viewpoint
  ImagePlane sigma_m;
};

SurfacePlanes PlanesOfSurface(const MeasuredPoints& measured, const std::vector<float>& range_m,
                              const Work& work);

// The neighbours of a pixel, row and column, in the order of their bits.
inline constexpr int kNeighbourOffsets[8][2] = {{-1, -1}, {-1, 0}, {-1, 1}, {0, -1},
                                                {0, 1},   {1, -1}, {1, 0},  {1, 1}};

// One entry per pixel of a row, and a few unused ones at the end.
struct RowLinks {
  std::vector<std::uint8_t> linked;  // a bit per neighbour that is on the same surface
  std::vector<std::uint8_t> steps;   // not zero if a neighbour within MaxJump_m is not linked
  explicit RowLinks(int width);
};
void LinkRow(const SurfacePlanes& planes, int row, RowLinks& links);

// One entry per pixel of a row, and a few unused ones at the end: not zero if the surface turns
// towards the viewer by more than `angle_rad` between an opposite pair around the pixel
// (SurfaceGraph::ForEachOppositePair). The angle is positive and less than a right angle.
void CreaseRow(const SurfacePlanes& planes, int row, float angle_rad,
               std::vector<std::uint8_t>& crease);

}  // namespace cwm::perception
