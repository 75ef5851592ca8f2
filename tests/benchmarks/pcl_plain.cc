#include "tests/benchmarks/pcl_plain.h"

#include <pcl/ModelCoefficients.h>
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

#include <cmath>

#include "tests/benchmarks/stopwatch.h"

namespace cwm::benchmarks {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

Cloud::Ptr ToPcl(const perception::PointCloud& cloud) {
  auto out = std::make_shared<Cloud>();
  out->reserve(cloud.size());
  for (const Eigen::Vector3f& p : cloud.points) {
    if (p.allFinite()) out->push_back({p.x(), p.y(), p.z()});
  }
  return out;
}

}  // namespace

PclPlainTimes RunPclPlain(const perception::PointCloud& cloud) {
  const Cloud::Ptr raw = ToPcl(cloud);
  PclPlainTimes times;
  Stopwatch watch;

  auto voxels = std::make_shared<Cloud>();
  pcl::VoxelGrid<pcl::PointXYZ> grid;
  grid.setInputCloud(raw);
  grid.setLeafSize(0.004F, 0.004F, 0.004F);
  grid.filter(*voxels);
  times.voxel_grid_ms = watch.Lap_ms();

  auto tree = std::make_shared<pcl::search::KdTree<pcl::PointXYZ>>();
  auto normals = std::make_shared<pcl::PointCloud<pcl::Normal>>();
  pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
  estimation.setInputCloud(voxels);
  estimation.setSearchMethod(tree);
  estimation.setKSearch(20);
  estimation.compute(*normals);
  times.normals_ms = watch.Lap_ms();

  auto inliers = std::make_shared<pcl::PointIndices>();
  auto coefficients = std::make_shared<pcl::ModelCoefficients>();
  pcl::SACSegmentationFromNormals<pcl::PointXYZ, pcl::Normal> plane;
  plane.setModelType(pcl::SACMODEL_NORMAL_PLANE);
  plane.setMethodType(pcl::SAC_RANSAC);
  plane.setNormalDistanceWeight(0.1);
  plane.setMaxIterations(1000);
  plane.setProbability(0.99);
  plane.setDistanceThreshold(0.01);
  plane.setInputCloud(voxels);
  plane.setInputNormals(normals);
  plane.segment(*inliers, *coefficients);
  times.plane_ms = watch.Lap_ms();

  auto table = std::make_shared<Cloud>();
  pcl::ProjectInliers<pcl::PointXYZ> project;
  project.setModelType(pcl::SACMODEL_PLANE);
  project.setInputCloud(voxels);
  project.setIndices(inliers);
  project.setModelCoefficients(coefficients);
  project.filter(*table);
  auto hull = std::make_shared<Cloud>();
  pcl::ConvexHull<pcl::PointXYZ> convex;
  convex.setInputCloud(table);
  convex.setDimension(2);
  convex.reconstruct(*hull);
  auto above = std::make_shared<pcl::PointIndices>();
  pcl::ExtractPolygonalPrismData<pcl::PointXYZ> prism;
  prism.setInputCloud(voxels);
  prism.setInputPlanarHull(hull);
  prism.setHeightLimits(0.01, 0.5);
  prism.setViewPoint(0, 0, 0);
  prism.segment(*above);
  times.prism_ms = watch.Lap_ms();

  std::vector<pcl::PointIndices> clusters;
  auto objects = std::make_shared<Cloud>(*voxels, above->indices);
  auto object_tree = std::make_shared<pcl::search::KdTree<pcl::PointXYZ>>();
  if (!objects->empty()) object_tree->setInputCloud(objects);
  pcl::EuclideanClusterExtraction<pcl::PointXYZ> extraction;
  extraction.setClusterTolerance(0.015);
  extraction.setMinClusterSize(50);
  extraction.setSearchMethod(object_tree);
  extraction.setInputCloud(objects);
  if (!objects->empty()) extraction.extract(clusters);
  times.clusters_ms = watch.Lap_ms();
  times.clusters = static_cast<int>(clusters.size());
  return times;
}

}  // namespace cwm::benchmarks
