#include "perception/surface/projection_mesh.h"

#include <pcl/console/print.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/surface/gp3.h>
#include <pcl/surface/mls.h>
#include <pcl/surface/impl/gp3.hpp>
#include <pcl/surface/impl/mls.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cwm::perception {
namespace {

using namespace std::chrono_literals;

// chosen: twice the number of vertices within the longest edge if evenly spaced; they are 0.6 to 2
// spacings apart.
constexpr int kMaxNeighbors = 60;
// chosen: the largest angle between the normals along an edge; more is a fold.
constexpr double kMaxFold_rad = std::numbers::pi / 3;

using Cloud = pcl::PointCloud<pcl::PointNormal>;

// A search tree that may end the library's loops by an exception: both search it once or a few
// times per vertex (some microseconds each). They only hold containers and smart pointers, so
// unwinding them is safe.
template <class Point>
class PolledTree : public pcl::search::KdTree<Point> {
 public:
  // A search, with the work of the loops in between, takes about 10 us.
  explicit PolledTree(const Work& work) : poll_(work, ItemsPerChunk(10us)) {}

  using pcl::search::Search<Point>::nearestKSearch;
  using pcl::search::Search<Point>::radiusSearch;
  int nearestKSearch(const Point& point, int k, pcl::Indices& indices,
                     std::vector<float>& squared_distances) const override {
    poll_();
    return pcl::search::KdTree<Point>::nearestKSearch(point, k, indices, squared_distances);
  }
  int radiusSearch(const Point& point, double radius, pcl::Indices& indices,
                   std::vector<float>& squared_distances, unsigned int max_count) const override {
    poll_();
    return pcl::search::KdTree<Point>::radiusSearch(point, radius, indices, squared_distances,
                                                    max_count);
  }

 private:
  mutable PollEvery poll_;  // the library's loops run on one thread
};

Cloud::Ptr Smooth(const std::vector<Eigen::Vector3f>& vertices, double spacing_m,
                  const Work& work) {
  const auto input = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (const Eigen::Vector3f& p : vertices) input->emplace_back(p.x(), p.y(), p.z());
  pcl::MovingLeastSquares<pcl::PointXYZ, pcl::PointNormal> mls;
  mls.setInputCloud(input);
  mls.setSearchMethod(std::make_shared<PolledTree<pcl::PointXYZ>>(work));
  mls.setSearchRadius(kMaxEdge * spacing_m);  // quadrics by default
  mls.setComputeNormals(true);
  Cloud smoothed;
  mls.process(smoothed);
  // The library drops vertices with fewer than three neighbours. They stay where they are.
  const auto result = std::make_shared<Cloud>();
  for (const Eigen::Vector3f& p : vertices) {
    result->emplace_back(p.x(), p.y(), p.z(), 0.F, 0.F, 1.F);
  }
  const pcl::Indices& source = mls.getCorrespondingIndices()->indices;
  for (std::size_t i = 0; i < smoothed.size() && i < source.size(); ++i) {
    const Eigen::Vector3f moved = smoothed[i].getVector3fMap() - vertices[source[i]];
    const Eigen::Vector3f normal = smoothed[i].getNormalVector3fMap();
    if (!(normal.squaredNorm() > 0.5F && normal.squaredNorm() < 2)) continue;  // also when NaN
    (*result)[source[i]].getNormalVector3fMap() = normal.normalized();
    // A quadric through few or nearly collinear neighbours may run anywhere.
    if (moved.norm() < spacing_m) (*result)[source[i]].getVector3fMap() += moved;
  }
  return result;
}

std::vector<pcl::Vertices> Triangulate(const Cloud::Ptr& cloud, double spacing_m,
                                       const Work& work) {
  pcl::GreedyProjectionTriangulation<pcl::PointNormal> front;
  front.setInputCloud(cloud);
  front.setSearchMethod(std::make_shared<PolledTree<pcl::PointNormal>>(work));
  front.setSearchRadius(kMaxEdge * spacing_m);
  front.setMu(kMaxEdge);  // limits edges to this many distances to the nearest vertex
  front.setMaximumNearestNeighbors(kMaxNeighbors);
  front.setMaximumSurfaceAngle(kMaxFold_rad);
  // The library's defaults prefer angles of 10 to 120 degrees.
  front.setNormalConsistency(false);
  std::vector<pcl::Vertices> polygons;
  front.reconstruct(polygons);
  return polygons;
}

}  // namespace

ProjectionMesh MeshByProjection(const std::vector<Eigen::Vector3f>& vertices, double spacing_m,
                                const Work& work) {
  ProjectionMesh mesh{.vertices = vertices, .triangles = {}};
  if (vertices.size() < 3) return mesh;
  // Otherwise the library prints a message for each vertex at a border.
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  const Cloud::Ptr smoothed = Smooth(vertices, spacing_m, work);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    mesh.vertices[i] = (*smoothed)[i].getVector3fMap();
  }
  for (const pcl::Vertices& polygon : Triangulate(smoothed, spacing_m, work)) {
    const bool valid = polygon.vertices.size() == 3 &&
                       std::all_of(polygon.vertices.begin(), polygon.vertices.end(), [&](auto v) {
                         return static_cast<std::size_t>(v) < vertices.size();
                       });
    if (!valid) continue;
    mesh.triangles.push_back({static_cast<std::uint32_t>(polygon.vertices[0]),
                              static_cast<std::uint32_t>(polygon.vertices[1]),
                              static_cast<std::uint32_t>(polygon.vertices[2])});
  }
  return mesh;
}

}  // namespace cwm::perception
