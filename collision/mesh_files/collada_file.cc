#include "collision/mesh_files/collada_file.h"

#include <array>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "collision/mesh_files/collada_geometry.h"
#include "collision/mesh_files/mesh_builder.h"
#include "collision/xml/xml_element.h"

namespace cwm::collision {
namespace {

using Affine = Eigen::Affine3d;

// chosen: far deeper than any part of a robot, far below what a thread's stack holds.
constexpr int kMaxNodeDepth = 100;
// chosen: after unfolding, with each node counted as often as it is used, a file may have this many
// elements plus one for each of its bytes. This many take some ten milliseconds to process; an
// element takes at least four bytes.
constexpr std::size_t kMaxFreeElements = 100'000;
constexpr std::size_t kMaxTransformBytes = 2048;  // 16 numbers of 25 characters take 400 bytes

class ColladaReader {
 public:
  ColladaReader(std::size_t bytes, const MeshFileLimits& limits)
      : max_triangles_(limits.max_triangles),
        max_elements_(kMaxFreeElements + bytes),
        mesh_(limits.max_triangles) {}

  absl::StatusOr<TriangleMesh> Read(const XmlElement& root) {
    if (root.tag() != "COLLADA") return root.Fault("must have the root element <COLLADA>");
    const absl::StatusOr<double> meter = ReadUnit(root);
    if (!meter.ok()) return meter.status();
    Index(root);
    const absl::StatusOr<XmlElement> scene = FindScene(root);
    if (!scene.ok()) return scene.status();
    const Affine X_FS(Eigen::Scaling(*meter));
    if (absl::Status status = AddChildren(*scene, X_FS, 1); !status.ok()) return status;
    return std::move(mesh_).Finish();
  }

 private:
  static absl::StatusOr<double> ReadUnit(const XmlElement& root) {
    for (const XmlElement& asset : root.Children("asset")) {
      for (const XmlElement& unit : asset.Children("unit")) {
        const absl::StatusOr<double> meter = unit.NumberOr("meter", 1);
        if (meter.ok() && !(*meter > 0)) return unit.FaultOf("meter", "must be positive");
        return meter;
      }
    }
    return 1.0;
  }

  // Indexes the elements that may be referred to by name: geometries, scenes, and nodes at any
  // depth. The recursion is as deep as the document, at most 100 (XmlDocument).
  void Index(const XmlElement& element) {
    for (const XmlElement& child : element.Children()) {
      const std::string_view tag = child.tag();
      const bool used = tag == "geometry" || tag == "visual_scene" || tag == "node";
      if (used && child.Has("id")) by_id_.emplace("#" + *child.Text("id"), child);
      if (tag == "library_geometries" || tag == "library_nodes" || tag == "node" ||
          tag == "library_visual_scenes" || tag == "visual_scene") {
        Index(child);
      }
    }
  }

  absl::StatusOr<XmlElement> Find(const XmlElement& instance, const char* tag) const {
    const absl::StatusOr<std::string> url =
        instance.Name("url");  // short, because it is looked up often
    if (!url.ok()) return url.status();
    const auto found = by_id_.find(*url);
    if (found != by_id_.end() && found->second.tag() == tag) return found->second;
    return instance.FaultOf("url", absl::StrCat("must be a <", tag, "> of the file"));
  }

  absl::StatusOr<XmlElement> FindScene(const XmlElement& root) const {
    const absl::StatusOr<XmlElement> scene = root.ExactlyOne("scene");
    if (!scene.ok()) return scene.status();
    const absl::StatusOr<XmlElement> instance = scene->ExactlyOne("instance_visual_scene");
    if (!instance.ok()) return instance.status();
    return Find(*instance, "visual_scene");
  }

  absl::Status AddNode(const XmlElement& node, const Affine& X_FP, int depth) {
    if (depth > kMaxNodeDepth)
      return node.Fault("nodes must not nest deeper than 100, nor in a circle");
    Affine X_FN = X_FP;
    const std::vector<XmlElement> children = node.Children();
    elements_ += 1 + children.size();
    if (elements_ > max_elements_) {
      return ExcessAt(node.place(),
                      absl::StrCat("nodes must not unfold to more than ", max_elements_,
                                   " elements, ", kMaxFreeElements, " and one for each byte"));
    }
    for (const XmlElement& child : children) {
      const absl::StatusOr<Affine> X = ReadTransform(child);
      if (!X.ok()) return X.status();
      X_FN = X_FN * *X;
    }
    return AddChildren(node, X_FN, depth);
  }

  absl::Status AddChildren(const XmlElement& node, const Affine& X_FN, int depth) {
    for (const XmlElement& child : node.Children()) {
      absl::Status status;
      if (child.tag() == "node") status = AddNode(child, X_FN, depth + 1);
      if (child.tag() == "instance_geometry") status = AddGeometry(child, X_FN);
      if (child.tag() == "instance_controller") status = child.Fault("skins are not understood");
      if (child.tag() == "instance_node") {
        const absl::StatusOr<XmlElement> used = Find(child, "node");
        status = used.ok() ? AddNode(*used, X_FN, depth + 1) : used.status();
      }
      if (!status.ok()) return status;
    }
    return absl::OkStatus();
  }

