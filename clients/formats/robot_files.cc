#include "clients/formats/robot_files.h"

#include <tinyxml2.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace cwm::formats {
namespace {

namespace fs = std::filesystem;
using tinyxml2::XMLElement;

constexpr std::string_view kPackage = "package://";
constexpr std::string_view kFile = "file://";
constexpr int kFoldersAbove = 3;
// chosen: workspaces nest repositories and stacks of packages, not much more.
constexpr int kMaxDepth = 5;

void AddUri(const XMLElement& collision, std::vector<std::string>& uris) {
  const XMLElement* geometry = collision.FirstChildElement("geometry");
  const XMLElement* mesh = geometry != nullptr ? geometry->FirstChildElement("mesh") : nullptr;
  const char* uri = mesh != nullptr ? mesh->Attribute("filename") : nullptr;
  if (uri == nullptr || std::find(uris.begin(), uris.end(), uri) != uris.end()) return;
  uris.emplace_back(uri);
}

std::vector<fs::path> PackageFolders(const RobotFolders& folders) {
  if (!folders.package_folders.empty()) {
    return {folders.package_folders.begin(), folders.package_folders.end()};
  }
  std::error_code unknown;  // then the path as given is used
  fs::path folder = fs::weakly_canonical(folders.urdf_folder, unknown);
  std::vector<fs::path> result = {folder};
  for (int i = 0; i < kFoldersAbove && folder.has_relative_path(); ++i) {
    folder = folder.parent_path();
    result.push_back(folder);
  }
  return result;
}

// True if the folder's name, or the name in its package.xml, is `package`: a checkout may have any
// name.
bool IsPackage(const fs::path& folder, std::string_view package) {
  std::error_code unknown;  // then the path as given is used
  if (fs::weakly_canonical(folder, unknown).filename() == package) return true;
  tinyxml2::XMLDocument document;
  if (document.LoadFile((folder / "package.xml").c_str()) != tinyxml2::XML_SUCCESS) return false;
  const XMLElement* root = document.RootElement();
  const XMLElement* name = root != nullptr ? root->FirstChildElement("name") : nullptr;
  const char* text = name != nullptr ? name->GetText() : nullptr;
  return text != nullptr && text == package;
}

// The first folder below this one, by path, whose package.xml has the name. Like catkin and colcon,
// the search does not enter packages.
std::optional<fs::path> PackageBelow(const fs::path& folder, std::string_view package,
                                     int depth = 0) {
  std::error_code unreadable;  // then the folder counts as empty
  std::vector<fs::path> folders;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, unreadable)) {
    const bool is_hidden = entry.path().filename().string().starts_with(".");
    if (!is_hidden && entry.is_directory(unreadable)) folders.push_back(entry.path());
  }
  std::ranges::sort(folders);
  for (const fs::path& below : folders) {
    const bool has_package = fs::exists(below / "package.xml", unreadable);
    if (has_package && IsPackage(below, package)) return below;
    if (has_package || depth >= kMaxDepth) continue;
    if (std::optional<fs::path> found = PackageBelow(below, package, depth + 1)) return found;
  }
  return std::nullopt;
}

std::vector<fs::path> CandidatesOf(std::string_view uri, const RobotFolders& folders) {
  if (uri.starts_with(kFile)) return {fs::path(uri.substr(kFile.size()))};
  if (!uri.starts_with(kPackage)) return {fs::path(folders.urdf_folder) / fs::path(uri)};
  std::string_view path = uri.substr(kPackage.size());
  path.remove_prefix(std::min(path.find_first_not_of('/'), path.size()));  // "package:///NAME"
  const std::string_view package = path.substr(0, path.find('/'));
  std::vector<fs::path> candidates;
  const bool has_rest = package.size() < path.size();
  const fs::path rest(has_rest ? path.substr(package.size() + 1) : std::string_view());
  for (const fs::path& folder : PackageFolders(folders)) {
    candidates.push_back(folder / fs::path(path));
    if (has_rest && IsPackage(folder, package)) candidates.push_back(folder / rest);
  }
  if (!has_rest) return candidates;
  // A checkout may lie deeper, below a folder of another name.
  for (const std::string& folder : folders.package_folders) {
    const std::optional<fs::path> found = PackageBelow(folder, package);
    if (found) candidates.push_back(*found / rest);
  }
  return candidates;
}

}  // namespace

std::vector<std::string> CollisionMeshUris(std::string_view urdf) {
  std::vector<std::string> uris;
  tinyxml2::XMLDocument document;
  if (document.Parse(urdf.data(), urdf.size()) != tinyxml2::XML_SUCCESS) return uris;
  const XMLElement* robot = document.RootElement();
  if (robot == nullptr) return uris;
  for (const XMLElement* link = robot->FirstChildElement("link"); link != nullptr;
       link = link->NextSiblingElement("link")) {
    for (const XMLElement* collision = link->FirstChildElement("collision"); collision != nullptr;
         collision = collision->NextSiblingElement("collision")) {
      AddUri(*collision, uris);
    }
  }
  return uris;
}

absl::StatusOr<std::string> FindMeshFile(std::string_view uri, const RobotFolders& folders) {
  const bool has_scheme = uri.find("://") != std::string_view::npos;
  if (has_scheme && !uri.starts_with(kFile) && !uri.starts_with(kPackage)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "mesh ", std::string(uri), " of the URDF must be at package://, at file:// or a path"));
  }
  const std::vector<fs::path> candidates = CandidatesOf(uri, folders);
  for (const fs::path& path : candidates) {
    std::error_code unreadable;  // an unreadable path counts as no file
    if (fs::is_regular_file(path, unreadable)) return path.string();
  }
  const std::string looked = absl::StrJoin(
      candidates, ", ",
      [](std::string* out, const fs::path& path) { absl::StrAppend(out, path.string()); });
  return absl::InvalidArgumentError(
      absl::StrCat("mesh ", std::string(uri), " of the URDF was not found, looked for ", looked));
}

}  // namespace cwm::formats
