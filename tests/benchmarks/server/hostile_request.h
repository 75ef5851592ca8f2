// Requests that cost a server more than they cost who sends them: what the amplification is
// measured with. Each is an entry of a table; who knows another one adds a row to that of its
// service.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/benchmarks/server/held_call.h"
#include "tests/benchmarks/server/measured_server.h"

namespace cwm::benchmarks {

// What one copy of a hostile request sent, and what it holds open.
struct Sent {
  std::int64_t bytes = 0;          // on the wire, uploads that the request needs included
  std::int64_t content_bytes = 0;  // what a world may store of it, as it travels
  std::vector<std::unique_ptr<HeldCall>> calls;
  std::vector<std::shared_ptr<void>> others;  // connections, channels: go with it
  std::string outcome;                        // of what was not held, e.g. of many calls in a row
};

// Against whom: the server, and what the preparation left there.
struct Target {
  MeasuredServer& server;
  std::vector<std::string> hashes = {};  // of meshes, one a copy
  std::int64_t mesh_bytes = 0;           // of each

  // Begins the call over a connection of its own and waits until it is sent, at most a second.
  void Hold(CallPlan plan, Sent& sent) const;
  // The same over a given channel.
  void HoldOver(const std::shared_ptr<grpc::Channel>& channel, CallPlan plan, Sent& sent) const;
  // Makes the calls one after another over one connection, each to its end, for at most `limit_s`;
  // the outcome of the last.
  void CallInTurn(const std::vector<CallPlan>& plans, double limit_s, Sent& sent) const;
};

inline constexpr int kCpuTries = 3;

// Sends one copy. Copies differ where the server may remember what it has worked out once.
using SendCopy = std::function<void(const Target& target, int copy, Sent& sent)>;

struct HostileRequest {
  std::string name;
  int copies = 8;  // held at once; the preparation makes kCpuTries more of what each needs
  // Stores what an honest client would; false where that failed. `copies` includes the tries.
  std::function<bool(Target& target, int copies)> prepare = {};
  SendCopy send;
  bool has_cpu = true;        // false: a series of calls, each cheap
  std::string open_why = {};  // not empty: printed and not judged, with this reason
};

std::vector<HostileRequest> WorldRequests();
std::vector<HostileRequest> ReadingRequests();
std::vector<HostileRequest> QueryRequests();
std::vector<HostileRequest> StreamRequests();
std::vector<HostileRequest> UploadRequests();
std::vector<HostileRequest> RobotRequests();
std::vector<HostileRequest> TransportRequests();
// All of them.
std::vector<HostileRequest> HostileRequests();

// The plan of a call whose only message is `request`.
template <class Request>
CallPlan PlanOf(std::string method, const Request& request) {
  return {.method = std::move(method), .messages = {request.SerializeAsString()}};
}

}  // namespace cwm::benchmarks
