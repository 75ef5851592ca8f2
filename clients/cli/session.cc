#include "clients/cli/session.h"

#include <cmath>
#include <ostream>

#include "clients/cli/message_json.h"

namespace cwm::cli {

const client::Connection& Session::connection() {
  if (connection_ == nullptr) {
    client::ConnectOptions options;
    if (!address.empty()) options.address = address;
    if (deadline_s) options.deadline = std::chrono::milliseconds(std::llround(1000 * *deadline_s));
    connection_ = std::make_unique<client::Connection>(options);
  }
  return *connection_;
}

void Session::Print(const google::protobuf::Message& response, const std::function<void()>& table) {
  PrintList(
      response, [&] { PrintLine(response); }, table);
}

void Session::PrintList(const google::protobuf::Message& response,
                        const std::function<void()>& lines, const std::function<void()>& table) {
  switch (form) {
    case OutputForm::kTable:
      return table();
    case OutputForm::kNdjson:
      return lines();
    case OutputForm::kJson:
      streams.out << ToJson(response, JsonStyle::kIndented) << "\n";
  }
}

void Session::PrintLine(const google::protobuf::Message& element) {
  streams.out << ToJson(element, JsonStyle::kOneLine) << "\n";
}

void Session::Warn(const std::string& warning) {
  streams.err << "cwm: warning: " << warning << "\n";
}

}  // namespace cwm::cli
