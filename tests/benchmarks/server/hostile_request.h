// Requests that cost a server more than they cost the sender: the entries of the amplification
// measurement. A new request is a new row in the table of its service.
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

// The bytes that one copy of a hostile request sent, and the calls that it holds open.
struct Sent {
  std::int64_t bytes = 0;          // on the wire, uploads that the request needs included
  std::int64_t content_bytes = 0;  // the part that a world may store, as it travels
  std::vector<std::unique_ptr<HeldCall>> calls;
  std::vector<std::shared_ptr<void>> others;  // connections and channels, which end with it
  std::string outcome;                        // of calls not held, e.g. of many calls in a row
};

// The server under attack, and what the preparation left there.
struct Target {
  MeasuredServer& server;
  std::vector<std::string> hashes = {};  // of meshes, one per copy
  std::int64_t mesh_bytes = 0;           // of each

  // Begins the call over a connection of its own and waits until it is sent, at most a second.
  void Hold(CallPlan plan, Sent& sent) const;
  // The same over a given channel.
  void HoldOver(const std::shared_ptr<grpc::Channel>& channel, CallPlan plan, Sent& sent) const;
  // Makes the calls one after another over one connection, each to its end, for at most `limit_s`;
  // records the outcome of the last.
  void CallSequentially(const std::vector<CallPlan>& plans, double limit_s, Sent& sent) const;
};

inline constexpr int kCpuTries = 3;

// Sends one copy. Copies differ if the server may cache its work.
using SendCopy = std::function<void(const Target& target, int copy, Sent& sent)>;

struct HostileRequest {
  std::string name;
  int copies = 8;  // held at once; the preparation makes kCpuTries more of what each needs
  // Stores the content that an honest client would store; false if that failed. `copies` includes
  // the tries.
  std::function<bool(Target& target, int copies)> prepare = {};
  SendCopy send;
  bool has_cpu = true;           // false: a series of calls, each cheap
  std::string known_issue = {};  // not empty: printed and not judged, with this reason
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
CallPlan UnaryPlan(std::string method, const Request& request) {
  return {.method = std::move(method), .messages = {request.SerializeAsString()}};
}

}  // namespace cwm::benchmarks
