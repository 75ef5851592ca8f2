// The world as a server publishes it over time, from a watch: the objects of every revision.
#pragma once

#include <grpcpp/client_context.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "clients/cpp/connection.h"
#include "cwm/v1/world.pb.h"

namespace cwm::benchmarks {

// The objects of one revision by name. Those of a move have the pose of that revision.
using PublishedObjects = std::map<std::string, std::shared_ptr<const v1::Object>>;

class PublishedWorld {
 public:
  // The world exists.
  PublishedWorld(const std::string& address, const std::string& world);
  ~PublishedWorld();
  PublishedWorld(const PublishedWorld&) = delete;
  PublishedWorld& operator=(const PublishedWorld&) = delete;

  // Waits until the watch has sent the revision; false if it ends, or ten seconds pass, before.
  bool WaitFor(std::int64_t revision);
  // The objects of the newest revision that is not after this one; empty before the first.
  PublishedObjects At(std::int64_t revision) const;
  // Bytes of all messages that the watch has sent after the initial state.
  std::int64_t event_bytes() const;

 private:
  void Run(const std::string& world);
  void Take(const v1::WatchWorldResponse& message);

  const client::Connection connection_;
  grpc::ClientContext context_;
  mutable std::mutex mutex_;
  std::condition_variable advanced_;
  std::map<std::int64_t, PublishedObjects> by_revision_;
  PublishedObjects newest_;
  std::int64_t revision_ = -1;
  std::int64_t event_bytes_ = 0;
  bool is_over_ = false;
  std::thread thread_;
};

}  // namespace cwm::benchmarks
