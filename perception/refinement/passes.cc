#include "perception/refinement/passes.h"

#include "perception/refinement/attach/attach_handles.h"
#include "perception/refinement/attach/attach_spouts.h"
#include "perception/refinement/merge/merge_occluded_parts.h"
#include "perception/refinement/merge/merge_tray_walls.h"
#include "perception/refinement/merge/merge_vessel_walls.h"
#include "perception/refinement/reassign/reassign_points.h"
#include "perception/refinement/reassign/return_handles.h"
#include "perception/refinement/split/split_rows.h"
#include "perception/refinement/split/split_stacked_boxes.h"
#include "perception/refinement/split/split_stacked_rounds.h"
#include "perception/refinement/split/split_standing_solids.h"

namespace cwm::perception {
const Passes& RefinementPasses() {
  static const Passes passes = [] {
    Passes made;
    made.push_back(MakeMergeVesselWalls());
    made.push_back(MakeReturnHandles());
    made.push_back(MakeMergeOccludedParts());
    made.push_back(MakeReassignPoints());
    made.push_back(MakeSplitStackedRounds());
    made.push_back(MakeSplitRows());
    made.push_back(MakeSplitStandingSolids());
    made.push_back(MakeSplitStackedBoxes());
    made.push_back(MakeMergeTrayWalls());
    return made;
  }();
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
