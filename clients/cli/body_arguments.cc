#include "clients/cli/body_arguments.h"

#include <algorithm>
#include <istream>
#include <nlohmann/json.hpp>
#include <optional>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/number_list.h"
#include "clients/cli/place.h"
#include "clients/formats/scalar.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;
using Json = nlohmann::json;

// One body and the poses it is asked about.
struct Body {
  std::optional<pb::PlacedShape> shape;
  std::string object;  // without a shape
  std::vector<client::PoseRow> rows;

  // The same body, wherever it is.
  bool IsBodyOf(const Body& other) const {
    if (shape.has_value() != other.shape.has_value() || object != other.object) return false;
    return !shape || shape->SerializeAsString() == other.shape->SerializeAsString();
  }
};

pb::Subject ToSubject(const Body& body, std::size_t begin, std::size_t end) {
  const std::vector<client::PoseRow> rows(body.rows.begin() + static_cast<std::ptrdiff_t>(begin),
                                          body.rows.begin() + static_cast<std::ptrdiff_t>(end));
  pb::Subject subject;
  pb::PoseRows* poses = nullptr;
  if (body.shape) {
    *subject.mutable_shapes()->add_shapes() = *body.shape;
    poses = subject.mutable_shapes()->mutable_x_world_body();
  } else {
    subject.mutable_object()->set_name(body.object);
    poses = subject.mutable_object()->mutable_x_world_object();
  }
  poses->set_scalar(pb::SCALAR_F64);
  poses->set_data(client::RowBytes(rows));
  return subject;
}

std::vector<pb::Subject> Split(const std::vector<Body>& bodies) {
  std::vector<pb::Subject> subjects;
  for (const Body& body : bodies) {
    // An object without poses still asks for one row, its stored pose.
    std::size_t begin = 0;
    do {
      const std::size_t end = std::min(begin + kMaxRows, body.rows.size());
      subjects.push_back(ToSubject(body, begin, end));
      begin = end;
    } while (begin < body.rows.size());
  }
  return subjects;
}

absl::StatusOr<std::vector<double>> Numbers(const Json& value, const std::string& name) {
  const Json list = value.is_number() ? Json::array({value}) : value;
  std::vector<double> numbers;
  for (const Json& number : list) {
    if (!list.is_array() || !number.is_number()) {
      return absl::InvalidArgumentError(absl::StrCat(name, " must hold numbers alone"));
    }
    numbers.push_back(number.get<double>());
  }
  return numbers;
}

// A pose, or an array of poses.
absl::Status ReadPoses(const Json& at, std::vector<client::PoseRow>& rows) {
  const bool several = at.is_array() && !at.empty() && at.front().is_array();
  for (const Json& pose : several ? at : Json::array({at})) {
    const auto numbers = Numbers(pose, "\"at\"");
    if (!numbers.ok()) return numbers.status();
    const auto row = PoseFromNumbers(*numbers, "\"at\"");
    if (!row.ok()) return row.status();
    rows.push_back(*row);
  }
  return absl::OkStatus();
}

absl::Status ReadShape(const std::string& name, const Json& value, Body& body) {
  static const std::pair<const char*, std::string ShapeArguments::*> kShapes[] = {
      {"box", &ShapeArguments::box},
      {"sphere", &ShapeArguments::sphere},
      {"cylinder", &ShapeArguments::cylinder},
      {"cone", &ShapeArguments::cone},
      {"capsule", &ShapeArguments::capsule}};
  const auto known = std::find_if(std::begin(kShapes), std::end(kShapes),
                                  [&](const auto& shape) { return name == shape.first; });
  if (known == std::end(kShapes)) {
    return absl::InvalidArgumentError(
        absl::StrCat("\"", name,
                     "\" is unknown, must be at, object, box, sphere, cylinder, cone "
                     "or capsule"));
  }
  if (body.shape) return absl::InvalidArgumentError("only one shape a line");
  const auto numbers = Numbers(value, absl::StrCat("\"", name, "\""));
  if (!numbers.ok()) return numbers.status();
  ShapeArguments arguments;
  arguments.*known->second = absl::StrJoin(*numbers, ",", [](std::string* out, double number) {
    absl::StrAppend(out, formats::FormatNumber(number));
  });
  const auto shape = ToShape(arguments);
  if (!shape.ok()) return absl::InvalidArgumentError(shape.status().message());
  body.shape = *shape;
  return absl::OkStatus();
}

