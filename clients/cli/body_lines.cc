#include "clients/cli/body_lines.h"

#include <algorithm>
#include <istream>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "clients/cli/number_list.h"
#include "clients/formats/scalar.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;
using BodyJson = nlohmann::json;

absl::StatusOr<std::vector<double>> Numbers(const BodyJson& value, const std::string& name) {
  const BodyJson list = value.is_number() ? BodyJson::array({value}) : value;
  std::vector<double> numbers;
  for (const BodyJson& number : list) {
    if (!list.is_array() || !number.is_number()) {
      return absl::InvalidArgumentError(absl::StrCat(name, " must hold numbers alone"));
    }
    numbers.push_back(number.get<double>());
  }
  return numbers;
}

// Reads a row or an array of rows: poses of rigid bodies, states of robots.
absl::Status ReadRows(const std::string& name, const BodyJson& value, Body& body) {
  const std::string quoted = absl::StrCat("\"", name, "\"");
  const bool several = value.is_array() && !value.empty() && value.front().is_array();
  for (const BodyJson& row : several ? value : BodyJson::array({value})) {
    auto numbers = Numbers(row, quoted);
    if (!numbers.ok()) return numbers.status();
    if (name == "at") {
      const auto pose = PoseFromNumbers(*numbers, quoted);
      if (!pose.ok()) return pose.status();
      numbers->assign(pose->begin(), pose->end());
    }
    if (auto status = AppendRow(*numbers, quoted, body); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status ReadShape(const std::string& name, const BodyJson& value, Body& body) {
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
                     "\" is unknown, must be at, object, robot, group, joints, box, sphere, "
                     "cylinder, cone or capsule"));
  }
  if (body.subject.has_shapes()) return absl::InvalidArgumentError("only one shape a line");
  const auto numbers = Numbers(value, absl::StrCat("\"", name, "\""));
  if (!numbers.ok()) return numbers.status();
  ShapeArguments arguments;
  arguments.*known->second = absl::StrJoin(*numbers, ",", [](std::string* out, double number) {
    absl::StrAppend(out, formats::FormatNumber(number));
  });
  const auto shape = ParseShape(arguments);
  if (!shape.ok()) return absl::InvalidArgumentError(shape.status().message());
  *body.subject.mutable_shapes()->add_shapes() = *shape;
  return absl::OkStatus();
}

// The names by which a line can give its subject.
struct LineNames {
  std::string object, robot, group;
};

absl::Status SetBody(const LineNames& names, Body& body) {
  const int bodies = (body.subject.has_shapes() ? 1 : 0) + (names.object.empty() ? 0 : 1) +
                     (names.robot.empty() ? 0 : 1);
  if (bodies != 1) {
    return absl::InvalidArgumentError("must name one shape or an object or a robot");
  }
  if (!names.object.empty()) body.subject.mutable_object()->set_name(names.object);
  if (!names.robot.empty()) body.subject.mutable_robot()->set_robot(names.robot);
  if (!names.group.empty()) {
    if (names.robot.empty()) return absl::InvalidArgumentError("\"group\" is one of a robot");
    body.subject.mutable_robot()->set_group(names.group);
  }
  return absl::OkStatus();
}

// The name of the body's rows.
std::string RowsName(const Body& body) { return body.subject.has_robot() ? "joints" : "at"; }

// Reads a line into the body given on the command line; if there is none, the line must name one.
absl::Status ReadLine(const std::string& text, bool body_given, Body& body) {
  BodyJson line = BodyJson::parse(text, nullptr, /*allow_exceptions=*/false);
  if (line.is_array() && body_given) line = BodyJson{{RowsName(body), line}};
  if (!line.is_object()) return absl::InvalidArgumentError("must be a JSON object");
  LineNames names;
  std::optional<std::string> rows;
  for (const auto& [name, value] : line.items()) {
    absl::Status status;
    if (name == "at" || name == "joints") {
      if (rows) return absl::InvalidArgumentError("\"at\" and \"joints\" on one line");
      rows = name;
      status = ReadRows(name, value, body);
    } else if (body_given) {
      status = absl::InvalidArgumentError(
          absl::StrCat("\"", name, "\" is not allowed: the command line has the body already"));
    } else if (name == "object" && value.is_string()) {
      names.object = value.get<std::string>();
    } else if (name == "robot" && value.is_string()) {
      names.robot = value.get<std::string>();
    } else if (name == "group" && value.is_string()) {
      names.group = value.get<std::string>();
    } else {
      status = ReadShape(name, value, body);
    }
    if (!status.ok()) return status;
  }
  if (!body_given) {
    if (auto status = SetBody(names, body); !status.ok()) return status;
  }
  if (rows && *rows != RowsName(body)) {
    return absl::InvalidArgumentError(absl::StrCat("\"", *rows, "\" must be \"", RowsName(body),
                                                   "\": ", "what asks has such rows"));
  }
  if (body.subject.has_shapes() && !rows) return absl::InvalidArgumentError("\"at\" is missing");
  body.row_counts = {static_cast<int>(body.row_count())};
  return absl::OkStatus();
}

// True if `next` is the same subject with rows that can be appended.
bool Joins(const Body& last, const Body& next) {
  return last.row_count() > 0 && last.width == next.width &&
         last.subject.SerializeAsString() == next.subject.SerializeAsString();
}

}  // namespace

absl::Status AppendRow(const std::vector<double>& row, const std::string& name, Body& body) {
  if (row.empty() || (body.width != 0 && row.size() != body.width)) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, " has ", row.size(), " numbers, must have ",
                     body.width == 0 ? std::string("one for each joint")
                                     : absl::StrCat(body.width, " as the row before")));
  }
  body.width = row.size();
  body.numbers.insert(body.numbers.end(), row.begin(), row.end());
  return absl::OkStatus();
}

absl::StatusOr<std::vector<Body>> ReadBodyLines(const Body* given, std::istream& in) {
  std::vector<Body> bodies;
  std::string text;
  for (int number = 1; std::getline(in, text); ++number) {
    if (text.find_first_not_of(" \t\r") == std::string::npos) continue;
    Body body = given != nullptr ? *given : Body{};
    if (absl::Status status = ReadLine(text, given != nullptr, body); !status.ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat("stdin line ", number, ": ", std::string(status.message())));
    }
    if (bodies.empty() || !Joins(bodies.back(), body)) {
      bodies.push_back(std::move(body));
      continue;
    }
    Body& last = bodies.back();
    last.numbers.insert(last.numbers.end(), body.numbers.begin(), body.numbers.end());
    last.row_counts.push_back(body.row_counts.front());
  }
  if (bodies.empty()) {
    return absl::InvalidArgumentError("stdin holds no question: one JSON object a line");
  }
  return bodies;
}

}  // namespace cwm::cli
