// Calls any method using its descriptor.
#pragma once

#include <google/protobuf/message.h>

#include <functional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "clients/cpp/connection.h"

namespace cwm::cli {

// Sends the serialised requests one after the other, then passes on each serialised reply as it
// arrives, for all four kinds of methods. `path` is "/package.Service/Method".
absl::Status CallMethod(const client::Connection& connection, const std::string& path,
                        const std::vector<std::string>& requests,
                        const std::function<void(const std::string&)>& on_reply);

}  // namespace cwm::cli
