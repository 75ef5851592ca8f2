#include "clients/cli/message_json.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/util/json_util.h>

#include <nlohmann/json.hpp>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "clients/formats/file_bytes.h"

namespace cwm::cli {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using OrderedJson = nlohmann::ordered_json;

absl::Status ReplaceFiles(const Descriptor& type, OrderedJson& value);

absl::Status ReplaceFile(OrderedJson& value) {
  if (!value.is_string()) return absl::OkStatus();
  const auto text = value.get<std::string>();
  if (text.empty() || text[0] != '@') return absl::OkStatus();
  if (text.size() > 1 && text[1] == '@') {
    value = text.substr(1);
    return absl::OkStatus();
  }
  const auto bytes = formats::ReadFileBytes(text.substr(1));
  if (!bytes.ok()) return bytes.status();
  value = absl::Base64Escape(*bytes);
  return absl::OkStatus();
}

absl::Status ReplaceInField(const FieldDescriptor& field, OrderedJson& value) {
  if (value.is_array()) {
    for (OrderedJson& element : value) {
      if (absl::Status status = ReplaceInField(field, element); !status.ok()) return status;
    }
    return absl::OkStatus();
  }
  if (field.type() == FieldDescriptor::TYPE_BYTES) return ReplaceFile(value);
  if (field.message_type() == nullptr || field.is_map()) return absl::OkStatus();
  return ReplaceFiles(*field.message_type(), value);
}

// Replaces names of files in the JSON by the files' bytes.
absl::Status ReplaceFiles(const Descriptor& type, OrderedJson& value) {
  if (!value.is_object()) return absl::OkStatus();
  for (auto& [name, member] : value.items()) {
    const FieldDescriptor* field = type.FindFieldByName(name);
    if (field == nullptr) field = type.FindFieldByCamelcaseName(name);
    if (field == nullptr) continue;  // the parser below reports it
    if (absl::Status status = ReplaceInField(*field, member); !status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace

std::string ToJson(const google::protobuf::Message& message, JsonStyle spacing) {
  google::protobuf::util::JsonPrintOptions options;
  options.add_whitespace = spacing == JsonStyle::kIndented;
  options.always_print_primitive_fields = true;
  options.preserve_proto_field_names = true;
  std::string json;
  const auto status = google::protobuf::util::MessageToJsonString(message, &json, options);
  if (!status.ok()) return absl::StrCat("{\"unprintable\": \"", message.GetTypeName(), "\"}");
  while (!json.empty() && json.back() == '\n') json.pop_back();
  return json;
}

absl::Status FromJson(const std::string& json, google::protobuf::Message& message) {
  OrderedJson value = OrderedJson::parse(json, nullptr, /*allow_exceptions=*/false);
  if (value.is_discarded() || !value.is_object()) {
    return absl::InvalidArgumentError(
        absl::StrCat("message is not a JSON object: ", json.substr(0, 60)));
  }
  if (absl::Status files = ReplaceFiles(*message.GetDescriptor(), value); !files.ok()) return files;
  const auto status = google::protobuf::util::JsonStringToMessage(value.dump(), &message);
  if (status.ok()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(message.GetTypeName(), ": ", std::string(status.message())));
}

}  // namespace cwm::cli
