#include "server/export/simulator_model.h"

#include <tinyxml2.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/geometry/tessellate.h"
#include "proto/transfer/sha256.h"
#include "server/core/error.h"
#include "server/export/file_bytes.h"
#include "server/export/notes.h"
#include "server/export/scene_numbers.h"

namespace cwm::server {
namespace {

using tinyxml2::XMLElement;

// derived: the box for a half-space in URDF, as in the meshes of tessellate.h.
constexpr double kGroundSide_m = 20, kGroundDepth_m = 1;

XMLElement& Child(XMLElement& parent, const char* name) {
  return *parent.InsertNewChildElement(name);
}
void SetText(XMLElement& parent, const char* name, const std::string& text) {
  Child(parent, name).SetText(text.c_str());
}

// Rotations about the fixed axes x, y, z, one after the other: R = Rz(yaw) Ry(pitch) Rx(roll).
Vector3 RollPitchYaw(const Matrix3& R) {
  const double cos_pitch = std::hypot(R(0, 0), R(1, 0));
  const double pitch = std::atan2(-R(2, 0), cos_pitch);
  // If x points straight up or down, roll and yaw rotate about the same axis: all of it is yaw.
  if (cos_pitch < 1e-9) return {0, pitch, std::atan2(-R(0, 1), R(1, 1))};
  return {std::atan2(R(2, 1), R(2, 2)), pitch, std::atan2(R(1, 0), R(0, 0))};
}

// Returns "x y z" and "roll pitch yaw".
std::pair<std::string, std::string> PoseTexts(const Pose& pose) {
  return {Text(pose.translation(), " "), Text(RollPitchYaw(pose.linear()), " ")};
}

// Binary STL. Facets have normals of length 0, so that readers compute them from the vertices.
std::string StlOf(const TriangleMesh& mesh) {
  constexpr std::size_t kHeaderBytes = 80;
  std::string bytes(kHeaderBytes, ' ');
  bytes.replace(0, 19, "binary STL, metres ");
  AppendBytes(static_cast<std::uint32_t>(mesh.triangles.size()), bytes);
  for (const auto& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) AppendBytes(0.0F, bytes);
    for (const std::uint32_t vertex : triangle) {
      for (const double coordinate : mesh.vertices[vertex]) {
        AppendBytes(static_cast<float>(coordinate), bytes);
      }
    }
    AppendBytes(std::uint16_t{0}, bytes);
  }
  return bytes;
}

// The mesh files, each distinct mesh once.
class MeshFiles {
 public:
  explicit MeshFiles(std::string folder) : folder_(std::move(folder)) {}

  // Returns the name of the mesh's file; `of` is the name of the object.
  std::string Add(const PlannerMesh& mesh, const std::string& of) {
    std::string& name = name_of_[mesh.get()];
    if (!name.empty()) return name;
    std::string bytes = StlOf(*mesh);
    const auto [same, is_new] = name_of_bytes_.try_emplace(Sha256Hex(bytes));
    kept_.push_back(mesh);  // keeps its address from being reused
    if (!is_new) return name = same->second;
    std::string safe = of;
    std::replace(safe.begin(), safe.end(), '/', '_');
    // The number distinguishes "a/b" from "a_b".
    name = absl::StrCat(folder_, "/", files_.size(), "_", safe, ".stl");
    files_.push_back({name, std::move(bytes)});
    return same->second = name;
  }

  std::vector<NamedFile> Take() { return std::move(files_); }

