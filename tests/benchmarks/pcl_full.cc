#include "tests/benchmarks/pcl_full.h"

#include <pcl/ModelCoefficients.h>
#include <pcl/common/io.h>
#include <pcl/features/normal_3d.h>
#include <pcl/filters/extract_indices.h>
#include <pcl/filters/project_inliers.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/extract_clusters.h>
#include <pcl/segmentation/extract_polygonal_prism_data.h>
#include <pcl/segmentation/sac_segmentation.h>
#include <pcl/surface/convex_hull.h>
#include <pcl/surface/gp3.h>
#include <pcl/surface/mls.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "perception/cloud/sensor_noise.h"
#include "tests/benchmarks/stopwatch.h"

namespace cwm::benchmarks {
namespace {

using Point = pcl::PointNormal;
using Cloud = pcl::PointCloud<Point>;

constexpr float kVoxel_m = 0.003F;
constexpr int kNeighbours = 20;
constexpr int kIterations = 1000;
constexpr double kProbability = 0.99;
constexpr double kClusterGap_m = 0.015;
constexpr int kMinClusterPoints = 60;                            // as our min_inliers
constexpr double kDistanceGate_sigma = 3;                        // as ours
constexpr double kNormalGate_rad = 15 * std::numbers::pi / 180;  // as ours
constexpr double kMinRadius_m = 0.004, kMaxRadius_m = 0.5;       // as ours
constexpr double kSmoothing_m = 4 * kVoxel_m, kMeshReach_m = 5 * kVoxel_m;

Cloud::Ptr Voxels(const perception::PointCloud& cloud) {
  auto raw = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (const Eigen::Vector3f& p : cloud.points) {
    if (p.allFinite()) raw->push_back({p.x(), p.y(), p.z()});
  }
  pcl::PointCloud<pcl::PointXYZ> thinned;
  pcl::VoxelGrid<pcl::PointXYZ> grid;
  grid.setInputCloud(raw);
  grid.setLeafSize(kVoxel_m, kVoxel_m, kVoxel_m);
  grid.filter(thinned);
  auto voxels = std::make_shared<Cloud>();
  pcl::copyPointCloud(thinned, *voxels);
  return voxels;
}

void EstimateNormals(const Cloud::Ptr& cloud) {
  pcl::NormalEstimation<Point, Point> estimation;
  estimation.setInputCloud(cloud);
  estimation.setSearchMethod(std::make_shared<pcl::search::KdTree<Point>>());
  estimation.setKSearch(kNeighbours);
  estimation.compute(*cloud);  // fills in the normals; points stay
}

double MedianDepth_m(const Cloud& cloud) {
  std::vector<float> depths;
  for (const Point& p : cloud) depths.push_back(p.z);
  if (depths.empty()) return 1;
  std::nth_element(depths.begin(), depths.begin() + static_cast<long>(depths.size() / 2),
                   depths.end());
  return depths[depths.size() / 2];
}

// PCL adds the normal's angle to the distance. With this weight, a point on the surface whose
// normal is at our gate is as far away as a point at the distance gate.
double NormalWeight(double gate_m) { return gate_m / (gate_m + kNormalGate_rad); }

pcl::PointIndices::Ptr FindModel(const Cloud::Ptr& cloud, int model, double gate_m,
                                 pcl::ModelCoefficients& coefficients) {
  auto inliers = std::make_shared<pcl::PointIndices>();
  pcl::SACSegmentationFromNormals<Point, Point> search;
  search.setModelType(model);
  search.setMethodType(pcl::SAC_RANSAC);
  search.setNormalDistanceWeight(NormalWeight(gate_m));
  search.setDistanceThreshold(gate_m);
  search.setMaxIterations(kIterations);
  search.setProbability(kProbability);
  search.setRadiusLimits(kMinRadius_m, kMaxRadius_m);
  search.setInputCloud(cloud);
  search.setInputNormals(cloud);
  search.segment(*inliers, coefficients);
  return inliers;
}

Cloud::Ptr Without(const Cloud::Ptr& cloud, const pcl::PointIndices::Ptr& taken) {
  auto rest = std::make_shared<Cloud>();
  pcl::ExtractIndices<Point> extract;
  extract.setInputCloud(cloud);
  extract.setIndices(taken);
  extract.setNegative(true);
  extract.filter(*rest);
  return rest;
}

// The points of objects above the largest plane, and the points that belong neither to them nor to
// the plane.
struct Split {
  Cloud::Ptr objects, rest;
};

Split SplitAtPlane(const Cloud::Ptr& cloud, double gate_m) {
  pcl::ModelCoefficients::Ptr plane = std::make_shared<pcl::ModelCoefficients>();
  const auto inliers = FindModel(cloud, pcl::SACMODEL_NORMAL_PLANE, gate_m, *plane);
  auto table = std::make_shared<Cloud>();
  pcl::ProjectInliers<Point> project;
  project.setModelType(pcl::SACMODEL_PLANE);
  project.setInputCloud(cloud);
  project.setIndices(inliers);
  project.setModelCoefficients(plane);
  project.filter(*table);
  auto hull = std::make_shared<Cloud>();
  pcl::ConvexHull<Point> convex;
  convex.setInputCloud(table);
  convex.setDimension(2);
  convex.reconstruct(*hull);
  auto above = std::make_shared<pcl::PointIndices>();
  pcl::ExtractPolygonalPrismData<Point> prism;
  prism.setInputCloud(cloud);
  prism.setInputPlanarHull(hull);
  prism.setHeightLimits(2 * gate_m, 0.5);
  prism.setViewPoint(0, 0, 0);
  prism.segment(*above);
  auto taken = std::make_shared<pcl::PointIndices>(*above);
  taken->indices.insert(taken->indices.end(), inliers->indices.begin(), inliers->indices.end());
  return {std::make_shared<Cloud>(*cloud, above->indices), Without(cloud, taken)};
}

std::vector<pcl::PointIndices> Clusters(const Cloud::Ptr& cloud) {
  std::vector<pcl::PointIndices> clusters;
  if (cloud->empty()) return clusters;
  auto tree = std::make_shared<pcl::search::KdTree<Point>>();
  tree->setInputCloud(cloud);
  pcl::EuclideanClusterExtraction<Point> extraction;
  extraction.setClusterTolerance(kClusterGap_m);
  extraction.setMinClusterSize(kMinClusterPoints);
  extraction.setSearchMethod(tree);
  extraction.setInputCloud(cloud);
  extraction.extract(clusters);
  return clusters;
}

// The inliers of the best of four models.
pcl::PointIndices::Ptr FindBestModel(const Cloud::Ptr& cloud, double gate_m) {
  auto best = std::make_shared<pcl::PointIndices>();
  for (int model : {pcl::SACMODEL_NORMAL_PLANE, pcl::SACMODEL_CYLINDER, pcl::SACMODEL_NORMAL_SPHERE,
                    pcl::SACMODEL_CONE}) {
    pcl::ModelCoefficients coefficients;
    const auto inliers = FindModel(cloud, model, gate_m, coefficients);
    if (inliers->indices.size() > best->indices.size()) best = inliers;
  }
  return best;
}

// Takes model after model, as in PCL's cylinder tutorial, until the rest makes none. Returns the
// points left.
Cloud::Ptr TakeModels(Cloud::Ptr rest, double gate_m, PclFullTimes& times) {
  constexpr auto kMin = static_cast<std::size_t>(kMinClusterPoints);
  for (bool first = true; rest->size() >= kMin; first = false) {
    Stopwatch watch;
    const auto best = FindBestModel(rest, gate_m);
    if (first) times.first_models_ms += watch.Lap_ms();
    if (best->indices.size() < kMin) break;
    ++times.models;
    rest = Without(rest, best);
  }
  return rest;
}

// Resamples by moving least squares, as our own surfaces are smoothed.
Cloud::Ptr Resampled(const Cloud::Ptr& cloud) {
  auto smooth = std::make_shared<Cloud>();
  pcl::MovingLeastSquares<Point, Point> squares;
  squares.setInputCloud(cloud);
  squares.setSearchMethod(std::make_shared<pcl::search::KdTree<Point>>());
  squares.setSearchRadius(kSmoothing_m);
  squares.setPolynomialOrder(2);
  squares.setComputeNormals(true);
  squares.process(*smooth);
  return smooth;
}

void MeshOf(const Cloud::Ptr& rough) {
  if (rough->size() < 3) return;
  const Cloud::Ptr cloud = Resampled(rough);
  if (cloud->size() < 3) return;
  auto tree = std::make_shared<pcl::search::KdTree<Point>>();
  tree->setInputCloud(cloud);
  pcl::GreedyProjectionTriangulation<Point> triangulation;
  triangulation.setSearchRadius(kMeshReach_m);
  triangulation.setMu(2.5);  // this and the following as in PCL's own tutorial
  triangulation.setMaximumNearestNeighbors(100);
  triangulation.setMaximumSurfaceAngle(std::numbers::pi / 4);
  triangulation.setMinimumAngle(std::numbers::pi / 18);
  triangulation.setMaximumAngle(2 * std::numbers::pi / 3);
  triangulation.setNormalConsistency(false);
  triangulation.setInputCloud(cloud);
  triangulation.setSearchMethod(tree);
  pcl::PolygonMesh mesh;
  triangulation.reconstruct(mesh);
}

}  // namespace

PclFullTimes RunPclFull(const perception::PointCloud& cloud) {
  PclFullTimes times;
  Stopwatch watch;
  const Cloud::Ptr voxels = Voxels(cloud);
  const double gate_m =
      kDistanceGate_sigma * perception::SensorNoise{}.AxialSigma_m(MedianDepth_m(*voxels));
  EstimateNormals(voxels);
  const Split split = SplitAtPlane(voxels, gate_m);
  std::vector<Cloud::Ptr> objects;
  for (const Cloud::Ptr& cloud : {split.objects, split.rest}) {
    for (const pcl::PointIndices& cluster : Clusters(cloud)) {
      objects.push_back(std::make_shared<Cloud>(*cloud, cluster.indices));
    }
  }
  times.clusters = static_cast<int>(objects.size());
  times.segmentation_ms = watch.Lap_ms();
  for (Cloud::Ptr& object : objects) object = TakeModels(object, gate_m, times);
  times.models_ms = watch.Lap_ms();
  for (const Cloud::Ptr& rest : objects) MeshOf(rest);
  times.meshes_ms = watch.Lap_ms();
  return times;
}

}  // namespace cwm::benchmarks
