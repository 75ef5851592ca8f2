// Prints and reads messages as protobuf JSON.
#pragma once

#include <google/protobuf/message.h>

#include <string>

#include "absl/status/status.h"

namespace cwm::cli {

enum class JsonStyle { kIndented, kOneLine };

// snake_case names, defaults printed; 64-bit integers are strings and bytes base64, as usual in
// protobuf JSON.
std::string ToJson(const google::protobuf::Message& message, JsonStyle spacing);

// Fills in the message. A string "@PATH" for a bytes field means the bytes of that file; "@@..." is
// the text "@...", taken as base64 like any other. INVALID_ARGUMENT for unknown fields.
absl::Status FromJson(const std::string& json, google::protobuf::Message& message);

}  // namespace cwm::cli
