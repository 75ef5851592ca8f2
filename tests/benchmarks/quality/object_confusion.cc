#include "tests/benchmarks/quality/object_confusion.h"

#include <cstddef>
#include <map>

namespace cwm::benchmarks {
namespace {

// True objects with fewer points are hardly visible: people would not agree on their outline.
constexpr std::size_t kMinPoints = 300;

}  // namespace

std::vector<std::uint32_t> TrueLabelsOf(const SimulatedCase& run) {
  const auto& objects = run.simulated.scene.objects;
  std::vector<std::size_t> points(objects.size(), 0);
  for (const std::int32_t object : run.scan.object) {
    if (object >= 0) ++points[static_cast<std::size_t>(object)];
  }
  std::vector<std::uint32_t> label_of(objects.size(), 0);
  for (std::size_t k = 0; k < objects.size(); ++k) {
    if (objects[k].is_support) {
      label_of[k] = 1;
    } else if (!IsFurniture(objects[k]) && points[k] >= kMinPoints) {
      label_of[k] = static_cast<std::uint32_t>(10 * (k + 2));
    }
  }
  std::vector<double> top_m;
  for (const perception::SimulatedObject& object : objects) {
    top_m.push_back(perception::BoundsInWorld(object).max().z());
  }
  std::vector<std::uint32_t> labels(run.scan.object.size(), 0);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const std::int32_t object = run.scan.object[i];
    if (object < 0) continue;
    const auto k = static_cast<std::size_t>(object);
    const Vector3 p_C = run.scan.cloud.points[i].cast<double>();
    const double off_m = perception::ExplainedWithin_m(run.noise.AxialSigma_m(p_C.z()));
    const bool is_side =
        objects[k].is_support && (run.simulated.camera.X_WC * p_C).z() < top_m[k] - off_m;
    if (!is_side) labels[i] = label_of[k];
  }
  return labels;
}

std::vector<std::uint32_t> CountedLabels(const std::vector<std::uint32_t>& truth,
                                         std::vector<std::uint32_t> found) {
  std::map<std::uint32_t, std::ptrdiff_t> counted;  // points that count, less those that do not
  for (std::size_t i = 0; i < truth.size(); ++i) counted[found[i] / 10] += truth[i] != 0 ? 1 : -1;
  for (std::uint32_t& label : found) {
    if (label >= 10 && counted[label / 10] < 0) label = 0;
  }
  return found;
}

Confusion ConfusionOf(const std::vector<std::uint32_t>& truth,
                      const std::vector<std::uint32_t>& found) {
  constexpr double kHeld = 0.5, kPiece = 0.2;  // of a true object's points
  std::map<std::uint32_t, std::map<std::uint32_t, std::size_t>> shared;  // by true, by found
  std::map<std::uint32_t, std::size_t> points;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (truth[i] < 10) continue;
    ++points[truth[i]];
    if (found[i] >= 10) ++shared[truth[i]][found[i] / 10];
  }
  Confusion confusion;
  std::map<std::uint32_t, int> holds;  // the number of true objects by found object
  std::map<std::uint32_t, std::uint32_t> holder;
  for (const auto& [object, by_found] : shared) {
    int pieces = 0;
    for (const auto& [other, count] : by_found) {
      const double share = static_cast<double>(count) / static_cast<double>(points[object]);
      pieces += share >= kPiece;
      if (share >= kHeld) ++holds[other], holder[object] = other;
    }
    confusion.split += pieces > 1;
  }
  for (const auto& [object, other] : holder) {
    if (holds[other] < 2) continue;
    ++confusion.merged;
    confusion.merged_labels.push_back(object);
  }
  return confusion;
}

}  // namespace cwm::benchmarks
