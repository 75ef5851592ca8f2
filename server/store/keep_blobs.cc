#include "server/store/keep_blobs.h"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>

#include <cmath>
#include <unordered_set>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "proto/transfer/mesh_bytes.h"
#include "proto/transfer/sha256.h"
#include "server/core/geometry_store.h"
#include "server/store/decode_fault.h"
#include "server/store/decode_values.h"
#include "server/store/encode_shapes.h"

namespace cwm::server {
namespace {

using MeshPtr = std::shared_ptr<const TriangleMesh>;

template <class Visit>
void ForEachMesh(const HybridModel& model, const Visit& visit) {
  for (const ShapePart& part : model.shapes) {
    if (const Mesh* const mesh = std::get_if<Mesh>(&part.shape)) visit(mesh->mesh);
    if (const Convex* const convex = std::get_if<Convex>(&part.shape)) visit(convex->hull);
  }
  for (const SurfacePart& part : model.surfaces) visit(part.surface.mesh);
  for (const Handle& handle : model.handles) visit(handle.surface.mesh);
}

// Stores files and remembers the first error.
class FileKeeper {
 public:
  explicit FileKeeper(Store& store) : store_(store) {}

  store::v1::BlobReference Keep(const std::string& bytes) {
    store::v1::BlobReference reference;
    reference.set_sha256(Sha256Hex(bytes));
    reference.set_bytes(static_cast<std::int64_t>(bytes.size()));
    status_.Update(store_.PutBlob(reference.sha256(), bytes, Durability::kDurable));
    return reference;
  }
  const absl::Status& status() const { return status_; }

 private:
  Store& store_;
  absl::Status status_;
};

// Equal lists have equal bytes.
std::string Serialized(const store::v1::RobotFiles& list) {
  std::string bytes;
  google::protobuf::io::StringOutputStream stream(&bytes);
  google::protobuf::io::CodedOutputStream output(&stream);
  output.SetSerializationDeterministic(true);
  list.SerializeToCodedStream(&output);
  output.Trim();
  return bytes;
}

void SetLinkValues(const collision::LinkValues& values,
                   google::protobuf::RepeatedPtrField<store::v1::LinkValue>* list) {
  for (const collision::LinkValue& value : values) {
    store::v1::LinkValue* const added = list->Add();
    added->set_link(value.link);
    added->set_value(value.value);
  }
}

absl::StatusOr<collision::LinkValues> DecodeLinkValues(
    const google::protobuf::RepeatedPtrField<store::v1::LinkValue>& list) {
  collision::LinkValues values;
  for (const store::v1::LinkValue& value : list) {
    if (!std::isfinite(value.value())) return Broken("link_values", "has a number not finite");
    values.push_back({.link = value.link(), .value = value.value()});
  }
  return values;
}

absl::StatusOr<collision::RobotSettings> DecodeSettings(const store::v1::RobotFiles& list) {
  collision::RobotSettings settings;
  auto padding_m = DecodeLinkValues(list.padding_m());
  if (!padding_m.ok()) return Within("padding_m", padding_m.status());
  auto scale = DecodeLinkValues(list.scale());
  if (!scale.ok()) return Within("scale", scale.status());
  settings.padding_m = *std::move(padding_m);
  settings.scale = *std::move(scale);
  for (const store::v1::Tool& tool : list.tools()) {
    absl::StatusOr<Pose> X_LT = DecodePose(tool.x_lt());
    if (!X_LT.ok()) return Within("tools.x_lt", X_LT.status());
    settings.tools.push_back(
        {.name = tool.name(), .link = tool.link(), .X_LT = *X_LT, .group = tool.group()});
  }
  return settings;
}

}  // namespace

absl::Status KeepGeometry(Store& store, std::span<const PreparedModelPtr> models,
                          Durability durability) {
  std::unordered_set<const TriangleMesh*> kept;  // objects may share a mesh
  absl::Status status;
  const auto keep = [&](const MeshPtr& mesh) {
    if (!status.ok() || mesh == nullptr || !IsBlob(*mesh)) return;
    if (!kept.insert(mesh.get()).second) return;
    const std::string hash = HashOf(mesh);
    if (!store.HasDurableBlob(hash)) status = store.PutBlob(hash, EncodeMesh(*mesh), durability);
  };
  for (const PreparedModelPtr& model : models) {
    if (model != nullptr) ForEachMesh(*model->model, keep);
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::StatusOr<std::string> KeepRobotFiles(Store& store, const RobotFiles& files) {
  FileKeeper keeper(store);
  store::v1::RobotFiles list;
  *list.mutable_urdf() = keeper.Keep(files.urdf);
  if (files.srdf) *list.mutable_srdf() = keeper.Keep(*files.srdf);
  if (files.spheres) *list.mutable_spheres() = keeper.Keep(*files.spheres);
  for (const auto& [uri, bytes] : files.meshes) (*list.mutable_meshes())[uri] = keeper.Keep(bytes);
  SetLinkValues(files.settings.padding_m, list.mutable_padding_m());
  SetLinkValues(files.settings.scale, list.mutable_scale());
  for (const collision::NamedTool& tool : files.settings.tools) {
    store::v1::Tool* const added = list.add_tools();
    added->set_name(tool.name);
    added->set_link(tool.link);
    *added->mutable_x_lt() = EncodePose(tool.X_LT);
    added->set_group(tool.group);
  }
  const std::string hash = keeper.Keep(Serialized(list)).sha256();
  if (!keeper.status().ok()) return keeper.status();
  return hash;
}

absl::StatusOr<RobotFiles> ReadRobotFiles(const Store& store, const std::string& files_hash) {
  const absl::StatusOr<std::string> bytes = store.GetBlob(files_hash);
  if (!bytes.ok()) return bytes.status();
  store::v1::RobotFiles list;
  if (!list.ParseFromString(*bytes)) return Broken("files", "must be a list of files");
  absl::Status status;
  const auto read = [&](const store::v1::BlobReference& blob) {
    absl::StatusOr<std::string> file = store.GetBlob(blob.sha256());
    status.Update(file.status());
    return file.ok() ? *std::move(file) : std::string();
  };
  RobotFiles files{.urdf = read(list.urdf()), .files_hash = files_hash};
  if (list.has_srdf()) files.srdf = read(list.srdf());
  if (list.has_spheres()) files.spheres = read(list.spheres());
  for (const auto& [uri, blob] : list.meshes()) files.meshes[uri] = read(blob);
  if (!status.ok()) return status;
  absl::StatusOr<collision::RobotSettings> settings = DecodeSettings(list);
  if (!settings.ok()) return settings.status();
  files.settings = *std::move(settings);
  return files;
}

}  // namespace cwm::server
