#include "perception/mesh_hypothesis.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "perception/cloud/tolerances.h"
#include "perception/cloud/voxel_grid.h"
#include "perception/explained_points.h"
#include "perception/hypotheses/point_sample.h"
#include "perception/segmentation/disjoint_sets.h"

namespace cwm::perception {
namespace {

using namespace std::chrono_literals;

Vector3 MeanOf(const OrientedPoints& points) {
  Vector3 sum = Vector3::Zero();
  for (const Eigen::Vector3f& p : points.points) sum += p.cast<double>();
  return sum / static_cast<double>(points.size());
}

PointSet MembersOf(const std::vector<std::int32_t>& part_of_point, std::size_t part) {
  PointSet members;
  for (std::uint32_t k = 0; k < part_of_point.size(); ++k) {
    if (part_of_point[k] == static_cast<std::int32_t>(part)) members.push_back(k);
  }
  return members;
}

// The members without remnants: groups of fewer points than show a surface, no wider than the
// tolerance within which a surface explains points. They are mixed pixels and noise beside the
// shapes; a mesh of them would be one of single triangles. `stride`: measured points for each
// point.
PointSet WithoutRemnants(const OrientedPoints& points, const PointSet& members,
                         std::size_t stride) {
  std::vector<Eigen::Vector3f> positions;
  for (const std::uint32_t k : members) positions.push_back(points.points[k]);
  const VoxelGrid grid = VoxelGrid::BuildCells(positions, static_cast<float>(kExplainedWithin_m));
  DisjointSets groups(grid.size());
  for (std::size_t cell = 0; cell < grid.size(); ++cell) {
    grid.ForEachWithin(1, grid.cell(cell), [&](std::size_t other) { groups.Join(cell, other); });
  }
  std::vector<Eigen::AlignedBox3f> bounds(grid.size());
  std::vector<std::size_t> counts(grid.size(), 0);
  for (std::size_t cell = 0; cell < grid.size(); ++cell) {
    const std::size_t group = groups.Root(cell);
    for (const std::uint32_t k : grid.PointsOf(cell)) bounds[group].extend(positions[k]);
    counts[group] += grid.PointsOf(cell).size() * stride;
  }
  PointSet kept;
  for (std::size_t cell = 0; cell < grid.size(); ++cell) {
    const std::size_t group = groups.Root(cell);
    const bool is_remnant =
        counts[group] < kTwoSamples &&
        static_cast<double>(bounds[group].diagonal().norm()) < kExplainedWithin_m;
    if (is_remnant) continue;
    for (const std::uint32_t k : grid.PointsOf(cell)) kept.push_back(members[k]);
  }
  std::sort(kept.begin(), kept.end());
  return kept;
}

// Builds the hybrid model of a sample's points.
class HybridBuilder {
 public:
  HybridBuilder(const OrientedPoints& points, std::size_t stride, const HypothesisModel& model,
                const std::vector<std::int32_t>& part_of_point, const SurfaceOptions& options,
                const Work& work)
      : points_(points),
        stride_(stride),
        found_(model.object),
        part_of_point_(part_of_point),
        options_(options),
        work_(work) {
    out_.X_LO.translation() = MeanOf(points);
    X_OL_ = out_.X_LO.inverse(Eigen::Isometry);
  }

  void Build() {
    FindExplained();
    out_.model = std::make_shared<HybridModel>();
    out_.model->point_count = static_cast<int>(points_.size());
    AddHandles();
    AddSurface();
    for (ShapePart part : found_.shapes) {
      part.X_OS = X_OL_ * part.X_OS;
      out_.model->shapes.push_back(std::move(part));
    }
    out_.explained = static_cast<std::uint64_t>(std::ranges::count(explained_, 1));
  }

  MeshedObject Take() { return std::move(out_); }

 private:
  void FindExplained() {
    PollEvery poll(work_, ItemsPerChunk(1us));
    explained_.resize(points_.size());
    for (std::size_t k = 0; k < points_.size(); ++k) {
      poll();
      explained_[k] =
          IsNearAnyShape(found_.shapes, part_of_point_[k], points_.points[k].cast<double>(),
                         ExplainedWithin_m(points_.sigma_m[k]));
    }
  }

  void AddHandles() {
    for (std::size_t h = 0; h < found_.handles.size(); ++h) {
      Handle handle = found_.handles[h];
      const PointSet members = MembersOf(part_of_point_, found_.shapes.size() + h);
      if (!members.empty()) handle.surface = MeshOf(members);
      handle.axis_O = X_OL_.linear() * handle.axis_O;
      handle.bounds.X_FS = X_OL_ * handle.bounds.X_FS;
      out_.model->handles.push_back(std::move(handle));
    }
  }

  // Meshes points that no shape explains, and points that their shape, once bounded, does not
  // reach. Beside shapes, remnants are left unexplained; they keep their label.
  void AddSurface() {
    PointSet remaining;
    for (std::uint32_t k = 0; k < points_.size(); ++k) {
      if (!explained_[k]) remaining.push_back(k);
    }
    if (!remaining.empty() && !found_.shapes.empty()) {
      remaining = WithoutRemnants(points_, remaining, stride_);
    }
    if (remaining.empty()) return;
    Mesh mesh = MeshOf(remaining);
    if (!mesh.mesh || mesh.mesh->triangles.empty()) return;
    out_.model->surfaces.push_back({std::move(mesh), static_cast<int>(remaining.size())});
  }

  // Meshes the members; those that are near their mesh count as explained.
  Mesh MeshOf(const PointSet& members) {
    Surface surface = ReconstructSurface(Subset(points_, members), options_, work_);
    for (std::uint32_t k : surface.explained) explained_[members[k]] = 1;
    for (Vector3& v : surface.mesh.vertices) v = X_OL_ * v;
    return MakeMesh(std::move(surface.mesh));
  }

  const OrientedPoints& points_;
  const std::size_t stride_;
  const ObjectModel& found_;
  const std::vector<std::int32_t>& part_of_point_;
  const SurfaceOptions& options_;
  const Work& work_;
  Pose X_OL_;
  std::vector<char> explained_;
  MeshedObject out_;
};

// Scales the counts of a sample to all points.
void ScaleCounts(const PointSample& sample, MeshedObject& object) {
  const auto scale = [&sample](int& count) {
    count = static_cast<int>(sample.Scaled(static_cast<std::uint64_t>(count)));
  };
  scale(object.model->point_count);
  for (ShapePart& part : object.model->shapes) {
    if (part.fit) scale(part.fit->inlier_count);
  }
  for (Handle& handle : object.model->handles) scale(handle.point_count);
  for (SurfacePart& part : object.model->surfaces) scale(part.point_count);
  object.explained = sample.Scaled(object.explained);
}

}  // namespace

MeshedObject MeshHypothesis(const ObjectHypothesis& hypothesis, const OrientedPoints& all,
                            const SurfaceOptions& options, const Work& work) {
  SurfaceOptions surface = options;
  if (hypothesis.model->is_reduced_effort) surface.spacing_m *= 2;  // a quarter of the triangles
  const PointSample sample(all, hypothesis.points, hypothesis.node_count);
  const OrientedPoints points = sample.Points();
  const std::vector<std::int32_t> part_of_sampled =
      sample.PartsOfSampledPoints(hypothesis.model->part_of_point());
  HybridBuilder builder(points, sample.stride(), *hypothesis.model, part_of_sampled, surface, work);
  builder.Build();
  MeshedObject object = builder.Take();
  ScaleCounts(sample, object);
  return object;
}

}  // namespace cwm::perception
