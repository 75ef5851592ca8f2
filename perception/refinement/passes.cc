#include "perception/refinement/passes.h"

#include <memory>

#include "perception/refinement/attach/attach_handles.h"
#include "perception/refinement/attach/attach_spouts.h"
#include "perception/refinement/merge/merge_occluded_parts.h"
#include "perception/refinement/merge/merge_tray_walls.h"
#include "perception/refinement/merge/merge_vessel_walls.h"
#include "perception/refinement/reassign/reassign_points.h"
#include "perception/refinement/reassign/return_handles.h"
#include "perception/refinement/split/split_false_handles.h"
#include "perception/refinement/split/split_stacked_boxes.h"
#include "perception/refinement/split/split_stacked_rounds.h"
#include "perception/refinement/split/split_standing_solids.h"

namespace cwm::perception {
namespace {

template <class... Pass>
Passes Make() {
  Passes passes;
  (passes.push_back(std::make_unique<const Pass>()), ...);
  return passes;
}

}  // namespace

const Passes& RefinementPasses() {
  static const Passes passes =
      Make<MergeVesselWalls, ReturnHandles, MergeOccludedParts, ReassignPoints, SplitStackedRounds,
           SplitStandingSolids, SplitStackedBoxes, SplitFalseHandles, MergeTrayWalls>();
  return passes;
}

std::vector<std::string> PassNames() {
  std::vector<std::string> names;
  const auto add = [&names](std::string_view name) { names.emplace_back(name); };
  add(kAttachHandles);
  add(kAttachSpouts);
  for (const auto& pass : RefinementPasses()) add(pass->Name());
  add(kCompleteBelow);
  add(kCutRims);
  return names;
}

}  // namespace cwm::perception
