#include "clients/cli/what_if.h"

#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/message_json.h"
#include "clients/cli/number_list.h"
#include "clients/cli/pair_arguments.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;
using Words = std::vector<std::string>;

absl::Status SetPose(const std::string& text, const std::string& option, pb::Pose* pose) {
  const auto parsed = ParsePose(text, option);
  if (parsed.ok()) *pose = PoseToProto(*parsed);
  return parsed.status();
}

absl::Status SetAttach(const Words& words, const std::string& option, pb::AttachObject* attach) {
  const auto link = ParsePairMember(words[2], option);
  if (!link.ok()) return link.status();
  attach->set_name(words[1]);
  attach->set_robot(link->name());
  attach->set_link(link->link());
  return words.size() == 3 ? absl::OkStatus()
                           : SetPose(words[3], option, attach->mutable_x_link_object());
}

}  // namespace

absl::StatusOr<pb::Change> ParseChange(const std::string& text, const std::string& option) {
  const std::string trimmed(absl::StripAsciiWhitespace(text));
  pb::Change change;
  absl::Status status;
  if (trimmed.rfind('{', 0) == 0) {
    status = FromJson(trimmed, change);
    if (!status.ok()) return UsageError(absl::StrCat(option, ": ", status.message()));
    return change;
  }
  const Words words = absl::StrSplit(trimmed, absl::ByAnyChar(" \t"), absl::SkipEmpty());
  const auto is = [&](const char* verb, std::size_t count) {
    return words.size() == count && words[0] == verb;
  };
  if (is("move", 3)) {
    change.mutable_move()->set_name(words[1]);
    status = SetPose(words[2], option, change.mutable_move()->mutable_x_world_object());
  } else if (is("remove", 2)) {
    change.mutable_remove()->set_name(words[1]);
  } else if (is("attach", 3) || is("attach", 4)) {
    status = SetAttach(words, option, change.mutable_attach());
  } else if (is("detach", 2)) {
    change.mutable_detach()->set_name(words[1]);
  } else if (is("allow", 2)) {
    const auto pair = ParsePair(words[1], option);
    if (!pair.ok()) return pair.status();
    *change.mutable_allow()->mutable_pair() = *pair;
  } else {
    return UsageError(absl::StrCat(option, ": \"", text, "\" must be ", kChangeForms));
  }
  if (!status.ok()) return status;
  return change;
}

}  // namespace cwm::cli
