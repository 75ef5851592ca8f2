// Decides who may view the world. A stranger's page in the user's own browser may not, whatever
// name it uses for this machine; nor may another user of this machine, or anybody on a network,
// without the token.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/web/http_types.h"
#include "server/web/this_machine.h"
#include "server/web/viewer_address.h"

namespace cwm::server {

class Access {
 public:
  // `requested` is the host that the user gave, `bound` the address that the server listens on. If
  // `token` is empty, none is needed, and only this process's user and root are admitted.
  Access(ViewerAddress requested, ViewerAddress bound, std::string token, ThisMachine machine = {});

  struct Refusal {
    http::status status = http::status::forbidden;
    std::string why;
  };

  // If there is no token, the user of any connection must be this process's user or root (see
  // PeerUid for `uid`).
  std::optional<Refusal> CheckUser(std::optional<std::uint32_t> uid) const;
  // For any request: Host must name this server, so that a foreign name that leads here (DNS
  // rebinding) does not make it the same site as a stranger's page. On loopback only localhost and
  // the loopback addresses are allowed, since no token protects against somebody who took this
  // machine's name in the user's network. Otherwise also the host that was asked for, the address
  // it led to, and this machine's names; if all interfaces are listened on, any address literal,
  // since it cannot be made to lead elsewhere.
  std::optional<Refusal> CheckHost(const HttpRequest& request) const;
  // For requests that open a WebSocket: browsers let any page open one, but send the page's Origin.
  // Programs send none.
  static std::optional<Refusal> CheckOrigin(const HttpRequest& request);
  // The token must be given as a parameter of the page's own address, or as the cookie that was set
  // in reply.
  std::optional<Refusal> CheckToken(const HttpRequest& request) const;

  // The value of Set-Cookie for a request with the token in its address; otherwise empty.
  std::optional<std::string> CookieFor(const HttpRequest& request) const;

  // The addresses for users to open, the best first; all of them are admitted. If all interfaces
  // are listened on, they have this machine's addresses and name.
  std::vector<std::string> Urls() const;

 private:
  std::string CookieName() const;
  std::vector<std::string> Hosts() const;  // always admitted; with the port

  const ViewerAddress requested_;
  const ViewerAddress bound_;
  const std::string token_;
  const ThisMachine machine_;
};

// 128 random bits as hex.
std::string RandomToken();
// The rule for tokens that users choose: 16 to 128 letters, digits, _ and -.
bool IsToken(std::string_view text);
// Compares in a time that does not reveal how much of the secret is right.
bool EqualInConstantTime(std::string_view given, std::string_view secret);

// The path of a target, and the value of a parameter of its query.
std::string_view PathOf(std::string_view target);
std::optional<std::string_view> ParameterOf(std::string_view target, std::string_view name);

}  // namespace cwm::server
