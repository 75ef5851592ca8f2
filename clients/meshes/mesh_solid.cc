#include "clients/meshes/mesh_solid.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"

namespace cwm::meshes {
namespace {

// "a hole of 9.0 mm" or "2 holes, the largest 9.0 mm".
std::string HolesText(std::size_t count, double largest_m) {
  const std::string size = absl::StrFormat("%.1f mm", 1e3 * largest_m);
  return count == 1 ? absl::StrCat("a hole of ", size)
                    : absl::StrCat(count, " holes, the largest ", size);
}

std::string ClosedText(const ClosedMesh& closed) {
  std::vector<std::string> mended;
  const auto add = [&](std::size_t count, const char* one, const char* many) {
    if (count > 0) mended.push_back(count == 1 ? one : absl::StrCat(count, many));
  };
  add(closed.repeated, "a repeated triangle left out", " repeated triangles left out");
  add(closed.split_edges, "an edge split at vertices on it", " edges split at vertices on them");
  std::string text = "closed";
  if (!mended.empty()) absl::StrAppend(&text, " (", absl::StrJoin(mended, ", "), ")");
  if (closed.caps.empty()) return text;
  const auto largest = std::ranges::max_element(closed.caps, {}, &MeshCap::diameter_m);
  const char* const by = closed.caps.size() == 1 ? " by a cap of " : " by caps of ";
  return absl::StrCat(text, by, HolesText(closed.caps.size(), largest->diameter_m));
}

std::string OpenText(const MeshOpening& opening) {
  if (opening.holes == 0) {
    return absl::StrCat("open: ", opening.edges, " edges with a triangle on one side only");
  }
  return absl::StrCat("open: ", HolesText(opening.holes, opening.largest_m),
                      absl::StrFormat(", %.2g %% of its area", 100 * opening.area_share));
}

}  // namespace

MeshSolid DescribeSolid(const TriangleMesh& mesh) {
  if (IsWatertight(mesh)) return {.text = "closed"};
  const MeshClosing closing = TryClose(mesh);
  if (!closing.closed) return {.is_open = true, .text = OpenText(closing.opening)};
  return {.has_caps = !closing.closed->caps.empty(), .text = ClosedText(*closing.closed)};
}

}  // namespace cwm::meshes
