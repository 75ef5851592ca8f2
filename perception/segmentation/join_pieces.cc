#include "perception/segmentation/join_pieces.h"

#include <algorithm>
#include <map>
#include <utility>

#include "perception/cloud/tolerances.h"
#include "perception/segmentation/disjoint_sets.h"
#include "perception/segmentation/join_hidden.h"
#include "perception/segmentation/join_vessels.h"
#include "perception/segmentation/piece_summaries.h"

namespace cwm::perception {
namespace {

// chosen: the visible area of a handle or a knob of a tabletop object; checked on labelled Kinect
// scans.
constexpr double kAttachedPart_m2 = 25e-4;
// chosen: the largest area of a handle, as a share of the object's area; checked on the same scans.
constexpr double kAttachedShare = 0.2;
// chosen: the largest area of a knob, which may be at the foot, as a share of the object's area;
// checked on the same scans.
constexpr double kKnobShare = 0.08;

struct Neighbour {
  std::size_t piece = 0;
  int links = 0;
  float level = 0;
};

std::vector<std::size_t> SizesOfSets(DisjointSets& objects, std::size_t count) {
  std::vector<std::size_t> members(count, 0);
  for (std::size_t p = 0; p < count; ++p) ++members[objects.Root(p)];
  return members;
}

// Joins scraps and handles to their objects. A scrap joins the piece that it shares its longest
// border with. A small part on the side of an object, with nearly all of its border away from
// supports, is a handle; a part on top of an object rests there. A part of an object that was
// joined before stays as it is: it would join two objects. A patch that no vessel claimed counts as
// its support.
void JoinSmallParts(const PieceSummaries& views, std::int32_t support_count,
                    DisjointSets& objects) {
  std::vector<char> is_part(views.pieces.size());
  const std::vector<std::size_t> members = SizesOfSets(objects, views.pieces.size());
  for (std::size_t p = 0; p < is_part.size(); ++p) is_part[p] = members[objects.Root(p)] > 1;
  for (std::size_t p = 0; p < views.pieces.size(); ++p) {
    const PieceSummary& piece = views.pieces[p];
    if (is_part[p] || piece.is_patch || piece.sample.empty()) continue;
    if (piece.area_m2 > kAttachedPart_m2) continue;
    Neighbour best;
    int all = 0, to_support = 0;
    const auto id = static_cast<std::int32_t>(p);
    for (auto it = views.borders.lower_bound({id, 0}); it != views.borders.end(); ++it) {
      if (it->first.first != id) break;
      all += it->second.links;
      const auto other = static_cast<std::size_t>(it->first.second);
      const bool is_support = views.pieces[other].is_patch && !is_part[other];
      if (it->first.second < support_count || is_support) {
        to_support += it->second.links;
      } else if (it->second.links > best.links) {
        best = {other, it->second.links,
                it->second.level_links / static_cast<float>(it->second.links)};
      }
    }
    if (best.links == 0) continue;
    const bool scrap = piece.area_m2 <= kMinObjectArea_m2;
    const bool touches = AreInContact(views, p, best.piece);
    const bool attached = piece.area_m2 <= kAttachedShare * views.pieces[best.piece].area_m2 &&
                          all - to_support >= kNearlyAll * all && best.level < kLevelBorder_cos;
    const bool knob = piece.area_m2 <= kKnobShare * views.pieces[best.piece].area_m2 &&
                      best.links >= kMinSignificantShare * all;
    if (scrap || (touches && (attached || knob))) objects.Join(p, best.piece);
  }
}

// Returns patches that nothing claimed to their support, also sets of patches of one support.
void ReturnPatches(const Pieces& pieces, DisjointSets& objects) {
  const std::vector<std::size_t> members =
      SizesOfSets(objects, static_cast<std::size_t>(pieces.piece_count));
  std::map<std::pair<std::size_t, std::int32_t>, std::vector<std::size_t>> patches;
  for (const auto& [patch, support] : pieces.patch_of) {
    const auto p = static_cast<std::size_t>(patch);
    patches[{objects.Root(p), support}].push_back(p);
  }
  for (const auto& [set, alike] : patches) {
    const auto& [root, support] = set;
    if (alike.size() == members[root]) objects.Join(root, static_cast<std::size_t>(support));
  }
}

}  // namespace

Pieces JoinPieces(const SurfaceGraph& graph, Pieces pieces, const SightMap* sight,
                  const Work& work) {
  const auto count = static_cast<std::size_t>(pieces.piece_count);
  DisjointSets objects(count);
  const PieceSummaries views = SummarizePieces(graph, pieces, work);
  JoinVessels(graph.nodes(), views, objects);
  if (sight != nullptr) JoinAcrossOccluders(graph.nodes(), views, *sight, objects);
  JoinSmallParts(views, pieces.support_count, objects);
  ReturnPatches(pieces, objects);
  std::vector<std::int32_t> number(count);
  std::int32_t next = 0;
  for (std::size_t p = 0; p < count; ++p) {
    number[p] = objects.Root(p) == p ? next++ : number[objects.Root(p)];
  }
  for (std::int32_t& p : pieces.of_node) {
    if (p != kNoIndex) p = number[static_cast<std::size_t>(p)];
  }
  pieces.piece_count = next;
  pieces.patch_of.clear();
  return pieces;
}

}  // namespace cwm::perception
