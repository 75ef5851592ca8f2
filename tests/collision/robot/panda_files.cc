#include "tests/collision/robot/panda_files.h"

#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/support/outside_data.h"

namespace cwm::collision::testing {
namespace {

std::string BytesOf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

}  // namespace

std::optional<PandaFiles> ReadPandaFiles() {
  const auto folder = cwm::testing::OutsideData("motion_bench_maker/panda");
  if (!folder.has_value()) return std::nullopt;
  const std::filesystem::path path = *folder;
  PandaFiles files{.urdf = BytesOf(path / "panda.urdf"),
                   .srdf = BytesOf(path / "panda.srdf"),
                   .spherized_urdf = BytesOf(path / "panda_spherized.urdf"),
                   .meshes = {}};
  files.meshes = [path](std::string_view uri) -> absl::StatusOr<std::string> {
    const std::string kPackage = "package://";
    const std::filesystem::path mesh = path / uri.substr(kPackage.size());
    if (!uri.starts_with(kPackage) || !std::filesystem::exists(mesh)) {
      return absl::NotFoundError("must be a file of the package");
    }
    return BytesOf(mesh);
  };
  return files;
}

}  // namespace cwm::collision::testing
