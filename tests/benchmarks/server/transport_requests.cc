// Hostile traffic below the services: connections, headers, malformed messages, resets, health and
// reflection.
#include <unistd.h>

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "tests/benchmarks/server/hostile_content.h"
#include "tests/benchmarks/server/hostile_request.h"
#include "tests/benchmarks/server/raw_http2.h"

namespace cwm::benchmarks {
namespace {

constexpr char kInfo[] = "cwm.v1.AdminService/GetServerInfo";
constexpr char kTransport[] =
    "the transport keeps the state of each stream, whatever the server does";

void LargeMetadata(const Target& target, int, Sent& sent) {
  const CallPlan plan{.method = "cwm.v1.QueryService/StreamQueries",
                      .half_closes = false,
                      .metadata = {{"x-large", std::string(15 << 10, 'm')}}};
  const auto channel = target.server.NewChannel();
  constexpr int kCalls = 64;
  for (int i = 0; i < kCalls; ++i) target.HoldOver(channel, plan, sent);
  sent.bytes += 15 << 10;  // HPACK indexes repeated headers: the others cost a few bytes each
}

// Messages that are not valid protobuf: nested groups, lengths beyond the end.
SendCopy Malformed(std::string method, std::string bytes) {
  return [=](const Target& target, int, Sent& sent) {
    CallPlan plan{.method = method, .messages = {bytes}};
    const auto channel = target.server.NewChannel();
    for (int i = 0; i < 16; ++i) target.HoldOver(channel, plan, sent);
  };
}

// Millions of unknown fields of two bytes, which the parser keeps unless it is told not to.
std::string UnknownFields() {
  std::string bytes;
  for (int i = 0; i < 2'000'000; ++i) bytes += std::string("\x78\x01", 2);
  return bytes;
}

// A list of two million empty changes.
std::string EmptyChanges() {
  std::string bytes = std::string("\x0A\x01w", 3);
  for (int i = 0; i < 2'000'000; ++i) bytes += std::string("\x12\x00", 2);
  return bytes;
}

void Reflection(const Target& target, int, Sent& sent) {
  CallPlan plan{.method = "grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo",
                .reads = false};
  // file_containing_symbol = 4
  const std::string symbol = "cwm.v1.WorldService";
  const std::string request = "\x22" + std::string(1, static_cast<char>(symbol.size())) + symbol;
  plan.messages.assign(500, request);
  const auto channel = target.server.NewChannel();
  for (int i = 0; i < 8; ++i) target.HoldOver(channel, plan, sent);
}

void HealthWatches(const Target& target, int copy, Sent& sent) {
  const auto channel = target.server.NewChannel();
  for (int i = 0; i < 200; ++i) {
    const std::string service = absl::StrCat("unknown", copy, "_", i);
    const std::string request =
        "\x0A" + std::string(1, static_cast<char>(service.size())) + service;
    target.HoldOver(
        channel, {.method = "grpc.health.v1.Health/Watch", .messages = {request}, .reads = false},
        sent);
  }
}

void UnknownMethods(const Target& target, int copy, Sent& sent) {
  const auto channel = target.server.NewChannel();
  for (int i = 0; i < 500; ++i) {
    target.HoldOver(channel,
                    {.method = absl::StrCat("no.Service/", std::string(100, 'm'), copy, "_", i),
                     .messages = {""}},
                    sent);
  }
}

// Calls that are reset as soon as they are made, over one connection.
void Resets(const Target& target, int, Sent& sent) {
  auto connection = std::make_shared<RawHttp2>(target.server.socket_path());
  std::uint32_t stream = 1;
  for (int burst = 0; burst < 376; ++burst) {
    std::string frames;
    for (int i = 0; i < 100; ++i, stream += 2) {
      frames += RawHttp2::Headers(stream, kInfo) + RawHttp2::Message(stream, "", true) +
                RawHttp2::Reset(stream);
    }
    if (!connection->Send(frames, 2.0)) break;
  }
  sent.outcome = absl::StrCat(stream / 2, " calls");
  sent.bytes += connection->sent_bytes();
  sent.others.push_back(connection);
}

// Calls of which only the headers are sent.
void HeadersOnly(const Target& target, int, Sent& sent) {
  auto connection = std::make_shared<RawHttp2>(target.server.socket_path());
  std::string frames;
  for (std::uint32_t i = 0; i < 1'000; ++i) {
    frames += RawHttp2::Headers(2 * i + 1, "cwm.v1.QueryService/StreamQueries");
  }
  connection->Send(frames, 2.0);
  sent.bytes += connection->sent_bytes();
  sent.others.push_back(connection);
  sent.outcome = "1000 streams";
}

// Pings and settings whose acknowledgements nobody reads.
void Pings(const Target& target, int, Sent& sent) {
  auto connection = std::make_shared<RawHttp2>(target.server.socket_path());
  std::string frames;
  for (int i = 0; i < 20'000; ++i) frames += i % 2 == 0 ? RawHttp2::Ping() : RawHttp2::Settings();
  connection->Send(frames, 1.0, false);
  sent.bytes += connection->sent_bytes();
  sent.others.push_back(connection);
  sent.outcome = "pings";
}

// Connections without any data.
void SilentConnections(const Target& target, int, Sent& sent) {
  struct Sockets {
    std::vector<int> fds;
    ~Sockets() {
      for (const int fd : fds) close(fd);
    }
  };
  auto sockets = std::make_shared<Sockets>();
  for (int i = 0; i < 100; ++i) {
    const int fd = ConnectUnix(target.server.socket_path());
    if (fd >= 0) sockets->fds.push_back(fd);
  }
  sent.outcome = absl::StrCat(sockets->fds.size(), " connections");
  sent.others.push_back(sockets);
}

// Channels that have made one call each.
void IdleChannels(const Target& target, int, Sent& sent) {
  for (int i = 0; i < 50; ++i) target.Hold({.method = kInfo, .messages = {""}}, sent);
}

// A world's name of 15 MiB, compressed to 15 kB.
SendCopy Compressed() {
  v1::ApplyChangesRequest request;
  request.set_world(std::string(15 << 20, 'n'));
  CallPlan plan = UnaryPlan("cwm.v1.WorldService/ApplyChanges", request);
  plan.compresses = true;
  return [plan](const Target& target, int, Sent& sent) { target.Hold(plan, sent); };
}

}  // namespace

std::vector<HostileRequest> TransportRequests() {
  const std::string groups(100'000, '\x0B');  // each opens a group of field 1
  return {
      {.name = "transport/metadata_15k", .copies = 1, .send = LargeMetadata, .has_cpu = false},
      {.name = "transport/nested_groups",
       .copies = 2,
       .send = Malformed("cwm.v1.WorldService/ApplyChanges", groups)},
      {.name = "transport/unknown_fields", .copies = 2, .send = Malformed(kInfo, UnknownFields())},
      {.name = "transport/empty_changes",
       .copies = 2,
       .send = Malformed("cwm.v1.WorldService/ApplyChanges", EmptyChanges())},
      {.name = "transport/gzip", .copies = 4, .send = Compressed()},
      {.name = "transport/cut_message",
       .copies = 2,
       .send = Malformed("cwm.v1.QueryService/GetDistances", std::string("\x12\x7F", 2)),
       .has_cpu = false},
      {.name = "transport/reflection_unread", .copies = 2, .send = Reflection},
      {.name = "transport/health_watches", .copies = 1, .send = HealthWatches, .has_cpu = false},
      {.name = "transport/unknown_methods", .copies = 1, .send = UnknownMethods, .has_cpu = false},
      {.name = "transport/resets_37600",
       .copies = 1,
       .send = Resets,
       .has_cpu = false,
       .known_issue = kTransport},
      {.name = "transport/headers_only",
       .copies = 1,
       .send = HeadersOnly,
       .has_cpu = false,
       .known_issue = kTransport},
      {.name = "transport/pings_unread", .copies = 4, .send = Pings, .has_cpu = false},
      {.name = "transport/silent_connections",
       .copies = 1,
       .send = SilentConnections,
       .has_cpu = false},
      {.name = "transport/idle_channels", .copies = 1, .send = IdleChannels, .has_cpu = false},
  };
}

}  // namespace cwm::benchmarks