 private:
  std::string folder_;
  std::map<const TriangleMesh*, std::string> name_of_;
  std::map<std::string, std::string> name_of_bytes_;  // by digest
  std::vector<NamedFile> files_;
  std::vector<PlannerMesh> kept_;
};

// Converts cones to meshes, one for all cones of the same size, and adds warnings. Fails as
// documented in simulator_model.h.
absl::Status MeshCones(PlanningScene& scene, std::int64_t max_triangles) {
  std::map<std::pair<double, double>, PlannerMesh> mesh_of;  // by length and radius
  std::int64_t triangles = 0;
  Notes notes;
  for (PlannedObject& object : scene.objects) {
    for (PlannerShape& part : object.shapes) {
      const auto* cone = std::get_if<PlannerPrimitive>(&part.shape);
      if (cone != nullptr && cone->kind == PlannerPrimitive::Kind::kCone) {
        const double length_m = cone->dimensions_m[0], radius_m = cone->dimensions_m[1];
        PlannerMesh& mesh = mesh_of[{length_m, radius_m}];
        if (mesh == nullptr) {
          mesh = std::make_shared<const TriangleMesh>(Tessellate(
              Cone{.radius_bottom_m = radius_m, .radius_top_m = 0, .length_m = length_m}));
        }
        part.shape = mesh;
        notes.Add("a cone is written as a mesh", object.name);
      }
      const auto* mesh = std::get_if<PlannerMesh>(&part.shape);
      if (mesh == nullptr) continue;
      triangles += static_cast<std::int64_t>((*mesh)->triangles.size());
      if (triangles <= max_triangles) continue;
      return MakeError(absl::StatusCode::kResourceExhausted,
                       absl::StrCat("the meshes up to ", object.name, " have ", triangles,
                                    " triangles, must have at most ", max_triangles, " together"),
                       {.reason = "GEOMETRY_TOO_LARGE"});
    }
  }
  notes.AppendTo(scene.warnings);
  return absl::OkStatus();
}

// Writes <geometry> of one part. The formats differ in how they write numbers.
class GeometryWriter {
 public:
  enum class Format { kUrdf, kSdf };
  GeometryWriter(Format format, MeshFiles& meshes, const std::string& object)
      : format_(format), meshes_(meshes), object_(object) {}

  void Write(const PlannerShape& shape, XMLElement& parent) const {
    XMLElement& geometry = Child(parent, "geometry");
    std::visit([&](const auto& s) { WriteShape(s, geometry); }, shape.shape);
  }

 private:
  using Kind = PlannerPrimitive::Kind;

  void WriteShape(const PlannerPrimitive& s, XMLElement& geometry) const {
    const auto& d = s.dimensions_m;
    switch (s.kind) {
      case Kind::kBox:
        return Set(Child(geometry, "box"), {{"size", Text({d[0], d[1], d[2]}, " ")}});
      case Kind::kSphere:
        return Set(Child(geometry, "sphere"), {{"radius", NumberText(d[0])}});
      case Kind::kCylinder:
        return Set(Child(geometry, "cylinder"),
                   {{"radius", NumberText(d[1])}, {"length", NumberText(d[0])}});
      case Kind::kCone:
        assert(false);  // MeshCones has removed them
    }
  }
  void WriteShape(const PlannerMesh& mesh, XMLElement& geometry) const {
    const char* const key = format_ == Format::kUrdf ? "filename" : "uri";
    Set(Child(geometry, "mesh"), {{key, meshes_.Add(mesh, object_)}});
  }
  void WriteShape(const PlannerPlane&, XMLElement& geometry) const {
    if (format_ == Format::kUrdf) {
      return Set(Child(geometry, "box"),
                 {{"size", Text({kGroundSide_m, kGroundSide_m, kGroundDepth_m}, " ")}});
    }
    const std::string side = NumberText(kGroundSide_m);
    Set(Child(geometry, "plane"), {{"normal", "0 0 1"}, {"size", side + " " + side}});
  }

  void Set(XMLElement& element,
           const std::vector<std::pair<const char*, std::string>>& values) const {
    for (const auto& [name, value] : values) {
      if (format_ == Format::kUrdf) {
        element.SetAttribute(name, value.c_str());
      } else {
        SetText(element, name, value);
      }
    }
  }

