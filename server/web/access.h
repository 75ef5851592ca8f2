// Who may look. A page of a stranger that runs in the user's own browser may not, whatever name it
// gives to this machine; nor may another user of this machine, or anybody on a network, without the
// token.
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
  // `asked` is the host that the user gave, `bound` where the server listens for it. An empty
  // token: none is needed, and only this process's user and root are let in.
  Access(ViewerAddress asked, ViewerAddress bound, std::string token, ThisMachine machine = {});

  struct Refusal {
    http::status status = http::status::forbidden;
    std::string why;
  };

  // Without a token, the user of any connection must be this process's or root (see PeerUid for
  // `uid`).
  std::optional<Refusal> CheckUser(std::optional<std::uint32_t> uid) const;
  // Of any request: Host must be this server, so that no foreign name that leads here (DNS
  // rebinding) makes it one site with a stranger's page. On loopback that is localhost and the
  // addresses of loopback alone: no token keeps out who took a name of this machine in the user's
  // network. Elsewhere it is also the host that was asked for, where it led, and a name of this
  // machine; where all interfaces are listened on, any address, which no stranger can make lead
  // elsewhere.
  std::optional<Refusal> CheckHost(const HttpRequest& request) const;
  // Of what opens a socket: browsers let any page open one and say whose page it is. Programs say
  // nothing.
  static std::optional<Refusal> CheckOrigin(const HttpRequest& request);
  // The token, as a parameter of the page's own address or as the cookie that it was given for
  // that.
  std::optional<Refusal> CheckToken(const HttpRequest& request) const;

  // The value of Set-Cookie for a request that gave the token in its address; else nothing.
  std::optional<std::string> CookieFor(const HttpRequest& request) const;

  // What users open, the best first, each of them let in: where all interfaces are listened on, by
  // this machine's addresses and name.
  std::vector<std::string> Urls() const;

 private:
  std::string CookieName() const;
  std::vector<std::string> Hosts() const;  // that are always let in, with the port

  const ViewerAddress asked_;
  const ViewerAddress bound_;
  const std::string token_;
  const ThisMachine machine_;
};

// 128 random bits as hex.
std::string RandomToken();
// The rule for tokens that users choose: 16 to 128 letters, digits, _ and -.
bool IsToken(std::string_view text);
// In a time that does not tell how much of it is right.
bool SameSecret(std::string_view given, std::string_view secret);

// The path of a target, and the value of a parameter of its query.
std::string_view PathOf(std::string_view target);
std::optional<std::string_view> ParameterOf(std::string_view target, std::string_view name);

}  // namespace cwm::server
