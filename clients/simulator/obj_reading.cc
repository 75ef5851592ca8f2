#include <algorithm>
#include <array>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "clients/simulator/mesh_formats.h"
#include "clients/simulator/text_lines.h"

namespace cwm::simulator {
namespace {

using formats::MeshFile;
using Words = std::vector<std::string_view>;

// Keys that say nothing about the surface as a set of triangles.
constexpr std::array<std::string_view, 13> kLeftOut = {
    "vn", "vt",     "vp",     "o",      "g",      "s",         "l",
    "p",  "usemtl", "mtllib", "usemap", "maplib", "shadow_obj"};

// "7", "7/1", "7//3", "7/1/3", "-1": the first number, as an index from 0.
absl::StatusOr<std::uint32_t> ReadIndex(std::string_view word, const MeshFile& mesh,
                                        const TextLines& lines) {
  const std::string_view first = word.substr(0, word.find('/'));
  const auto count = static_cast<std::int64_t>(mesh.vertices.size());
  std::int64_t index = 0;
  const bool good = absl::SimpleAtoi(absl::string_view(first.data(), first.size()), &index) &&
                    index != 0 && index <= count && index >= -count;
  if (!good) {
    return lines.Error("f", word, absl::StrCat("must name one of the ", count, " vertices so far"));
  }
  return static_cast<std::uint32_t>(index > 0 ? index - 1 : count + index);
}

absl::Status AddFace(const Words& words, const TextLines& lines, MeshFile& mesh) {
  if (words.size() < 4) return lines.Error("f", "", "must have at least three vertices");
  std::vector<std::uint32_t> corners;
  for (std::size_t i = 1; i < words.size(); ++i) {
    const auto index = ReadIndex(words[i], mesh, lines);
    if (!index.ok()) return index.status();
    corners.push_back(*index);
  }
  for (std::size_t i = 2; i < corners.size(); ++i) {
    mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<MeshFile> ParseObj(std::string_view bytes, const std::string& file) {
  TextLines lines(bytes, file);
  MeshFile mesh;
  for (auto words = lines.Next(); words; words = lines.Next()) {
    const std::string_view key = words->front();
    if (key.front() == '#') continue;
    if (key == "v") {
      const auto point = lines.ReadPoint(*words);
      if (!point.ok()) return point.status();
      mesh.vertices.push_back(*point);
    } else if (key == "f") {
      if (absl::Status status = AddFace(*words, lines, mesh); !status.ok()) return status;
    } else if (std::find(kLeftOut.begin(), kLeftOut.end(), key) == kLeftOut.end()) {
      return lines.Error("the word", key, "begins no line of an OBJ mesh that is read here");
    }
  }
  return mesh;
}

}  // namespace cwm::simulator