  Format format_;
  MeshFiles& meshes_;
  const std::string& object_;
};

Pose PoseInUrdf(const PlannerShape& shape) {
  if (!std::holds_alternative<PlannerPlane>(shape.shape)) return shape.X_OS;
  return shape.X_OS * MakeTranslation(0, 0, -0.5 * kGroundDepth_m);
}

void AddOrigin(const Pose& pose, XMLElement& parent) {
  XMLElement& origin = Child(parent, "origin");
  const auto [xyz, rpy] = PoseTexts(pose);
  origin.SetAttribute("xyz", xyz.c_str());
  origin.SetAttribute("rpy", rpy.c_str());
}

void AddSdfPose(const Pose& pose, XMLElement& parent) {
  const auto [xyz, rpy] = PoseTexts(pose);
  SetText(parent, "pose", xyz + " " + rpy);
}

absl::Status AddUrdfObject(const PlannedObject& object, const std::string& root,
                           const CancellationCheck& check_cancelled, MeshFiles& meshes,
                           XMLElement& robot) {
  XMLElement& link = Child(robot, "link");
  link.SetAttribute("name", object.name.c_str());
  const GeometryWriter geometry(GeometryWriter::Format::kUrdf, meshes, object.name);
  for (const char* kind : {"visual", "collision"}) {
    for (const PlannerShape& shape : object.shapes) {
      XMLElement& part = Child(link, kind);
      AddOrigin(PoseInUrdf(shape), part);
      geometry.Write(shape, part);
      if (absl::Status status = check_cancelled(); !status.ok()) return status;
    }
  }
  XMLElement& joint = Child(robot, "joint");
  joint.SetAttribute("name", (object.name + "_stands").c_str());
  joint.SetAttribute("type", "fixed");
  AddOrigin(object.X_WO, joint);
  Child(joint, "parent").SetAttribute("link", root.c_str());
  Child(joint, "child").SetAttribute("link", object.name.c_str());
  return check_cancelled();
}

absl::Status AddSdfObject(const PlannedObject& object, const CancellationCheck& check_cancelled,
                          MeshFiles& meshes, XMLElement& world) {
  XMLElement& model = Child(world, "model");
  model.SetAttribute("name", object.name.c_str());
  SetText(model, "static", "true");
  AddSdfPose(object.X_WO, model);
  XMLElement& link = Child(model, "link");
  link.SetAttribute("name", "link");
  const GeometryWriter geometry(GeometryWriter::Format::kSdf, meshes, object.name);
  for (const char* kind : {"visual", "collision"}) {
    int number = 0;
    for (const PlannerShape& shape : object.shapes) {
      XMLElement& part = Child(link, kind);
      part.SetAttribute("name", absl::StrCat(kind, "_", number++).c_str());
      AddSdfPose(shape.X_OS, part);
      geometry.Write(shape, part);
      if (absl::Status status = check_cancelled(); !status.ok()) return status;
    }
  }
  return check_cancelled();
}

std::string RootName(const PlanningScene& scene) {
  std::string root = "world";
  const auto is_taken = [&](const PlannedObject& object) { return object.name == root; };
  while (std::any_of(scene.objects.begin(), scene.objects.end(), is_taken)) root += "_";
  return root;
}

// Reserved names of worlds and models; see "Reserved names" in SDFormat's specification of frame
// semantics.
bool IsReserved(const std::string& name) {
  return name == "world" || (name.size() >= 4 && name.starts_with("__") && name.ends_with("__"));
}

// Appends "_1" to reserved names, and again while the result is taken.
void KeepReservedNames(PlanningScene& scene) {
  if (IsReserved(scene.name)) scene.name += "_1";
  std::set<std::string> taken;
  for (const PlannedObject& object : scene.objects) taken.insert(object.name);
  for (PlannedObject& object : scene.objects) {
    if (!IsReserved(object.name)) continue;
    std::string name = object.name + "_1";
    while (!taken.insert(name).second) name += "_1";
    scene.warnings.push_back(
        absl::StrCat(object.name, ": written as ", name, ", its name is reserved"));
    object.name = name;
  }
}

std::vector<std::string> WarningsOf(const PlanningScene& scene, bool has_planes) {
  std::vector<std::string> warnings = scene.warnings;
  Notes notes;
  for (const PlannedObject& object : scene.objects) {
    for (const PlannerShape& shape : object.shapes) {
      if (!has_planes && std::holds_alternative<PlannerPlane>(shape.shape)) {
        notes.Add("a half-space ends after 10 m and 1 m below", object.name);
      }
    }
    if (object.attachment) notes.Add("stands free, a robot holds it", object.name);
  }
  notes.AppendTo(warnings);
  return warnings;
}

std::string FolderOf(const PlanningScene& scene) {
  std::string name = scene.name;
  std::replace(name.begin(), name.end(), '/', '_');
  return name + "_meshes";
}

// Prints the children of an element as they come and keeps only their text: a document with all of
// them takes ten times the memory, and printing it could not be interrupted.
class ModelText {
 public:
  // `depth` is the depth of the children of `parent`, which is in `document`.
  ModelText(tinyxml2::XMLDocument& document, XMLElement& parent, int depth)
      : document_(document), parent_(parent), depth_(depth) {}

