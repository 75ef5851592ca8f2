#include "clients/cli/enum_names.h"

#include <google/protobuf/descriptor.h>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"

namespace cwm::cli {

std::string ShortNameOf(const google::protobuf::EnumDescriptor& type, int value) {
  const auto* named = type.FindValueByNumber(value);
  if (named == nullptr) return absl::StrCat(value);  // a newer server's value
  // All values have their type's name as a prefix, which the unspecified value reveals.
  const std::string unspecified = "UNSPECIFIED";
  const std::string& first = type.value(0)->name();
  const std::string prefix = first.substr(0, first.size() - unspecified.size());
  if (value == 0) return "";
  return absl::AsciiStrToLower(named->name().substr(prefix.size()));
}

}  // namespace cwm::cli
