#include "clients/cli/link_values.h"

#include "absl/strings/str_cat.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/number_list.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

absl::Status FormError(const std::string& option, const std::string& text,
                       const std::string& form) {
  return UsageError(absl::StrCat(option, ": \"", text, "\" must be ", form));
}

struct LinkNumber {
  std::string link;
  double number = 0;
};

absl::StatusOr<LinkNumber> ParseLinkNumber(const std::string& text, const std::string& option,
                                           const std::string& form) {
  const std::size_t equals = text.rfind('=');
  if (equals == std::string::npos || equals == 0) return FormError(option, text, form);
  const auto number = ParseNumbers(text.substr(equals + 1), {option, form, 1});
  if (!number.ok()) return FormError(option, text, form);
  return LinkNumber{text.substr(0, equals), number->front()};
}

}  // namespace

absl::StatusOr<pb::LinkPadding> ParseLinkPadding(const std::string& text) {
  const auto of_link = ParseLinkNumber(text, "--padding", kPaddingForm);
  if (!of_link.ok()) return of_link.status();
  pb::LinkPadding padding;
  padding.set_link(of_link->link);
  padding.set_padding_m(of_link->number);
  return padding;
}

absl::StatusOr<pb::LinkScale> ParseLinkScale(const std::string& text) {
  const auto of_link = ParseLinkNumber(text, "--scale", kScaleForm);
  if (!of_link.ok()) return of_link.status();
  pb::LinkScale scale;
  scale.set_link(of_link->link);
  scale.set_scale(of_link->number);
  return scale;
}

absl::StatusOr<pb::RobotTool> ParseTool(const std::string& text) {
  const std::size_t equals = text.find('='), at = text.rfind('@');
  const bool has_pose = at != std::string::npos && equals != std::string::npos && at > equals;
  pb::RobotTool tool;
  tool.set_name(text.substr(0, equals));
  if (equals != std::string::npos) {
    tool.set_link(text.substr(equals + 1, has_pose ? at - equals - 1 : std::string::npos));
  }
  if (tool.name().empty() || tool.link().empty()) return FormError("--tool", text, kToolForm);
  if (!has_pose) return tool;
  const auto pose = ParsePose(text.substr(at + 1), "--tool");
  if (!pose.ok()) return pose.status();
  *tool.mutable_x_link_tool() = PoseToProto(*pose);
  return tool;
}

absl::StatusOr<std::pair<std::string, std::string>> ParseToolGroup(const std::string& text) {
  const std::size_t equals = text.find('=');
  const bool is_whole = equals != std::string::npos && equals > 0 && equals + 1 < text.size();
  if (!is_whole) return FormError("--tool-group", text, kToolGroupForm);
  return std::pair(text.substr(0, equals), text.substr(equals + 1));
}

}  // namespace cwm::cli
