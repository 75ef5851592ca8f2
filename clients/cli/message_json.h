// Messages as the protobuf JSON that the command line prints and reads.
#pragma once

#include <google/protobuf/message.h>

#include <string>

#include "absl/status/status.h"

namespace cwm::cli {

enum class JsonSpacing { kIndented, kOneLine };

// snake_case names, defaults printed; 64-bit integers are strings, bytes are base64, as protobuf
// has it.
std::string ToJson(const google::protobuf::Message& message, JsonSpacing spacing);

// Fills in the message. A string "@PATH" where the message has a bytes field stands for the bytes
// of that file; "@@..." is the text "@...", taken as base64 like any other. Unknown fields are
// INVALID_ARGUMENT.
absl::Status FromJson(const std::string& json, google::protobuf::Message& message);

}  // namespace cwm::cli
