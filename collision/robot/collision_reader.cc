#include "collision/robot/collision_reader.h"

#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "collision/geometry/mesh_closing.h"
#include "collision/geometry/validation.h"
#include "collision/mesh_files/mesh_file.h"

namespace cwm::collision {
namespace {

absl::StatusOr<Shape> ReadSphere(const XmlElement& element, double scale) {
  const absl::StatusOr<double> radius_m = element.Number("radius");
  if (!radius_m.ok()) return radius_m.status();
  return Sphere{scale * *radius_m};
}

absl::StatusOr<Shape> ReadBox(const XmlElement& element, double scale) {
  const absl::StatusOr<std::vector<double>> size_m = element.Numbers("size", 3);
  if (!size_m.ok()) return size_m.status();
  return Box{scale * Vector3((*size_m)[0], (*size_m)[1], (*size_m)[2])};
}

template <class S>  // Cylinder or Capsule
absl::StatusOr<Shape> ReadRound(const XmlElement& element, double scale) {
  const absl::StatusOr<double> radius_m = element.Number("radius");
  if (!radius_m.ok()) return radius_m.status();
  const absl::StatusOr<double> length_m = element.Number("length");
  if (!length_m.ok()) return length_m.status();
  return S{scale * *radius_m, scale * *length_m};
}

// The attribute from which a field of a shape was read.
const char* AttributeOf(const std::string& field) {
  if (field.starts_with("radius")) return "radius";
  if (field.starts_with("length")) return "length";
  return field.starts_with("size") ? "size" : "filename";
}

absl::Status CheckShape(const XmlElement& element, const Shape& shape) {
  const std::optional<Violation> violation = FindViolation(shape);
  if (!violation.has_value()) return absl::OkStatus();
  if (KindOf(shape) != ShapeKind::kMesh) {
    return element.FaultOf(AttributeOf(violation->field), violation->rule);
  }
  return element.FaultOf(
      "filename", absl::StrCat(violation->field, " is ", violation->value, ": ", violation->rule));
}

// The mesh of a file as a shape, scaled before it is closed.
Mesh Scaled(const std::shared_ptr<const TriangleMesh>& file, const Vector3& scale) {
  if (scale == Vector3::Ones()) return *SolidOf(file);
  TriangleMesh mesh = *file;
  for (Vector3& p : mesh.vertices) p = p.cwiseProduct(scale);
  if (scale.prod() < 0) {
    for (TriangleMesh::Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  }
  return *SolidOf(std::make_shared<const TriangleMesh>(std::move(mesh)));
}

std::string Message(const absl::Status& status) { return std::string(status.message()); }

// The error of a mesh file, at the element that names the file. Codes such as RESOURCE_EXHAUSTED
// and CANCELLED are kept.
absl::Status FileFault(const XmlElement& mesh, const absl::Status& status) {
  const absl::Status fault = mesh.FaultOf("filename", Message(status));
  return status.code() == absl::StatusCode::kNotFound
             ? fault
             : absl::Status(status.code(), fault.message());
}

}  // namespace

absl::StatusOr<Pose> ReadOrigin(const XmlElement& element) {
  const absl::StatusOr<std::optional<XmlElement>> origin = element.AtMostOne("origin");
  if (!origin.ok()) return origin.status();
  if (!origin->has_value()) return Pose::Identity();
  if ((*origin)->Has("quat_xyzw")) {  // ignoring it would misplace links
    return (*origin)->FaultOf("quat_xyzw", "is not understood, must be written as rpy");
  }
  const absl::StatusOr<Vector3> xyz_m = (*origin)->VectorOr("xyz", Vector3::Zero());
  if (!xyz_m.ok()) return xyz_m.status();
  if (xyz_m->cwiseAbs().maxCoeff() > kMaxCoordinate_m) {
    return (*origin)->FaultOf("xyz", "must be within 1e6 m of the origin");
  }
  const absl::StatusOr<Vector3> rpy_rad = (*origin)->VectorOr("rpy", Vector3::Zero());
  if (!rpy_rad.ok()) return rpy_rad.status();
  return MakePose(*xyz_m, Quaternion(Eigen::AngleAxisd(rpy_rad->z(), Vector3::UnitZ()) *
                                     Eigen::AngleAxisd(rpy_rad->y(), Vector3::UnitY()) *
                                     Eigen::AngleAxisd(rpy_rad->x(), Vector3::UnitX())));
}

absl::StatusOr<std::string> ExpandedName(const XmlElement& element, const char* attribute) {
  absl::StatusOr<std::string> name = element.Name(attribute);
  if (!name.ok()) return name;
  for (const char* begin : {"${", "$("}) {
    if (name->find(begin) == std::string::npos) continue;
    return element.FaultOf(attribute, "must be expanded by xacro before it is loaded");
  }
  return name;
}

absl::StatusOr<CollisionGeometry> CollisionReader::Read(const XmlElement& collision,
                                                        std::size_t before, double scale) {
  CollisionGeometry read;
  if (collision.Has("name") && !collision.Text("name")->empty()) {
    const absl::StatusOr<std::string> name = collision.Name("name");
    if (!name.ok()) return name.status();
    read.name = *name;
  }
  const absl::StatusOr<Pose> X_LG = ReadOrigin(collision);
  if (!X_LG.ok()) return X_LG.status();
  read.X_LG = *X_LG;
  const absl::StatusOr<XmlElement> geometry = collision.ExactlyOne("geometry");
  if (!geometry.ok()) return geometry.status();
  absl::StatusOr<Shape> shape = ReadShape(*geometry, scale);
  if (!shape.ok()) return shape.status();
  if (absl::Status status = budget_.TakeShape(*shape, before); !status.ok()) {
    return ExcessAt(collision.place(), Message(status));
  }
  read.shape = *std::move(shape);
  return read;
}

absl::StatusOr<Shape> CollisionReader::ReadShape(const XmlElement& geometry, double scale) {
  constexpr char kRule[] = "must have one element <box>, <cylinder>, <sphere>, <capsule> or <mesh>";
  const std::vector<XmlElement> children = geometry.Children();
  if (children.size() != 1) return geometry.Fault(kRule);
  const XmlElement& element = children.front();
  if (element.tag() == "mesh") return ReadMesh(element, scale);
  absl::StatusOr<Shape> shape = geometry.Fault(kRule);
  if (element.tag() == "sphere") shape = ReadSphere(element, scale);
  if (element.tag() == "box") shape = ReadBox(element, scale);
  if (element.tag() == "cylinder") shape = ReadRound<Cylinder>(element, scale);
  if (element.tag() == "capsule") shape = ReadRound<Capsule>(element, scale);
  if (!shape.ok()) return shape;
  if (absl::Status status = CheckShape(element, *shape); !status.ok()) return status;
  return shape;
}

absl::StatusOr<Shape> CollisionReader::ReadMesh(const XmlElement& element, double link_scale) {
  const absl::StatusOr<std::string> uri = ExpandedName(element, "filename");
  if (!uri.ok()) return uri.status();
  const absl::StatusOr<Vector3> scale = element.VectorOr("scale", Vector3::Ones());
  if (!scale.ok()) return scale.status();
  if ((scale->array() == 0).any()) return element.FaultOf("scale", "must not be 0 along any axis");
  const Vector3 total = link_scale * *scale;
  const Scale key = {total.x(), total.y(), total.z()};
  const auto known = meshes_.find({*uri, key});
  if (known != meshes_.end()) return Shape(known->second);
  const absl::StatusOr<std::shared_ptr<const TriangleMesh>> file = FileOf(element, *uri);
  if (!file.ok()) return file.status();
  const absl::Status few = CountTriangles(element, (*file)->triangles.size());
  if (!few.ok()) return few;
  if (absl::Status status = budget_.TakeTriangles((*file)->triangles.size()); !status.ok()) {
    return FileFault(element, status);
  }
  const Shape shape = Scaled(*file, total);
  if (absl::Status status = CheckShape(element, shape); !status.ok()) return status;
  meshes_.emplace(std::pair(*uri, key), std::get<Mesh>(shape));
  return shape;
}

absl::StatusOr<std::shared_ptr<const TriangleMesh>> CollisionReader::FileOf(
    const XmlElement& mesh, const std::string& uri) {
  std::shared_ptr<const TriangleMesh>& file = files_[uri];
  if (file != nullptr) return file;
  const absl::StatusOr<std::string> bytes = source_(uri);
  if (!bytes.ok()) return FileFault(mesh, bytes.status());
  budget_.AddFile(bytes->size());
  absl::StatusOr<TriangleMesh> read = ReadMeshFile(*bytes, uri, limits_.mesh_file);
  if (!read.ok()) return FileFault(mesh, read.status());
  file = std::make_shared<const TriangleMesh>(*std::move(read));
  return file;
}

absl::Status CollisionReader::CountTriangles(const XmlElement& mesh, std::size_t count) {
  triangles_ += count;
  if (triangles_ <= limits_.max_triangles) return absl::OkStatus();
  return FileFault(mesh, absl::ResourceExhaustedError(
                             absl::StrCat("the meshes of the robot must have at most ",
                                          limits_.max_triangles, " triangles together")));
}

}  // namespace cwm::collision
