#include "collision/mesh_files/glb_file.h"

#include <assimp/BaseImporter.h>
#include <assimp/importerdesc.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <array>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "collision/mesh_files/glb_guard.h"
#include "collision/mesh_files/mesh_builder.h"
#include "collision/xml/xml_element.h"

namespace cwm::collision {
namespace {

using Affine = Eigen::Affine3d;

absl::Status Fault(const std::string& rule) { return absl::InvalidArgumentError(rule); }

// One reader, however the bytes look.
constexpr char kImporter[] = "glTF2 Importer";

// There is no file but the one in memory.
class NoFiles : public Assimp::IOSystem {
 public:
  bool Exists(const char*) const override { return false; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char*, const char*) override { return nullptr; }
  void Close(Assimp::IOStream*) override {}
};

// assimp tries all its readers, some fifty, on bytes that the one for GLB does not know.
void KeepOnly(std::string_view name, Assimp::Importer& importer) {
  std::vector<Assimp::BaseImporter*> others;
  for (std::size_t i = 0; i < importer.GetImporterCount(); ++i) {
    if (std::string_view(importer.GetImporterInfo(i)->mName) != name) {
      others.push_back(importer.GetImporter(i));
    }
  }
  for (Assimp::BaseImporter* other : others) {
    importer.UnregisterLoader(other);
    delete other;  // it is the caller's from then on
  }
}

// Gathers the triangles of a scene.
class Collector {
 public:
  explicit Collector(const MeshFileLimits& limits) : mesh_(limits.max_triangles) {}

  // Recurses as deep as the nodes, which the guard bounds.
  absl::Status Add(const aiScene& scene, const aiNode& node, const Affine& X_FP) {
    const aiMatrix4x4& m = node.mTransformation;
    Affine X_PN;
    X_PN.matrix() << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4,  //
        m.c1, m.c2, m.c3, m.c4, 0, 0, 0, 1;
    const Affine X_FN = X_FP * X_PN;
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
      if (node.mMeshes[i] >= scene.mNumMeshes) return Fault("nodes must use meshes that there are");
      const aiMesh& mesh = *scene.mMeshes[node.mMeshes[i]];
      if (absl::Status status = Add(mesh, X_FN); !status.ok()) return status;
    }
    for (unsigned i = 0; i < node.mNumChildren; ++i) {
      if (absl::Status status = Add(scene, *node.mChildren[i], X_FN); !status.ok()) return status;
    }
    return absl::OkStatus();
  }

  absl::StatusOr<TriangleMesh> Finish() && { return std::move(mesh_).Finish(); }

 private:
  absl::Status Add(const aiMesh& mesh, const Affine& X_FN) {
    const bool is_mirrored = X_FN.linear().determinant() < 0;
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
      const aiFace& face = mesh.mFaces[i];
      if (face.mNumIndices != 3) continue;  // lines and points
      std::array<Vector3, 3> corners;
      for (int k = 0; k < 3; ++k) {
        const aiVector3D& v = mesh.mVertices[face.mIndices[k]];
        corners[k] = X_FN * Vector3(v.x, v.y, v.z);
      }
      if (is_mirrored) std::swap(corners[1], corners[2]);
      if (absl::Status status = mesh_.Add(corners); !status.ok()) return status;
    }
    return absl::OkStatus();
  }

  MeshBuilder mesh_;
};

// What the steps after reading rely on: faces of vertices that there are.
absl::Status CheckFaces(const aiScene& scene) {
  for (unsigned i = 0; i < scene.mNumMeshes; ++i) {
    const aiMesh& mesh = *scene.mMeshes[i];
    for (unsigned k = 0; k < mesh.mNumFaces; ++k) {
      const aiFace& face = mesh.mFaces[k];
      const bool known = std::all_of(face.mIndices, face.mIndices + face.mNumIndices,
                                     [&](unsigned v) { return v < mesh.mNumVertices; });
      if (!known) return Fault("faces must use vertices that there are");
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<TriangleMesh> Import(std::string_view bytes, const MeshFileLimits& limits) {
  Assimp::Importer importer;
  KeepOnly(kImporter, importer);
  importer.SetIOHandler(new NoFiles);  // the importer owns it
  const aiScene* scene = importer.ReadFileFromMemory(bytes.data(), bytes.size(), 0, "glb");
  if (scene == nullptr) {
    return Fault(absl::StrCat("malformed (", Quoted(importer.GetErrorString()), ")"));
  }
  if (absl::Status status = CheckFaces(*scene); !status.ok()) return status;
  scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
  if (scene == nullptr || scene->mRootNode == nullptr) return Fault("must have triangles");
  Collector collector(limits);
  const absl::Status status = collector.Add(*scene, *scene->mRootNode, Affine::Identity());
  if (!status.ok()) return status;
  return std::move(collector).Finish();
}

}  // namespace

absl::StatusOr<TriangleMesh> ReadGlb(std::string_view bytes, const MeshFileLimits& limits) {
  if (absl::Status status = GuardGlb(bytes, limits); !status.ok()) return status;
  try {  // assimp catches most of its own exceptions; the rest end here
    return Import(bytes, limits);
  } catch (const std::exception& error) {
    return Fault(absl::StrCat("malformed (", Quoted(error.what()), ")"));
  }
}

}  // namespace cwm::collision
