// Calls of the server as operations of a history.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>

#include "clients/cpp/connection.h"
#include "tests/fault/history.h"

namespace cwm::fault {

// Nanoseconds of the steady clock: the time of all histories.
std::int64_t NowNs();

// A history that several threads write. Thread safe.
class Recorder {
 public:
  void Add(Operation operation) {
    const std::lock_guard lock(mutex_);
    history_.operations.push_back(std::move(operation));
  }
  void Add(Watch watch) {
    const std::lock_guard lock(mutex_);
    history_.watches.push_back(std::move(watch));
  }
  // Only while no other thread adds anything.
  const History& history() const { return history_; }

 private:
  std::mutex mutex_;
  History history_;
};

// The one robot of the histories.
inline constexpr char kRobot[] = "cart";

// The name of the mesh with this number in ModelObject::geometry, and its bytes (MESH_F64). Of 900
// vertices and more it is larger than what the store keeps inside its records.
struct NumberedMesh {
  std::string geometry;
  std::string bytes;
};
NumberedMesh MakeMesh(std::int64_t number, int vertex_count);

// Sends the write or deletion that the operation describes, and fills in what came of it. A write
// that names a mesh needs UploadMesh before.
void Send(const client::Connection& connection, Operation& operation);
// False if no answer came or the server refused it.
bool UploadMesh(const client::Connection& connection, const NumberedMesh& mesh);
// Reads objects, then robots and rules at the same revision, and fills in what came of it.
void Read(const client::Connection& connection, Operation& operation);
// Adds the digests of the world as files of other tools, and of all meshes, to a read that
// succeeded. False, with the reason in `error`, if one of them was refused or its bytes do not have
// the hash that names them.
bool ReadFiles(const client::Connection& connection, Operation& operation, std::string& error);

// Reads the stream until `goes_on` returns false, the context is cancelled or the server ends it.
void Follow(const client::Connection& connection, grpc::ClientContext& context, Watch& watch,
            const std::function<bool(const Watch&)>& goes_on);

// The newest revision that is complete in the stream; its beginning before that.
std::int64_t ReachedBy(const Watch& watch);

}  // namespace cwm::fault
