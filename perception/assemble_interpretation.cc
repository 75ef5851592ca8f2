#include "perception/assemble_interpretation.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <utility>
#include <vector>

#include "collision/geometry/polygon.h"
#include "perception/cloud/parallel_for.h"
#include "perception/cloud/quantile.h"
#include "perception/hidden_depth.h"
#include "perception/mesh_hypothesis.h"
#include "perception/segmentation/surface_graph.h"

namespace cwm::perception {
namespace {

using namespace std::chrono_literals;

// chosen: the largest label of a support, and of an object's part (SceneInterpretation::labels).
constexpr std::uint32_t kMaxLabel = 9;

// Sets the label of each point to label(k), in parallel: every point of the cloud has one owner.
template <class Label>
void LabelEach(const OrientedPoints& all, const PointSet& points, const Work& work,
               std::vector<std::uint32_t>& labels, const Label& label) {
  // The time of one point in a cloud without any order.
  ParallelFor(points.size(), ItemsPerChunk(10ns), work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) labels[all.cloud_index[points[k]]] = label(k);
  });
}

void LabelSupports(const SceneState& state, const Work& work, std::vector<std::uint32_t>& labels) {
  for (std::uint32_t s = 0; s < state.support_count(); ++s) {
    LabelEach(state.points(), state.support(s).points, work, labels,
              [&](std::size_t) { return std::min(s + 1, kMaxLabel); });
  }
}

void LabelObject(const SceneState& state, std::uint32_t index, const Work& work,
                 std::vector<std::uint32_t>& labels) {
  const ObjectHypothesis& hypothesis = *state.hypotheses()[index];
  LabelEach(state.points(), hypothesis.points, work, labels, [&](std::size_t k) {
    const auto part = static_cast<std::uint32_t>(hypothesis.model->part_of_point()[k] + 1);
    return (kMaxLabel + 1) * (index + 2) + std::min(part, kMaxLabel);
  });
}

// The solids of all objects whose depth was measured.
std::vector<SolidOfObject> SolidsOf(const std::vector<MeshedObject>& meshed) {
  std::vector<SolidOfObject> solids;
  for (std::size_t k = 0; k < meshed.size(); ++k) {
    for (const ShapePart& part : meshed[k].model->shapes) {
      if (IsFace(part.shape)) continue;
      const Pose X_LS = meshed[k].X_LO * part.X_OS;
      solids.push_back({k, X_LS, &part, TightBounds(part.shape, X_LS)});
    }
  }
  return solids;
}

// The plane that the object stands on, else the highest support below its origin.
std::optional<Pose> GroundOf(const SceneState& state, const Resting& resting, const Pose& X_LO) {
  std::optional<Pose> X_LBelow = X_LGround(state.measured(), resting);
  if (X_LBelow) return X_LBelow;
  for (std::size_t s = 0; s < state.support_count(); ++s) {
    const Placed<Plate>& plate = state.support(s).plate;
    const Vector3 p_S = plate.X_FS.inverse(Eigen::Isometry) * X_LO.translation();
    if (p_S.z() < 0 || !Contains(plate.shape.outline, p_S.head<2>())) continue;
    const bool is_higher = !X_LBelow || plate.X_FS.translation().z() > X_LBelow->translation().z();
    if (is_higher) X_LBelow = plate.X_FS;
  }
  return X_LBelow;
}

// Nobody asks what is behind a wall or a front, so that they hide nothing.
void FindHidden(const SceneState& state, const Work& work, std::vector<MeshedObject>& meshed) {
  const std::vector<SolidOfObject> solids = SolidsOf(meshed);
  ParallelFor(meshed.size(), 1, work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const ObjectHypothesis& hypothesis = *state.hypotheses()[k];
      if (!hypothesis.plates.empty()) continue;
      std::vector<float> sigma_m;
      for (const std::uint32_t i : hypothesis.points) sigma_m.push_back(state.points().sigma_m[i]);
      FindHiddenDepth(meshed[k].X_LO,
                      {.sight = state.sight() ? &*state.sight() : nullptr,
                       .X_LGround = GroundOf(state, hypothesis.resting, meshed[k].X_LO),
                       .tolerance_m = MaxJump_m(Median(std::move(sigma_m))),
                       .solids = solids,
                       .object = k},
                      meshed[k].model->shapes);
    }
  });
}

DetectedObject ObjectOf(const SceneState& state, const ObjectHypothesis& hypothesis,
                        MeshedObject meshed, const Pose& X_WL) {
  const Resting& resting = hypothesis.resting;
  return {.kind = hypothesis.IsObject() ? DetectedKind::kObject : DetectedKind::kResidual,
          .X_WO = X_WL * meshed.X_LO,
          .model = std::move(meshed.model),
          .supported_by = resting.support,
          .rests_on = resting.on ? static_cast<int>(state.IndexOf(*resting.on)) : -1,
          .points_L = hypothesis.model->thinned_L};
}

}  // namespace

void AssembleInterpretation(const SceneState& state, const AssembleOptions& options,
                            const Work& work, SceneInterpretation& result) {
  const auto hypotheses = state.hypotheses();
  std::vector<DescribedSupport> supports(state.support_count());
  std::vector<MeshedObject> meshed(hypotheses.size());
  // Supports may hold most of a room's points. They come first, so that none is left to one thread
  // at the end.
  ParallelFor(supports.size() + meshed.size(), 1, work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      if (k < supports.size()) {
        supports[k] = DescribeSupport(state.support(k), state.points(), options.X_WL, options.floor,
                                      options.surface, work);
      } else {
        const std::size_t h = k - supports.size();
        meshed[h] = MeshHypothesis(*hypotheses[h], state.points(), options.surface, work);
      }
    }
  });

  FindHidden(state, work, meshed);

  LabelSupports(state, work, result.labels);
  for (DescribedSupport& support : supports) {
    result.supports.push_back(std::move(support.support));
    result.report.points_explained += support.explained;
  }
  for (std::uint32_t k = 0; k < hypotheses.size(); ++k) {
    const ObjectHypothesis& hypothesis = *hypotheses[k];
    LabelObject(state, k, work, result.labels);
    result.report.points_explained += meshed[k].explained;
    result.objects.push_back(ObjectOf(state, hypothesis, std::move(meshed[k]), options.X_WL));
  }
  result.report.points_rejected += state.measured().rejected.size();
}

}  // namespace cwm::perception