  // The identity for an element that is not a transform.
  static absl::StatusOr<Affine> ReadTransform(const XmlElement& element) {
    static const std::map<std::string_view, std::size_t> kNumbers = {
        {"matrix", 16}, {"translate", 3}, {"rotate", 4}, {"scale", 3}};
    const std::string_view tag = element.tag();
    if (tag == "lookat" || tag == "skew") return element.Fault("is not understood");
    const auto count = kNumbers.find(tag);
    if (count == kNumbers.end()) return Affine::Identity();
    const absl::StatusOr<std::string_view> content = element.Content();
    if (content.ok() && content->size() > kMaxTransformBytes) {
      return element.Fault(absl::StrCat("is ", content->size(), " bytes long, must be at most ",
                                        kMaxTransformBytes));
    }
    const absl::StatusOr<std::vector<double>> numbers = ReadNumbers(element);
    if (!numbers.ok()) return numbers.status();
    const std::vector<double>& n = *numbers;
    if (n.size() != count->second) {
      return element.Fault(absl::StrCat("must hold ", count->second, " numbers"));
    }
    if (tag == "translate") return Affine(Eigen::Translation3d(n[0], n[1], n[2]));
    if (tag == "scale") return Affine(Eigen::Scaling(n[0], n[1], n[2]));
    if (tag == "rotate") {
      constexpr double kDegree_rad = std::numbers::pi / 180;
      const Vector3 axis = Vector3(n[0], n[1], n[2]).stableNormalized();
      if (!(axis.norm() > 0.5)) return element.Fault("must have an axis of positive length");
      return Affine(Eigen::AngleAxisd(n[3] * kDegree_rad, axis));
    }
    Affine X = Affine::Identity();  // row-major; the last row is 0 0 0 1
    X.affine() = Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(n.data());
    return X;
  }

  absl::Status AddGeometry(const XmlElement& instance, const Affine& X_FN) {
    const absl::StatusOr<const ColladaGeometry*> geometry = GeometryOf(instance);
    if (!geometry.ok()) return geometry.status();
    if (absl::Status room = mesh_.CheckCapacity((*geometry)->size()); !room.ok()) return room;
    const bool is_mirrored = X_FN.linear().determinant() < 0;
    for (std::array<Vector3, 3> corners : **geometry) {
      for (Vector3& corner : corners) corner = X_FN * corner;
      if (is_mirrored) std::swap(corners[1], corners[2]);
      if (absl::Status status = mesh_.Add(corners); !status.ok()) return status;
    }
    return absl::OkStatus();
  }

  absl::StatusOr<const ColladaGeometry*> GeometryOf(const XmlElement& instance) {
    const absl::StatusOr<XmlElement> element = Find(instance, "geometry");
    if (!element.ok()) return element.status();
    std::optional<ColladaGeometry>& geometry = geometries_[*instance.Text("url")];
    if (!geometry.has_value()) {
      absl::StatusOr<ColladaGeometry> read =
          ReadColladaGeometry(*element, max_triangles_, triangulator_);
      if (!read.ok()) return read.status();
      geometry = *std::move(read);
    }
    return &*geometry;
  }

  std::size_t max_triangles_;
  std::size_t max_elements_;
  MeshBuilder mesh_;
  PolygonTriangulator triangulator_;
  std::size_t elements_ = 0;                 // of the nodes visited, each as often as it is used
  std::map<std::string, XmlElement> by_id_;  // keys begin with "#"
  std::map<std::string, std::optional<ColladaGeometry>> geometries_;
};

}  // namespace

absl::StatusOr<TriangleMesh> ReadCollada(std::string_view bytes, const MeshFileLimits& limits) {
  const absl::StatusOr<XmlDocument> document =
      XmlDocument::Parse(bytes, "Collada", limits.max_collada_bytes);
  if (!document.ok()) return document.status();
  return ColladaReader(bytes.size(), limits).Read(document->root());
}

absl::StatusOr<UpAxis> ColladaUpAxis(std::string_view bytes, const MeshFileLimits& limits) {
  const absl::StatusOr<XmlDocument> document =
      XmlDocument::Parse(bytes, "Collada", limits.max_collada_bytes);
  if (!document.ok()) return document.status();
  for (const XmlElement& asset : document->root().Children("asset")) {
    for (const XmlElement& element : asset.Children("up_axis")) {
      const absl::StatusOr<std::string_view> content = element.Content();
      if (!content.ok()) return content.status();
      const absl::string_view axis = absl::StripAsciiWhitespace({content->data(), content->size()});
      if (axis == "X_UP") return UpAxis::kX;
      if (axis == "Y_UP") return UpAxis::kY;
      if (axis == "Z_UP") return UpAxis::kZ;
      return element.Fault(absl::StrCat("holds ", Quoted({axis.data(), axis.size()}),
                                        ", must be X_UP, Y_UP or Z_UP"));
    }
  }
  return UpAxis::kY;
}

}  // namespace cwm::collision
