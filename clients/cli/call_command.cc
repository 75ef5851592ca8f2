// cwm call
#include <google/protobuf/descriptor.h>
#include <google/protobuf/dynamic_message.h>

#include <istream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>
#include <sstream>

#include "absl/strings/str_cat.h"
#include "clients/cli/commands.h"
#include "clients/cli/generic_call.h"
#include "clients/cli/message_json.h"
#include "clients/cli/reflection_client.h"
#include "clients/formats/file_bytes.h"

namespace cwm::cli {
namespace {

using google::protobuf::DynamicMessageFactory;
using google::protobuf::Message;
using google::protobuf::MethodDescriptor;

struct CallArguments {
  std::string method;
  std::string json = "{}";
};

// The text itself as JSON; the contents of "@FILE"; stdin for "-".
absl::StatusOr<std::string> ReadJson(const std::string& text, const Streams& streams) {
  if (text == "-") return std::string(std::istreambuf_iterator<char>(streams.in), {});
  if (!text.empty() && text[0] == '@') return formats::ReadFileBytes(text.substr(1));
  return text;
}

// One request; for methods that take a stream several, from an array or from one object per line.
absl::StatusOr<std::vector<std::string>> SplitRequests(const std::string& json,
                                                       const MethodDescriptor& method) {
  if (!method.client_streaming()) return std::vector<std::string>{json};
  std::vector<std::string> requests;
  const auto array = nlohmann::ordered_json::parse(json, nullptr, /*allow_exceptions=*/false);
  if (array.is_array()) {
    for (const auto& element : array) requests.push_back(element.dump());
    return requests;
  }
  if (array.is_object()) return std::vector<std::string>{json};
  std::istringstream lines(json);
  for (std::string line; std::getline(lines, line);) {
    if (line.find_first_not_of(" \t\r") != std::string::npos) requests.push_back(line);
  }
  return requests;
}

void PrintReply(const Message& reply, const MethodDescriptor& method, Session& session) {
  const bool lines = session.form == OutputForm::kNdjson || method.server_streaming();
  session.streams.out << ToJson(reply, lines ? JsonStyle::kOneLine : JsonStyle::kIndented) << "\n"
                      << std::flush;
}

absl::Status CallAny(Session& session, const CallArguments& arguments) {
  const auto json = ReadJson(arguments.json, session.streams);
  if (!json.ok()) return json.status();
  ReflectionClient reflection(session.connection());
  const auto method = reflection.FindMethod(arguments.method);
  if (!method.ok()) return method.status();
  const auto texts = SplitRequests(*json, **method);
  if (!texts.ok()) return texts.status();

  DynamicMessageFactory factory(&reflection.pool());
  std::vector<std::string> requests;
  for (const std::string& text : *texts) {
    const std::unique_ptr<Message> request(factory.GetPrototype((*method)->input_type())->New());
    if (absl::Status status = FromJson(text, *request); !status.ok()) return status;
    requests.push_back(request->SerializeAsString());
  }
  const std::string path =
      absl::StrCat("/", (*method)->service()->full_name(), "/", (*method)->name());
  const std::unique_ptr<Message> reply(factory.GetPrototype((*method)->output_type())->New());
  bool readable = true;
  absl::Status status =
      CallMethod(session.connection(), path, requests, [&](const std::string& bytes) {
        readable = readable && reply->ParseFromString(bytes);
        if (readable) PrintReply(*reply, **method, session);
      });
  if (!readable) return absl::DataLossError(absl::StrCat("reply of ", path, " cannot be parsed"));
  return status;
}

}  // namespace

void AddCallCommand(CommandLine& line) {
  const auto arguments = std::make_shared<CallArguments>();
  CLI::App& command = AddCommand(
      line,
      {"call",
       "any method of the server, in protobuf JSON",
       {"cwm call GetServerInfo", "cwm call WorldService/GetObject '{\"name\": \"mug\"}'",
        "cwm call ApplyChanges @changes.json", "cwm call grpc.health.v1.Health/Check"},
       "The server describes its methods itself (reflection). JSON: the text, @FILE, or - for "
       "stdin; a\n"
       "method that takes a stream takes an array or one object a line. A bytes field may be "
       "\"@FILE\":\n"
       "the bytes of that file. Replies are JSON, one line each where they come as a stream."},
      [arguments](Session& session) { return CallAny(session, *arguments); });
  command.add_option("METHOD", arguments->method, "Service/Method, or the method alone")
      ->required();
  command.add_option("JSON", arguments->json, "the request; default: {}");
}

}  // namespace cwm::cli
