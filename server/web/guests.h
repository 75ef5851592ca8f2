// The viewer's connections, so that their number is limited and a stopping server finds them all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <optional>

namespace cwm::server {

class Guests;

// A connection from its begin to its end. Used only on the viewer's thread.
class Guest {
 public:
  // `uid`: the user at the other end, if the kernel reports it (see PeerUid).
  Guest(Guests& guests, std::optional<std::uint32_t> uid);
  Guest(const Guest&) = delete;
  Guest& operator=(const Guest&) = delete;

  // Ends the connection soon; may be called again while it is ending.
  virtual void Leave() = 0;
  // True if no request is being answered.
  virtual bool waits() const = 0;
  std::optional<std::uint32_t> uid() const { return uid_; }

 protected:
  virtual ~Guest();

 private:
  Guests& guests_;
  const std::optional<std::uint32_t> uid_;
  const std::list<Guest*>::iterator place_;
};

class Guests {
 public:
  std::size_t size() const { return present_.size(); }
  // All connections of unknown users count as one user's.
  std::size_t CountOf(std::optional<std::uint32_t> uid) const {
    std::size_t count = 0;
    for (const Guest* guest : present_) count += guest->uid() == uid ? 1 : 0;
    return count;
  }
  void AllLeave() {
    // The iterator advances first, since Leave may remove the connection at once.
    for (auto guest = present_.begin(); guest != present_.end();) (*guest++)->Leave();
  }
  // The oldest idle connection; nullptr if there is none.
  Guest* LongestWaiting() const {
    for (Guest* guest : present_) {
      if (guest->waits()) return guest;
    }
    return nullptr;
  }
  // The oldest idle connection of one user; nullptr if there is none.
  Guest* LongestWaitingOf(std::optional<std::uint32_t> uid) const {
    for (Guest* guest : present_) {
      if (guest->uid() == uid && guest->waits()) return guest;
    }
    return nullptr;
  }

  std::size_t sockets = 0;  // the number of connections that are WebSockets
  bool closed = false;      // no more connections are accepted

 private:
  friend class Guest;
  std::list<Guest*> present_;
};

inline Guest::Guest(Guests& guests, std::optional<std::uint32_t> uid)
    : guests_(guests), uid_(uid), place_(guests.present_.insert(guests.present_.end(), this)) {}
inline Guest::~Guest() { guests_.present_.erase(place_); }

}  // namespace cwm::server
