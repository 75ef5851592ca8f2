// MoveIt's ".scene" format: a name, objects ("* id", since 2020 their pose, shapes with poses and
// colours, since 2020 subframes) and a line with a dot.
#include <algorithm>
#include <cstring>
#include <set>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "clients/formats/format_error.h"
#include "clients/formats/scalar.h"
#include "clients/formats/scene_shapes.h"
#include "clients/formats/scene_yaml.h"
#include "clients/formats/text_cursor.h"

namespace cwm::formats {
namespace {

class TextReader {
 public:
  TextReader(std::string_view text, const std::string& file)
      : text_(text), cursor_(text), file_(file) {}

  absl::StatusOr<SceneFile> Read() {
    cursor_.NextLine();  // skips the scene's name
    has_object_poses_ = FirstObjectHasPose();
    for (;;) {
      const auto marker = cursor_.NextWord();
      if (!marker) return Error("end of file", "", "must be a line with \".\"");
      if (*marker == ".") break;
      if (*marker != "*") {
        return Error("object", *marker, "must begin with \"*\", or \".\" must end the scene");
      }
      if (absl::Status status = ReadObject(); !status.ok()) return status;
    }
    if (!cursor_.OnlyPaddingLeft()) {
      return Error("end of file", "", "must come after the line with \".\"");
    }
    return std::move(scene_);
  }

 private:
  // True if the line after the first "* id" is a pose, which has several numbers; without poses it
  // has only the number of shapes.
  bool FirstObjectHasPose() const {
    TextCursor ahead(cursor_.rest());
    for (auto line = ahead.NextLine(); line; line = ahead.NextLine()) {
      const auto words = SplitWords(*line);
      if (words.empty() || words[0] != "*") continue;
      const auto next = ahead.NextLine();
      return next && SplitWords(*next).size() > 1;
    }
    return false;
  }

  absl::Status Error(const std::string& field, std::string_view value,
                     const std::string& rule) const {
    const std::string_view read = text_.substr(0, text_.size() - cursor_.rest().size());
    const auto line = 1 + std::count(read.begin(), read.end(), '\n');
    return FileError(file_, {absl::StrCat("line ", line, ": ", field), std::string(value), rule});
  }

  absl::Status ReadNumber(const std::string& field, double& value) {
    const auto word = cursor_.NextWord();
    if (!word) return Error(field, "", "is missing: the file ends here");
    if (const auto fault = ParseSceneNumber(*word, value)) return Error(field, *word, *fault);
    return absl::OkStatus();
  }

  template <std::size_t N>
  absl::Status ReadNumbers(const std::string& field, std::array<double, N>& values) {
    for (double& value : values) {
      if (absl::Status status = ReadNumber(field, value); !status.ok()) return status;
    }
    return absl::OkStatus();
  }

  // Reads a count that the rest of the file can hold with at least `bytes_each` per element.
  absl::Status ReadCount(const std::string& field, std::size_t bytes_each, std::uint32_t& count) {
    const auto word = cursor_.NextWord();
    if (!word) return Error(field, "", "is missing: the file ends here");
    char bytes[sizeof(std::uint32_t)];
    if (!ParseScalar(*word, Scalar::kU32, bytes)) return Error(field, *word, "must be a count");
    std::memcpy(&count, bytes, sizeof(bytes));
    if (count <= cursor_.rest().size() / bytes_each) return absl::OkStatus();
    return Error(field, *word, "must be no more than the rest of the file can hold");
  }

  absl::Status ReadPose(ScenePose& pose) {
    absl::Status status = ReadNumbers("position", pose.position_m);
    if (!status.ok()) return status;
    status = ReadNumbers("orientation", pose.orientation_xyzw);
    if (!status.ok()) return status;
    const auto fault = NormalizeQuaternion(pose.orientation_xyzw);
    return fault ? Error("orientation", "", *fault) : absl::OkStatus();
  }

  absl::Status ReadObject() {
    SceneObject object;
    const auto line = cursor_.NextLine();
    object.id = std::string(absl::StripAsciiWhitespace(
        line ? absl::string_view(line->data(), line->size()) : absl::string_view()));
    if (object.id.empty()) return Error("id", "", "must be a name");
    if (!ids_.insert(object.id).second) return Error("id", object.id, "must not appear twice");
    if (has_object_poses_) {
      if (absl::Status status = ReadPose(object.pose); !status.ok()) return status;
    }
    std::uint32_t shapes = 0;
    // The shortest shape is a sphere with its pose and colour: "sphere 1 0 0 0 0 0 0 1 0 0 0 0".
    if (absl::Status status = ReadCount("shapes", 20, shapes); !status.ok()) return status;
    for (std::uint32_t i = 0; i < shapes; ++i) {
      if (absl::Status status = ReadShape(object); !status.ok()) return status;
    }
    if (has_object_poses_) {
      if (absl::Status status = PassSubframes(); !status.ok()) return status;
    }
    if (object.shapes.empty()) {
      scene_.warnings.push_back(absl::StrCat(Printable(object.id), ": left out, it has no shapes"));
    } else {
      scene_.objects.push_back(std::move(object));
    }
    return absl::OkStatus();
  }