  void PrintChildren() {
    for (auto* child = parent_.FirstChildElement(); child != nullptr;
         child = child->NextSiblingElement()) {
      tinyxml2::XMLPrinter printer(nullptr, false, depth_);
      child->Accept(&printer);
      absl::StrAppend(&children_, printer.CStr(), "\n");
    }
    parent_.DeleteChildren();
  }

  ModelFiles Files(MeshFiles& meshes, std::vector<std::string> warnings) {
    constexpr std::string_view kHere = "<!--children-->";  // unique: texts escape "<"
    parent_.InsertEndChild(document_.NewComment("children"));
    tinyxml2::XMLPrinter printer;
    document_.Print(&printer);
    const std::string_view around(printer.CStr());
    const std::size_t at = around.find(kHere);
    const std::size_t line = around.rfind('\n', at) + 1;
    const std::size_t next_line = at + kHere.size() + 1;
    std::string text = std::move(children_);
    text.insert(0, around.substr(0, line));
    text.append(around.substr(next_line));
    ModelFiles model{.files = {{"", std::move(text)}}, .warnings = std::move(warnings)};
    for (NamedFile& file : meshes.Take()) model.files.push_back(std::move(file));
    return model;
  }

 private:
  tinyxml2::XMLDocument& document_;
  XMLElement& parent_;
  const int depth_;
  std::string children_;
};

}  // namespace

absl::StatusOr<ModelFiles> FormatUrdf(PlanningScene scene, std::int64_t max_triangles,
                                      const CancellationCheck& check_cancelled) {
  if (absl::Status meshed = MeshCones(scene, max_triangles); !meshed.ok()) return meshed;
  tinyxml2::XMLDocument document;
  document.InsertEndChild(document.NewDeclaration());
  XMLElement* const robot = document.NewElement("robot");
  document.InsertEndChild(robot);
  robot->SetAttribute("name", scene.name.c_str());
  const std::string root = RootName(scene);
  Child(*robot, "link").SetAttribute("name", root.c_str());
  ModelText text(document, *robot, 1);
  MeshFiles meshes(FolderOf(scene));
  for (const PlannedObject& object : scene.objects) {
    const absl::Status added = AddUrdfObject(object, root, check_cancelled, meshes, *robot);
    if (!added.ok()) return added;
    text.PrintChildren();
  }
  text.PrintChildren();  // for a world without objects
  return text.Files(meshes, WarningsOf(scene, false));
}

absl::StatusOr<ModelFiles> FormatSdf(PlanningScene scene, std::int64_t max_triangles,
                                     const CancellationCheck& check_cancelled) {
  if (absl::Status meshed = MeshCones(scene, max_triangles); !meshed.ok()) return meshed;
  KeepReservedNames(scene);
  tinyxml2::XMLDocument document;
  document.InsertEndChild(document.NewDeclaration());
  XMLElement* const sdf = document.NewElement("sdf");
  document.InsertEndChild(sdf);
  sdf->SetAttribute("version", "1.7");
  XMLElement& world = Child(*sdf, "world");
  world.SetAttribute("name", scene.name.c_str());
  ModelText text(document, world, 2);
  MeshFiles meshes(FolderOf(scene));
  for (const PlannedObject& object : scene.objects) {
    if (absl::Status added = AddSdfObject(object, check_cancelled, meshes, world); !added.ok())
      return added;
    text.PrintChildren();
  }
  return text.Files(meshes, WarningsOf(scene, true));
}

}  // namespace cwm::server