// One line over the body that the command line gave (none: the line must name one).
absl::Status ReadLine(const std::string& text, bool body_given, Body& body) {
  Json line = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (line.is_array() && body_given) line = Json{{"at", line}};
  if (!line.is_object()) return absl::InvalidArgumentError("must be a JSON object");
  for (const auto& [name, value] : line.items()) {
    absl::Status status;
    if (name == "at") {
      status = ReadPoses(value, body.rows);
    } else if (body_given) {
      status = absl::InvalidArgumentError(
          absl::StrCat("\"", name, "\" is not allowed: the command line has the shape already"));
    } else if (name == "object" && value.is_string()) {
      body.object = value.get<std::string>();
    } else {
      status = ReadShape(name, value, body);
    }
    if (!status.ok()) return status;
  }
  if (body.shape.has_value() == !body.object.empty()) {
    return absl::InvalidArgumentError("must name one shape or an object");
  }
  if (body.shape && body.rows.empty()) return absl::InvalidArgumentError("\"at\" is missing");
  return absl::OkStatus();
}

absl::StatusOr<std::vector<Body>> ReadLines(const std::optional<Body>& given, std::istream& in) {
  std::vector<Body> bodies;
  std::string text;
  for (int number = 1; std::getline(in, text); ++number) {
    if (text.find_first_not_of(" \t\r") == std::string::npos) continue;
    Body body = given.value_or(Body{});
    if (absl::Status status = ReadLine(text, given.has_value(), body); !status.ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat("stdin line ", number, ": ", std::string(status.message())));
    }
    const bool joins = !bodies.empty() && bodies.back().IsBodyOf(body) && !body.rows.empty() &&
                       !bodies.back().rows.empty();
    if (joins) {
      bodies.back().rows.insert(bodies.back().rows.end(), body.rows.begin(), body.rows.end());
    } else {
      bodies.push_back(std::move(body));
    }
  }
  if (bodies.empty())
    return absl::InvalidArgumentError("stdin holds no question: one JSON object a line");
  return bodies;
}

absl::StatusOr<std::vector<Body>> ReadBodies(const BodyArguments& arguments, Session& session) {
  const Streams& streams = session.streams;
  const bool has_shape = HasShape(arguments.shape);
  if (!has_shape && arguments.object.empty()) {
    if (streams.in_is_terminal || !arguments.at.empty()) {
      return UsageError("a shape (--box, --sphere, ...), --object NAME, or JSON lines on stdin");
    }
    return ReadLines(std::nullopt, streams.in);
  }
  Body body{.shape = {}, .object = arguments.object, .rows = {}};
  if (has_shape) {
    if (!arguments.object.empty()) return UsageError("--object: not together with a shape");
    const auto shape = ToShape(arguments.shape);
    if (!shape.ok()) return shape.status();
    body.shape = *shape;
  }
  if (has_shape && arguments.at.empty() && streams.in_is_terminal) {
    return UsageError("--at is missing: where the shape is, or JSON lines on stdin");
  }
  const bool on_stdin = arguments.at == std::vector<std::string>{"-"};
  if (on_stdin || (has_shape && arguments.at.empty())) return ReadLines(body, streams.in);
  for (const std::string& at : arguments.at) {
    const auto row = ParsePlace(session, at, "--at");
    if (!row.ok()) return row.status();
    body.rows.push_back(*row);
  }
  return std::vector<Body>{body};
}

}  // namespace

void AddBodyOptions(CLI::App& command, BodyArguments& body) {
  AddShapeOptions(command, body.shape);
  command.add_option("--object", body.object, "an object of the world, itself left out")
      ->type_name("NAME");
  command
      .add_option("--at", body.at,
                  "where it is, metres; may be repeated; \"-\": JSON lines on stdin")
      ->allow_extra_args(false)
      ->type_name(kPlaceForm);
}

absl::StatusOr<std::vector<pb::Subject>> ReadSubjects(const BodyArguments& body, Session& session) {
  const auto bodies = ReadBodies(body, session);
  if (!bodies.ok()) return bodies.status();
  return Split(*bodies);
}

std::size_t RowCount(const pb::Subject& subject) {
  constexpr std::size_t kRowBytes = sizeof(client::PoseRow);
  if (subject.has_shapes()) return subject.shapes().x_world_body().data().size() / kRowBytes;
  return std::max<std::size_t>(1, subject.object().x_world_object().data().size() / kRowBytes);
}

}  // namespace cwm::cli
