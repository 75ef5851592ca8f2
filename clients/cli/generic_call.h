// Calls of any method, whose messages only its descriptor knows.
#pragma once

#include <google/protobuf/message.h>

#include <functional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "clients/cpp/connection.h"

namespace cwm::cli {

// Sends the serialised requests one after another, then hands over each serialised reply as it
// comes, for all four kinds of methods. `path` is "/package.Service/Method".
absl::Status CallMethod(const client::Connection& connection, const std::string& path,
                        const std::vector<std::string>& requests,
                        const std::function<void(const std::string&)>& on_reply);

}  // namespace cwm::cli
