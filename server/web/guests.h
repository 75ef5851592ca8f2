// Who is connected, so that there are not too many and a stopping server finds them all.
#pragma once

#include <cstddef>
#include <list>

namespace cwm::server {

class Guests;

// A connection, from its begin to its end. On the viewer's thread alone.
class Guest {
 public:
  explicit Guest(Guests& guests);
  Guest(const Guest&) = delete;
  Guest& operator=(const Guest&) = delete;

  // Ends soon; no harm when it is ending already.
  virtual void Leave() = 0;
  // Nothing was asked of which the answer is not given.
  virtual bool waits() const = 0;

 protected:
  virtual ~Guest();

 private:
  Guests& guests_;
  const std::list<Guest*>::iterator place_;
};

class Guests {
 public:
  std::size_t size() const { return present_.size(); }
  void AllLeave() {
    // One that leaves may end at once.
    for (auto guest = present_.begin(); guest != present_.end();) (*guest++)->Leave();
  }
  // The one that came first of those that wait; nullptr when there is none.
  Guest* LongestWaiting() const {
    for (Guest* guest : present_) {
      if (guest->waits()) return guest;
    }
    return nullptr;
  }

  std::size_t sockets = 0;  // of those, WebSockets
  bool closed = false;      // nobody comes any more

 private:
  friend class Guest;
  std::list<Guest*> present_;
};

inline Guest::Guest(Guests& guests)
    : guests_(guests), place_(guests.present_.insert(guests.present_.end(), this)) {}
inline Guest::~Guest() { guests_.present_.erase(place_); }

}  // namespace cwm::server
