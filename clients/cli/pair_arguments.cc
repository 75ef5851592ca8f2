#include "clients/cli/pair_arguments.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/quantity.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

std::string TimeText(const google::protobuf::Timestamp& time) {
  return absl::FormatTime("%Y-%m-%d %H:%M:%S UTC", absl::FromUnixSeconds(time.seconds()),
                          absl::UTCTimeZone());
}

}  // namespace

absl::StatusOr<pb::NamedThing> ParsePairMember(const std::string& text, const std::string& option) {
  const std::size_t colon = text.find(':');
  const bool has_link = colon != std::string::npos;
  pb::NamedThing member;
  member.set_name(text.substr(0, colon));
  if (has_link) member.set_link(text.substr(colon + 1));
  const bool is_invalid =
      member.name().empty() || (has_link && (member.link().empty() || member.name() == "*"));
  if (!is_invalid) return member;
  return UsageError(
      absl::StrCat(option, ": \"", text, "\" must be NAME, ROBOT:LINK or '*' (everything)"));
}

absl::StatusOr<pb::NamedPair> ParsePair(const std::string& text, const std::string& option) {
  if (std::count(text.begin(), text.end(), ',') != 1) {
    return UsageError(absl::StrCat(option, ": \"", text, "\" must be A,B: two things, a comma"));
  }
  const std::size_t comma = text.find(',');
  const auto a = ParsePairMember(text.substr(0, comma), option);
  if (!a.ok()) return a.status();
  const auto b = ParsePairMember(text.substr(comma + 1), option);
  if (!b.ok()) return b.status();
  pb::NamedPair pair;
  *pair.mutable_a() = *a;
  *pair.mutable_b() = *b;
  return pair;
}

std::string PairMemberText(const pb::NamedThing& member) {
  return member.link().empty() ? member.name() : absl::StrCat(member.name(), ":", member.link());
}

std::string FormatRule(const pb::PairRule& rule) {
  std::string text;
  if (rule.allowed()) text = "allowed";
  if (rule.check()) text = "checked";
  if (rule.has_expires()) absl::StrAppend(&text, " until ", TimeText(rule.expires()));
  if (rule.has_margin_m()) {
    absl::StrAppend(&text, text.empty() ? "" : ", ", "margin ", FormatLength(rule.margin_m()));
  }
  return text.empty() ? "no rule" : text;
}

}  // namespace cwm::cli
