#include "server/wire/robot_settings.h"

#include <set>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/xml/xml_element.h"
#include "server/wire/numbers.h"
#include "server/wire/objects.h"
#include "server/wire/poses.h"

namespace cwm::server {
namespace {

using collision::Quoted;

// chosen: one for each link that a robot may have (RobotLimits::max_links), and one for the others.
constexpr std::int64_t kMaxLinkValues = 1'025;
constexpr std::int64_t kMaxTools = 64;  // chosen: far more than a robot has flanges
constexpr std::int64_t kMaxNameInSettingBytes = 1'024;
constexpr double kMinLinkScale = 0.01, kMaxLinkScale = 100;

absl::Status CheckScale(double scale, const FieldPath& path) {
  if (scale >= kMinLinkScale && scale <= kMaxLinkScale) return absl::OkStatus();
  return path.Error(
      absl::StrCat("is ", scale, ", must be from ", kMinLinkScale, " to ", kMaxLinkScale));
}

absl::Status CheckOnce(const std::string& name, std::set<std::string>& known,
                       const FieldPath& path) {
  if (name.empty()) return path.Error("is empty, must be given");
  if (auto status = CheckTextLength(name, kMaxNameInSettingBytes, path); !status.ok())
    return status;
  if (known.insert(name).second) return absl::OkStatus();
  return path.Error(absl::StrCat("is ", Quoted(name), ", must come once"));
}

// Reads the list `name` of numbers of links.
template <class Message, class Get, class Check>
absl::StatusOr<collision::LinkValues> ReadLinkValues(
    const google::protobuf::RepeatedPtrField<Message>& messages, std::string_view name,
    std::string_view number, Get get, Check check, const FieldPath& path) {
  if (auto status = CheckRange(messages.size(), {0, kMaxLinkValues}, path.Field(name));
      !status.ok()) {
    return status;
  }
  collision::LinkValues values;
  std::set<std::string> known;
  for (int i = 0; i < messages.size(); ++i) {
    const FieldPath item = path.Item(name, i);
    auto status = CheckOnce(messages[i].link(), known, item.Field("link"));
    if (status.ok()) status = check(get(messages[i]), item.Field(number));
    if (!status.ok()) return status;
    values.push_back({messages[i].link(), get(messages[i])});
  }
  return values;
}

absl::StatusOr<collision::NamedTool> ToolFromProto(const v1::RobotTool& tool,
                                                   const FieldPath& path) {
  collision::NamedTool result{.name = tool.name(), .link = tool.link(), .group = tool.group()};
  if (auto status = CheckName(tool.name(), path.Field("name")); !status.ok()) return status;
  if (tool.link().empty()) return path.Field("link").Error("is empty, must be given");
  for (const auto& [text, field] : {std::pair(&tool.link(), "link"), {&tool.group(), "group"}}) {
    if (auto status = CheckTextLength(*text, kMaxNameInSettingBytes, path.Field(field));
        !status.ok()) {
      return status;
    }
  }
  if (!tool.has_x_link_tool()) return result;
  const auto X_LT = PoseFromProto(tool.x_link_tool(), path.Field("x_link_tool"));
  if (!X_LT.ok()) return X_LT.status();
  result.X_LT = *X_LT;
  return result;
}

}  // namespace

absl::StatusOr<collision::LinkValues> LinkPaddingsFromProto(
    const google::protobuf::RepeatedPtrField<v1::LinkPadding>& paddings, const FieldPath& path) {
  return ReadLinkValues(
      paddings, "link_padding", "padding_m",
      [](const v1::LinkPadding& padding) { return padding.padding_m(); }, CheckLength, path);
}

absl::StatusOr<collision::RobotSettings> RobotSettingsFromProto(const v1::LoadRobotHeader& header,
                                                                const FieldPath& path) {
  collision::RobotSettings settings;
  auto paddings = LinkPaddingsFromProto(header.link_padding(), path);
  if (!paddings.ok()) return paddings.status();
  settings.padding_m = *std::move(paddings);
  auto scales = ReadLinkValues(
      header.link_scale(), "link_scale", "scale",
      [](const v1::LinkScale& scale) { return scale.scale(); }, CheckScale, path);
  if (!scales.ok()) return scales.status();
  settings.scale = *std::move(scales);
  if (auto status = CheckRange(header.tools_size(), {0, kMaxTools}, path.Field("tools"));
      !status.ok()) {
    return status;
  }
  std::set<std::string> known;
  for (int i = 0; i < header.tools_size(); ++i) {
    const FieldPath item = path.Item("tools", i);
    auto tool = ToolFromProto(header.tools(i), item);
    if (!tool.ok()) return tool.status();
    if (auto status = CheckOnce(tool->name, known, item.Field("name")); !status.ok()) return status;
    settings.tools.push_back(*std::move(tool));
  }
  return settings;
}

v1::RobotTool RobotToolToProto(const collision::RobotTool& tool,
                               const collision::RobotModel& model) {
  v1::RobotTool proto;
  proto.set_name(tool.name);
  proto.set_link(model.links[static_cast<std::size_t>(tool.link)].name);
  *proto.mutable_x_link_tool() = PoseToProto(tool.X_LT);
  proto.set_group(tool.group);
  return proto;
}

}  // namespace cwm::server
