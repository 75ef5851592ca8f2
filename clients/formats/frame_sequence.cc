#include "clients/formats/frame_sequence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "clients/formats/file_bytes.h"
#include "clients/formats/format_error.h"
#include "clients/formats/pose_file.h"
#include "clients/formats/scalar.h"
#include "clients/formats/text_cursor.h"

namespace cwm::formats {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr const char* kFrameList = "frames.jsonl";
constexpr const char* kGravityFile = "gravity-direction.txt";
constexpr const char* kStateList = "joint_states.jsonl";
constexpr std::string_view kPoseForm = "must be X,Y,Z,QX,QY,QZ,QW";
// derived: nanoseconds since 1970 in 64 bits end there. Stamps in other units are far greater.
constexpr double kMaxTime_s = 9e9;
constexpr std::string_view kTimeRule =
    "must be a finite number of seconds, at most 9e9 in magnitude";

bool Exists(const fs::path& path) {
  std::error_code absent;
  return fs::exists(path, absent);
}

std::optional<double> FiniteNumber(std::string_view text) {
  double value = 0;
  if (!ParseScalar(text, Scalar::kF64, reinterpret_cast<char*>(&value)) || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

bool IsTime(double time_s) { return std::abs(time_s) <= kMaxTime_s; }

// Orders names with numbers by their values: frame2 before frame10.
bool NameLess(const fs::path& a, const fs::path& b) {
  const int order = strverscmp(a.filename().c_str(), b.filename().c_str());
  return order != 0 ? order < 0 : a < b;
}

bool HasEnding(const fs::path& path, std::initializer_list<std::string_view> endings) {
  const std::string extension = absl::AsciiStrToLower(path.extension().string());
  return std::find(endings.begin(), endings.end(), extension) != endings.end();
}

bool IsNamedDepth(const fs::path& path) { return absl::EndsWith(path.stem().string(), "depth"); }

absl::StatusOr<std::vector<fs::path>> FilesOf(const std::string& folder) {
  std::error_code error;
  std::vector<fs::path> files;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (it->is_regular_file(error)) files.push_back(it->path());
  }
  if (error) return absl::InvalidArgumentError(absl::StrCat(folder, ": ", error.message()));
  std::sort(files.begin(), files.end(), NameLess);
  return files;
}

std::vector<fs::path> FrameFiles(const std::vector<fs::path>& files) {
  std::vector<fs::path> depths, images, clouds;
  for (const fs::path& file : files) {
    if (HasEnding(file, {".png", ".npy"})) images.push_back(file);
    if (HasEnding(file, {".png", ".npy"}) && IsNamedDepth(file)) depths.push_back(file);
    if (HasEnding(file, {".pcd", ".ply"})) clouds.push_back(file);
  }
  if (!depths.empty()) return depths;
  return images.empty() ? clouds : images;
}

fs::path PoseFileOf(const fs::path& frame) {
  std::string stem = frame.stem().string();
  if (IsNamedDepth(frame)) {
    stem.resize(stem.size() - std::strlen("depth"));
  } else {
    stem += ".";
  }
  return frame.parent_path() / (stem + "pose.txt");
}

absl::StatusOr<ScenePose> ReadPoseFile(const fs::path& path) {
  const auto text = ReadFileBytes(path.string());
  if (!text.ok()) return text.status();
  return ParsePoseFile(*text, path.string());
}

// A line of a file of JSON objects.
class JsonLine {
 public:
  static absl::StatusOr<JsonLine> Parse(std::string_view line, const std::string& source) {
    Json object = Json::parse(line, nullptr, /*allow_exceptions=*/false);
    if (object.is_object()) return JsonLine(std::move(object), source);
    return FileError(source, {"the line", std::string(line), "must be a JSON object"});
  }

  absl::StatusOr<std::string> Text(const char* key) const {
    const auto found = object_.find(key);
    if (found == object_.end()) return FileError(source_, {key, "", "is missing"});
    if (found->is_string() && !found->get_ref<const std::string&>().empty()) {
      return found->get<std::string>();
    }
    return FileError(source_, {key, found->dump(), "must be a text"});
  }

  bool Has(const char* key) const { return object_.contains(key) && !object_[key].is_null(); }

  absl::StatusOr<double> Time(const char* key) const {
    const auto found = object_.find(key);
    if (found == object_.end()) return FileError(source_, {key, "", "is missing"});
    if (found->is_number() && IsTime(found->get<double>())) return found->get<double>();
    return FileError(source_, {key, found->dump(), std::string(kTimeRule)});
  }

  absl::StatusOr<std::vector<double>> Numbers(const char* key) const {
    const auto found = object_.find(key);
    if (found == object_.end()) return FileError(source_, {key, "", "is missing"});
    std::vector<double> numbers;
    for (const Json& item : *found) {
      if (!item.is_number() || !std::isfinite(item.get<double>())) {
        return FileError(source_, {key, item.dump(), "must be finite numbers"});
      }
      numbers.push_back(item.get<double>());
    }
    if (found->is_array() && !numbers.empty()) return numbers;
    return FileError(source_, {key, found->dump(), "must be a list of numbers"});
  }

  absl::StatusOr<std::vector<std::string>> Texts(const char* key) const {
    std::vector<std::string> texts;
    if (!object_[key].is_array()) {
      return FileError(source_, {key, object_[key].dump(), "must be a list of names"});
    }
    for (const Json& item : object_[key]) {
      if (!item.is_string()) return FileError(source_, {key, item.dump(), "must be names"});
      texts.push_back(item.get<std::string>());
    }
    return texts;
  }

  absl::StatusOr<ScenePose> Pose(const char* key) const {
    const auto numbers = Numbers(key);
    if (!numbers.ok()) return numbers.status();
    std::array<double, 7> row = {};
    if (numbers->size() == row.size()) {
      std::copy(numbers->begin(), numbers->end(), row.begin());
      if (const auto pose = PoseFromRow(row)) return *pose;
    }
    return FileError(source_, {key, object_[key].dump(), "must be [x, y, z, qx, qy, qz, qw]"});
  }

 private:
  JsonLine(Json object, std::string source)
      : object_(std::move(object)), source_(std::move(source)) {}

  Json object_;
  std::string source_;
};

absl::StatusOr<SequenceFrame> FrameOf(const JsonLine& line, const std::string& folder,
                                      const std::string& source) {
  const auto file = line.Text("file");
  if (!file.ok()) return file.status();
  SequenceFrame frame{.path = (fs::path(folder) / *file).string(), .source = source};
  const std::array<std::pair<const char*, std::optional<double>*>, 2> times = {
      {{"stamp", &frame.stamp_s}, {"delivery", &frame.delivery_s}}};
  for (const auto& [key, time] : times) {
    if (!line.Has(key)) continue;
    const auto number = line.Time(key);
    if (!number.ok()) return number.status();
    *time = *number;
  }
  if (line.Has("pose")) {
    const auto pose = line.Pose("pose");
    if (!pose.ok()) return pose.status();
    frame.x_world_sensor = *pose;
  }
  return frame;
}

absl::StatusOr<SequenceState> StateOf(const JsonLine& line, const std::string& source) {
  SequenceState state{.robot = {}, .source = source};
  const auto robot = line.Text("robot");
  const auto stamp_s = line.Time("stamp");
  const auto values = line.Numbers("values");
  for (const absl::Status& status : {robot.status(), stamp_s.status(), values.status()}) {
    if (!status.ok()) return status;
  }
  state.robot = *robot;
  state.stamp_s = state.delivery_s = *stamp_s;
  state.values = *values;
  if (line.Has("delivery")) {
    const auto delivery_s = line.Time("delivery");
    if (!delivery_s.ok()) return delivery_s.status();
    state.delivery_s = *delivery_s;
  }
  if (line.Has("joints")) {
    auto names = line.Texts("joints");
    if (!names.ok()) return names.status();
    if (names->size() != state.values.size()) {
      return FileError(source, {"values", absl::StrCat(state.values.size(), " numbers"),
                                absl::StrCat("must be one for each of ", names->size(), " names")});
    }
    state.variables = *std::move(names);
  }
  return state;
}

// Calls `take(line, source)`, which returns a Status, for each line with words.
template <class Take>
absl::Status ForEachLine(const fs::path& path, const Take& take) {
  const auto text = ReadFileBytes(path.string());
  if (!text.ok()) return text.status();
  TextCursor cursor(*text);
  for (int number = 1; const auto line = cursor.NextLine(); ++number) {
    if (SplitWords(*line).empty()) continue;
    absl::Status status = take(*line, absl::StrCat(path.string(), ":", number));
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status ReadFrameList(const fs::path& path, std::vector<SequenceFrame>& frames) {
  return ForEachLine(path, [&](std::string_view text, const std::string& source) {
    auto frame = ParseFrameLine(text, path.parent_path().string(), source);
    if (!frame.ok()) return frame.status();
    frames.push_back(**std::move(frame));
    return absl::OkStatus();
  });
}

absl::Status ReadStateList(const fs::path& path, std::vector<SequenceState>& states) {
  return ForEachLine(path, [&](std::string_view text, const std::string& source) {
    const auto line = JsonLine::Parse(text, source);
    if (!line.ok()) return line.status();
    auto state = StateOf(*line, source);
    if (!state.ok()) return state.status();
    states.push_back(*std::move(state));
    return absl::OkStatus();
  });
}

}  // namespace

std::string FindCameraFile(const std::string& folder) {
  for (const char* name :
       {"camera.json", "camera.yaml", "camera-intrinsics.txt", "intrinsics.txt"}) {
    const fs::path path = fs::path(folder) / name;
    if (Exists(path)) return path.string();
  }
  return "";
}

absl::StatusOr<std::optional<SequenceFrame>> ParseFrameLine(std::string_view line,
                                                            const std::string& folder,
                                                            const std::string& source) {
  const std::vector<std::string_view> words = SplitWords(line);
  if (words.empty()) return std::nullopt;
  if (words[0].front() == '{') {
    const auto object = JsonLine::Parse(line, source);
    if (!object.ok()) return object.status();
    auto frame = FrameOf(*object, folder, source);
    if (!frame.ok()) return frame.status();
    return *std::move(frame);
  }
  SequenceFrame frame{.path = (fs::path(folder) / std::string(words[0])).string(),
                      .source = source};
  if (words.size() > 1) {
    frame.stamp_s = FiniteNumber(words[1]);
    if (!frame.stamp_s || !IsTime(*frame.stamp_s)) {
      return FileError(source, {"the stamp", std::string(words[1]), std::string(kTimeRule)});
    }
  }
  if (words.size() > 3) {
    return FileError(source, {"the line", std::string(line), "must be FILE [STAMP [POSE]]"});
  }
  if (words.size() < 3) return frame;
  if (words[2].find(',') == std::string_view::npos) {
    const auto pose = ReadPoseFile(fs::path(folder) / std::string(words[2]));
    if (!pose.ok()) return pose.status();
    frame.x_world_sensor = *pose;
    return frame;
  }
  std::array<double, 7> row = {};
  const std::vector<std::string> numbers = absl::StrSplit(std::string(words[2]), ',');
  bool is_pose = numbers.size() == row.size();
  for (std::size_t i = 0; is_pose && i < row.size(); ++i) {
    const auto number = FiniteNumber(numbers[i]);
    is_pose = number.has_value();
    row[i] = number.value_or(0);
  }
  if (is_pose) frame.x_world_sensor = PoseFromRow(row);
  if (frame.x_world_sensor) return frame;
  return FileError(source, {"the pose", std::string(words[2]), std::string(kPoseForm)});
}

absl::StatusOr<FrameSequence> ReadFrameFolder(const std::string& folder) {
  FrameSequence sequence;
  if (const fs::path list = fs::path(folder) / kFrameList; Exists(list)) {
    absl::Status status = ReadFrameList(list, sequence.frames);
    for (const fs::path& place : {fs::path(folder), fs::absolute(folder).parent_path()}) {
      if (!status.ok()) return status;
      if (!Exists(place / kStateList) || !sequence.states.empty()) continue;
      status = ReadStateList(place / kStateList, sequence.states);
    }
    if (!status.ok()) return status;
  } else {
    const auto files = FilesOf(folder);
    if (!files.ok()) return files.status();
    ScenePose x_world_recording;
    if (const fs::path gravity = fs::path(folder) / kGravityFile; Exists(gravity)) {
      const auto text = ReadFileBytes(gravity.string());
      if (!text.ok()) return text.status();
      const auto upright = ParseGravityFile(*text, gravity.string());
      if (!upright.ok()) return upright.status();
      x_world_recording = *upright;
    }
    for (const fs::path& file : FrameFiles(*files)) {
      SequenceFrame frame{.path = file.string(), .source = file.string()};
      if (const fs::path beside = PoseFileOf(file); Exists(beside)) {
        const auto pose = ReadPoseFile(beside);
        if (!pose.ok()) return pose.status();
        frame.x_world_sensor = ComposePoses(x_world_recording, *pose);
      }
      sequence.frames.push_back(std::move(frame));
    }
  }
  if (!sequence.frames.empty()) return sequence;
  return absl::InvalidArgumentError(
      absl::StrCat(folder,
                   ": has no frames, must have a frames.jsonl, depth images (.png, .npy) or clouds "
                   "(.pcd, .ply)"));
}

}  // namespace cwm::formats
