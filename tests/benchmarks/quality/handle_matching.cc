#include "tests/benchmarks/quality/handle_matching.h"
#include "tests/benchmarks/quality/point_labels.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <utility>

namespace cwm::benchmarks {
namespace {

using Id = std::pair<std::int32_t, std::int32_t>;  // object and part, true or found

bool IsTrueHandle(const perception::SimulatedScene& scene, const Id& id) {
  return scene.objects[static_cast<std::size_t>(id.first)].RoleOf(
             static_cast<std::size_t>(id.second)) == perception::PieceRole::kHandle;
}

// True if the part label of an object belongs to a handle: handles come after the shapes.
bool IsFoundHandle(const HybridModel& model, std::size_t part) {
  return part > std::min(model.shapes.size(), kTellableParts - 1) && !model.handles.empty() &&
         part <= model.shapes.size() + model.handles.size();
}

struct Handles {
  std::map<Id, std::size_t> truth, found;
  std::map<std::pair<Id, Id>, std::size_t> shared;
};

Handles CountHandles(const InterpretedView& view) {
  Handles handles;
  for (std::size_t i = 0; i < view.scan.cloud.size(); ++i) {
    if (!view.scan.cloud.points[i].allFinite()) continue;
    const Id truth(view.scan.object[i], view.scan.part[i]);
    const bool is_true = truth.first >= 0 && IsTrueHandle(view.scene, truth);
    handles.truth[truth] += is_true;
    const std::uint32_t label = view.interpretation.labels[i];
    if (label < kFirstObjectLabel) continue;
    const std::uint32_t o = (label - kFirstObjectLabel) / kLabelsPerObject;
    const std::uint32_t part = label % kLabelsPerObject;
    if (!IsFoundHandle(*view.interpretation.objects[o].model, part)) continue;
    const Id found(static_cast<std::int32_t>(o), static_cast<std::int32_t>(part));
    ++handles.found[found];
    if (is_true) ++handles.shared[{truth, found}];
  }
  return handles;
}

std::string Describe(const std::string& scene, const char* what, const Id& id, std::size_t points,
                     double iou) {
  char text[160];
  std::snprintf(text, sizeof(text), "%s: %s of %zu points (object %d), best IoU %.2f",
                scene.c_str(), what, points, id.first, iou);
  return text;
}

double Ratio(int part, int whole) { return whole == 0 ? 1 : static_cast<double>(part) / whole; }

}  // namespace

double HandleTally::recall() const { return Ratio(found_count, true_count); }

double HandleTally::precision() const { return Ratio(right_count, reported_count); }

void AddHandles(const std::string& scene, const InterpretedView& view, HandleTally& tally) {
  const Handles handles = CountHandles(view);
  std::map<Id, double> best_of_truth, best_of_found;
  for (const auto& [pair, shared] : handles.shared) {
    const std::size_t all = handles.truth.at(pair.first) + handles.found.at(pair.second) - shared;
    const double iou = static_cast<double>(shared) / static_cast<double>(all);
    best_of_truth[pair.first] = std::max(best_of_truth[pair.first], iou);
    best_of_found[pair.second] = std::max(best_of_found[pair.second], iou);
  }
  for (const auto& [id, points] : handles.truth) {
    if (points < kCountedHandlePoints) continue;
    ++tally.true_count;
    const bool found = best_of_truth[id] >= kSameHandle_iou;
    tally.found_count += found;
    if (!found) {
      tally.failures.push_back(Describe(scene, "missed handle", id, points, best_of_truth[id]));
    }
  }
  for (const auto& [id, points] : handles.found) {
    ++tally.reported_count;
    const bool right = best_of_found[id] >= kSameHandle_iou;
    tally.right_count += right;
    if (!right) {
      tally.failures.push_back(Describe(scene, "invented handle", id, points, best_of_found[id]));
    }
  }
}

}  // namespace cwm::benchmarks
