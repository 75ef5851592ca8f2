#include "tests/fault/history.h"

#include <istream>
#include <ostream>

namespace cwm::fault {
namespace {

using nlohmann::json;

template <class T>
void Put(json& out, const char* key, const std::optional<T>& value) {
  if (value) out[key] = *value;
}

template <class T>
void Get(const json& in, const char* key, std::optional<T>& value) {
  if (in.contains(key)) value = in.at(key).get<T>();
}

json ToJson(const Operation& operation) {
  json out = {{"client", operation.client},
              {"kind", static_cast<int>(operation.kind)},
              {"world", operation.world},
              {"uid", operation.world_uid},
              {"id", operation.request_id},
              {"changes", operation.changes},
              {"invoke", operation.invoke_ns},
              {"return", operation.return_ns},
              {"outcome", static_cast<int>(operation.outcome)},
              {"revision", operation.revision},
              {"reason", operation.reason},
              {"at", static_cast<int>(operation.at)},
              {"asked", operation.asked_revision},
              {"after_restart", operation.after_restart},
              {"digests", operation.digests}};
  Put(out, "expected", operation.expected_revision);
  Put(out, "actual", operation.actual_revision);
  Put(out, "objects", operation.objects_hash);
  Put(out, "robots", operation.robots_hash);
  Put(out, "rules", operation.rules_hash);
  return out;
}

Operation OperationFrom(const json& in) {
  Operation operation{
      .client = in.at("client"),
      .kind = static_cast<Operation::Kind>(in.at("kind").get<int>()),
      .world = in.at("world"),
      .world_uid = in.at("uid"),
      .request_id = in.at("id"),
      .changes = in.at("changes"),
      .invoke_ns = in.at("invoke"),
      .return_ns = in.at("return"),
      .outcome = static_cast<Operation::Outcome>(in.at("outcome").get<int>()),
      .revision = in.at("revision"),
      .reason = in.at("reason"),
      .at = static_cast<Operation::At>(in.at("at").get<int>()),
      .asked_revision = in.at("asked"),
      .after_restart = in.at("after_restart"),
      .digests = in.at("digests"),
  };
  Get(in, "expected", operation.expected_revision);
  Get(in, "actual", operation.actual_revision);
  Get(in, "objects", operation.objects_hash);
  Get(in, "robots", operation.robots_hash);
  Get(in, "rules", operation.rules_hash);
  return operation;
}

json ToJson(const Watch& watch) {
  json messages = json::array();
  for (const WatchMessage& message : watch.messages) {
    messages.push_back({message.time_ns, message.revision, static_cast<int>(message.kind),
                        message.more, message.effects});
  }
  json out = {{"watcher", watch.client},       {"world", watch.world},
              {"uid", watch.world_uid},        {"lossless", watch.is_lossless},
              {"invoke", watch.invoke_ns},     {"messages", std::move(messages)},
              {"end_reason", watch.end_reason}};
  Put(out, "from", watch.from_revision);
  return out;
}

Watch WatchFrom(const json& in) {
  Watch watch{.client = in.at("watcher"),
              .world = in.at("world"),
              .world_uid = in.at("uid"),
              .is_lossless = in.at("lossless"),
              .invoke_ns = in.at("invoke"),
              .end_reason = in.at("end_reason")};
  Get(in, "from", watch.from_revision);
  for (const json& message : in.at("messages")) {
    watch.messages.push_back({.time_ns = message.at(0),
                              .revision = message.at(1),
                              .kind = static_cast<WatchMessage::Kind>(message.at(2).get<int>()),
                              .more = message.at(3),
                              .effects = message.at(4)});
  }
  return watch;
}

}  // namespace

void Write(const History& history, std::ostream& out) {
  for (const Operation& operation : history.operations) out << ToJson(operation).dump() << "\n";
  for (const Watch& watch : history.watches) out << ToJson(watch).dump() << "\n";
}

History ReadHistory(std::istream& in) {
  History history;
  std::string line;
  while (std::getline(in, line)) {
    const json value = json::parse(line);
    if (value.contains("watcher")) {
      history.watches.push_back(WatchFrom(value));
    } else {
      history.operations.push_back(OperationFrom(value));
    }
  }
  return history;
}

}  // namespace cwm::fault
