#include "perception/segmentation/creases.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "perception/cloud/parallel_for.h"

namespace cwm::perception {
namespace {

using namespace std::chrono_literals;

// Angle by which the surface turns towards the viewer from a to b, in radians; positive if concave.
float Concavity_rad(const OrientedPoints& nodes, std::size_t a, std::size_t b) {
  const Eigen::Vector3f d = (nodes.points[b] - nodes.points[a]).normalized();
  return std::asin(std::clamp(nodes.normals[a].dot(d), -1.0f, 1.0f)) -
         std::asin(std::clamp(nodes.normals[b].dot(d), -1.0f, 1.0f));
}

}  // namespace

std::vector<char> FindConcaveCreasesByPairs(const SurfaceGraph& graph, float angle_rad,
                                            const Work& work) {
  std::vector<char> crease(graph.size(), 0);
  const OrientedPoints& nodes = graph.nodes();
  ParallelFor(graph.size(), ItemsPerChunk(4us), work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      graph.ForEachOppositePair(i, [&](std::size_t a, std::size_t b) {
        if (nodes.normals[a].isZero() || nodes.normals[b].isZero()) return;
        if (Concavity_rad(nodes, a, b) > angle_rad) crease[i] = 1;
      });
    }
  });
  return crease;
}

std::vector<char> FindConcaveCreases(const SurfaceGraph& graph, float angle_rad, const Work& work) {
  if (graph.planes() == nullptr) return FindConcaveCreasesByPairs(graph, angle_rad, work);
  const MeasuredPoints& image = *graph.image();
  const auto width = static_cast<std::size_t>(image.width);
  std::vector<char> crease(graph.size(), 0);
  ParallelFor(static_cast<std::size_t>(image.height), ItemsPerChunk(10us), work,  // 640 pixels
              [&](std::size_t begin, std::size_t end) {
                std::vector<std::uint8_t> of_row;
                for (std::size_t row = begin; row < end; ++row) {
                  CreaseRow(*graph.planes(), static_cast<int>(row), angle_rad, of_row);
                  for (std::size_t column = 0; column < width; ++column) {
                    const std::int32_t node = image.image[row * width + column];
                    if (node >= 0) crease[static_cast<std::size_t>(node)] = of_row[column] != 0;
                  }
                }
              });
  return crease;
}

}  // namespace cwm::perception