  absl::Status ReadShape(SceneObject& object) {
    const auto type = cursor_.NextWord();
    if (!type) return Error("shape", "", "is missing: the file ends here");
    SceneShape shape;
    const bool is_number = absl::ascii_isdigit(static_cast<unsigned char>((*type)[0]));
    const PrimitiveKind* kind = is_number ? nullptr : FindPrimitive(*type);
    absl::Status status;
    std::array<double, 4> plane = {};
    if (kind != nullptr) {
      status = ReadPrimitive(*kind, shape);
    } else if (*type == "plane") {
      status = ReadNumbers("plane", plane);
      if (status.ok() && plane[0] == 0 && plane[1] == 0 && plane[2] == 0) {
        status = Error("plane", "", "must have a normal that is not 0");
      }
    } else if (*type == "mesh") {
      status = ReadMesh(object.id, shape);
    } else {
      status = Error("shape", *type, "must be box, sphere, cylinder, cone, plane or mesh");
    }
    if (!status.ok()) return status;
    if (status = ReadPose(shape.pose); !status.ok()) return status;
    if (*type == "plane") {
      shape.pose = ComposePoses(shape.pose, PlaneFrame(plane));
      shape.shape = SceneHalfSpace{};
    }
    std::array<double, 4> color = {};
    if (status = ReadNumbers("color", color); !status.ok()) return status;
    object.shapes.push_back(std::move(shape));
    return absl::OkStatus();
  }

  // The radius comes before the length, unlike in shape_msgs/SolidPrimitive.
  absl::Status ReadPrimitive(const PrimitiveKind& kind, SceneShape& shape) {
    std::vector<double> dimensions(kind.dimension_count);
    for (double& dimension : dimensions) {
      if (absl::Status status = ReadNumber(kind.name, dimension); !status.ok()) return status;
      if (dimension <= 0) return Error(kind.name, FormatNumber(dimension), "must be positive");
    }
    if (dimensions.size() == 2) std::swap(dimensions[0], dimensions[1]);
    shape.shape = MakePrimitive(kind, dimensions);
    return absl::OkStatus();
  }

  absl::Status ReadMesh(const std::string& id, SceneShape& shape) {
    constexpr std::size_t kMinBytes = 6;  // "0 0 0\n"
    std::uint32_t vertices = 0, triangles = 0;
    absl::Status status = ReadCount("vertices", kMinBytes, vertices);
    if (!status.ok()) return status;
    status = ReadCount("triangles", kMinBytes, triangles);
    if (!status.ok()) return status;
    MeshFile mesh;
    mesh.vertices.resize(vertices);
    mesh.triangles.resize(triangles);
    for (auto& vertex : mesh.vertices) {
      if (status = ReadNumbers("vertex", vertex); !status.ok()) return status;
    }
    for (auto& triangle : mesh.triangles) {
      for (std::uint32_t& corner : triangle) {
        if (status = ReadCorner(vertices, corner); !status.ok()) return status;
      }
    }
    const std::size_t dropped = RemoveDegenerateTriangles(mesh);
    if (mesh.triangles.empty()) {
      return Error("mesh", "", "must hold a triangle of three different vertices");
    }
    if (dropped > 0) {
      scene_.warnings.push_back(absl::StrCat(Printable(id), ": ", dropped,
                                             " triangles that use a vertex twice are left out"));
    }
    shape.shape = std::move(mesh);
    return absl::OkStatus();
  }

  absl::Status ReadCorner(std::uint32_t vertices, std::uint32_t& corner) {
    const auto word = cursor_.NextWord();
    if (!word) return Error("triangle", "", "is missing: the file ends here");
    char bytes[sizeof(corner)];
    if (!ParseScalar(*word, Scalar::kU32, bytes)) {
      return Error("triangle", *word, "must be an index");
    }
    std::memcpy(&corner, bytes, sizeof(bytes));
    if (corner < vertices) return absl::OkStatus();
    return Error("triangle", *word, absl::StrCat("must be an index of ", vertices, " vertices"));
  }

  // Skips subframes, which are named frames and do not collide.
  absl::Status PassSubframes() {
    std::uint32_t count = 0;
    // The shortest subframe is "a 0 0 0 0 0 0 1".
    if (absl::Status status = ReadCount("subframes", 15, count); !status.ok()) return status;
    ScenePose pose;
    for (std::uint32_t i = 0; i < count; ++i) {
      if (!cursor_.NextWord()) return Error("subframe", "", "is missing: the file ends here");
      if (absl::Status status = ReadPose(pose); !status.ok()) return status;
    }
    return absl::OkStatus();
  }

  const std::string_view text_;
  TextCursor cursor_;
  const std::string& file_;
  bool has_object_poses_ = false;
  SceneFile scene_;
  std::set<std::string> ids_;
};

}  // namespace

absl::StatusOr<SceneFile> ParseTextScene(std::string_view text, const std::string& file) {
  return TextReader(text, file).Read();
}

}  // namespace cwm::formats
