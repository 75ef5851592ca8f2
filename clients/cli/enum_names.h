// Short names of enum values.
#pragma once

#include <google/protobuf/generated_enum_reflection.h>

#include <map>
#include <string>

namespace cwm::cli {

// E.g. "support" for OBJECT_KIND_SUPPORT of the enum ObjectKind.
std::string ShortNameOf(const google::protobuf::EnumDescriptor& type, int value);

template <class Enum>
std::string ShortName(Enum value) {
  return ShortNameOf(*google::protobuf::GetEnumDescriptor<Enum>(), value);
}

// Every value but the unspecified one, by its short name.
template <class Enum>
std::map<std::string, Enum> ShortNames() {
  std::map<std::string, Enum> names;
  const auto& type = *google::protobuf::GetEnumDescriptor<Enum>();
  for (int i = 0; i < type.value_count(); ++i) {
    const int number = type.value(i)->number();
    if (number != 0) names[ShortNameOf(type, number)] = static_cast<Enum>(number);
  }
  return names;
}

}  // namespace cwm::cli
