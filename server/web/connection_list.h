// The viewer's connections, so that their number is limited and a stopping server finds them all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <optional>

namespace cwm::server {

class ConnectionList;

// A connection from its begin to its end. Used only on the viewer's thread.
class Connection {
 public:
  // `uid`: the user at the other end, if the kernel reports it (see PeerUid).
  Connection(ConnectionList& list, std::optional<std::uint32_t> uid);
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  // Ends the connection soon; may be called again while it is ending.
  virtual void Close() = 0;
  // True if no request is being answered.
  virtual bool is_idle() const = 0;
  std::optional<std::uint32_t> uid() const { return uid_; }

 protected:
  virtual ~Connection();

 private:
  ConnectionList& list_;
  const std::optional<std::uint32_t> uid_;
  const std::list<Connection*>::iterator position_;
};

class ConnectionList {
 public:
  std::size_t size() const { return connections_.size(); }
  // All connections of unknown users count as one user's.
  std::size_t CountOf(std::optional<std::uint32_t> uid) const {
    std::size_t count = 0;
    for (const Connection* connection : connections_) count += connection->uid() == uid ? 1 : 0;
    return count;
  }
  void CloseAll() {
    // The iterator advances first, since Close may remove the connection at once.
    for (auto connection = connections_.begin(); connection != connections_.end();)
      (*connection++)->Close();
  }
  // The oldest idle connection; nullptr if there is none.
  Connection* LongestIdle() const {
    for (Connection* connection : connections_) {
      if (connection->is_idle()) return connection;
    }
    return nullptr;
  }
  // The oldest idle connection of one user; nullptr if there is none.
  Connection* LongestIdleOf(std::optional<std::uint32_t> uid) const {
    for (Connection* connection : connections_) {
      if (connection->uid() == uid && connection->is_idle()) return connection;
    }
    return nullptr;
  }

  std::size_t sockets = 0;  // the number of connections that are WebSockets
  bool closed = false;      // no more connections are accepted

 private:
  friend class Connection;
  std::list<Connection*> connections_;
};

inline Connection::Connection(ConnectionList& list, std::optional<std::uint32_t> uid)
    : list_(list), uid_(uid), position_(list.connections_.insert(list.connections_.end(), this)) {}
inline Connection::~Connection() { list_.connections_.erase(position_); }

}  // namespace cwm::server
