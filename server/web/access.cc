#include "server/web/access.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <random>
#include <utility>
#include <vector>

#include <boost/asio/ip/address.hpp>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "server/net/may_connect.h"

namespace cwm::server {
namespace {

constexpr int kHttpPort = 80;  // the port of a Host without one
constexpr std::size_t kMinTokenLength = 16;
constexpr std::size_t kMaxTokenLength = 128;
constexpr std::string_view kTokenParameter = "token";

std::string_view View(boost::beast::string_view text) { return {text.data(), text.size()}; }

std::string Lower(std::string_view text) {
  return absl::AsciiStrToLower(absl::string_view(text.data(), text.size()));
}

// The address in a host, with or without brackets as in the Host header.
std::optional<boost::asio::ip::address> AddressIn(std::string_view host) {
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  }
  boost::system::error_code error;
  const auto address = boost::asio::ip::make_address(std::string(host), error);
  if (error) return std::nullopt;
  return address;
}

// True for an unspecified address: other hosts than this one lead here.
bool IsUnspecified(const std::string& host) {
  const auto address = AddressIn(host);
  return address && address->is_unspecified();
}

bool IsLoopback(const std::string& host) {
  const auto address = AddressIn(host);
  return address && address->is_loopback();
}

// True for names of loopback, which no stranger can own: on his machine they lead to that machine.
bool IsLoopbackName(const std::string& host) {
  return Lower(host) == "localhost" || IsLoopback(host);
}

// The field's value if the request has it exactly once.
std::optional<std::string_view> Only(const HttpRequest& request, http::field name) {
  if (request.count(name) != 1) return std::nullopt;
  return View(request[name]);
}

// The field's value or its absence, as text for people.
std::string Shown(const HttpRequest& request, http::field name) {
  constexpr std::size_t kShownBytes = 100;
  if (request.count(name) == 0) return "is absent";
  if (request.count(name) > 1) return "is there more than once";
  std::string text(View(request[name]).substr(0, kShownBytes));
  for (char& c : text) {
    if (!absl::ascii_isprint(static_cast<unsigned char>(c))) c = '?';
  }
  return absl::StrCat("is \"", text, "\"");
}

}  // namespace

Access::Access(ViewerAddress requested, ViewerAddress bound, std::string token, ThisMachine machine)
    : requested_(std::move(requested)),
      bound_(std::move(bound)),
      token_(std::move(token)),
      machine_(std::move(machine)) {}

std::vector<std::string> Access::Hosts() const {
  std::vector<std::string> hosts = {bound_.host, "localhost", "127.0.0.1", "::1"};
  const bool is_loopback = IsLoopback(bound_.host);
  if (!is_loopback || IsLoopbackName(requested_.host)) hosts.insert(hosts.begin(), requested_.host);
  if (!is_loopback) hosts.insert(hosts.end(), machine_.names.begin(), machine_.names.end());
  std::vector<std::string> with_port;
  for (const std::string& host : hosts) {
    if (IsUnspecified(host)) continue;  // an address to listen on, not to connect to
    const std::string name = Lower(ViewerAddress{host, bound_.port}.Text());
    if (std::find(with_port.begin(), with_port.end(), name) == with_port.end()) {
      with_port.push_back(name);
    }
  }
  return with_port;
}

std::optional<Access::Refusal> Access::CheckUser(std::optional<std::uint32_t> uid) const {
  const std::uint32_t own_uid = geteuid();
  if (!token_.empty() || MayConnect(uid, own_uid, /*allow_any_local_user=*/false)) {
    return std::nullopt;
  }
  return Refusal{.why = absl::StrCat(
                     "user: ", uid ? absl::StrCat("is ", *uid) : "is not told by the kernel",
                     ", must be ", own_uid,
                     " (who runs this cwm-server) or root; others look with a token: start "
                     "cwm-server with CWM_VIEWER_TOKEN=TOKEN and open the address that it prints")};
}

std::optional<Access::Refusal> Access::CheckHost(const HttpRequest& request) const {
  const std::vector<std::string> names = Hosts();
  std::string given;
  if (const auto host = Only(request, http::field::host)) given = Lower(*host);
  if (bound_.port == kHttpPort && given.find(':', given.rfind(']') + 1) == std::string::npos) {
    given += absl::StrCat(":", kHttpPort);
  }
  if (std::find(names.begin(), names.end(), given) != names.end()) return std::nullopt;
  // An address literal cannot be made to lead elsewhere, as a name can.
  const std::string port = absl::StrCat(":", bound_.port);
  std::string others;
  if (IsUnspecified(bound_.host)) others = absl::StrCat(", ADDRESS", port);
  if (IsLoopback(bound_.host)) others = absl::StrCat(", another of 127.0.0.0/8 with ", port);
  if (!others.empty() && absl::EndsWith(given, port)) {
    const auto address = AddressIn(std::string_view(given).substr(0, given.size() - port.size()));
    if (address && (IsUnspecified(bound_.host) || (address->is_v4() && address->is_loopback()))) {
      return std::nullopt;
    }
  }
  return Refusal{.why = absl::StrCat("Host: ", Shown(request, http::field::host),
                                     ", must be one of ", absl::StrJoin(names, ", "), others)};
}

std::optional<Access::Refusal> Access::CheckOrigin(const HttpRequest& request) {
  if (request.count(http::field::origin) == 0) return std::nullopt;
  const auto host = Only(request, http::field::host);
  const auto origin = Only(request, http::field::origin);
  const std::string own = absl::StrCat("http://", Lower(host.value_or("")));
  if (host && origin && Lower(*origin) == own) return std::nullopt;
  return Refusal{
      .why = absl::StrCat("Origin: ", Shown(request, http::field::origin), ", must be ", own)};
}

std::optional<Access::Refusal> Access::CheckToken(const HttpRequest& request) const {
  if (token_.empty()) return std::nullopt;
  const std::string_view target = View(request.target());
  const auto given = PathOf(target) == "/" ? ParameterOf(target, kTokenParameter) : std::nullopt;
  if (given) {
    if (EqualInConstantTime(*given, token_)) return std::nullopt;
    return Refusal{.why = "token: is wrong; open the address that cwm-server printed"};
  }
  const std::string name = CookieName();
  bool has_cookie = false;
  const auto range = request.equal_range(http::field::cookie);
  for (auto field = range.first; field != range.second; ++field) {
    std::string_view rest = View(field->value());
    while (!rest.empty()) {
      const std::size_t end = std::min(rest.find(';'), rest.size());
      std::string_view pair = rest.substr(0, end);
      rest.remove_prefix(std::min(end + 1, rest.size()));
      pair.remove_prefix(std::min(pair.find_first_not_of(' '), pair.size()));
      const std::size_t equals = pair.find('=');
      if (equals == std::string_view::npos || pair.substr(0, equals) != name) continue;
      if (EqualInConstantTime(pair.substr(equals + 1), token_)) return std::nullopt;
      has_cookie = true;
    }
  }
  return Refusal{.why = absl::StrCat("token: is ",
                                     has_cookie ? "not that of this server any more" : "absent",
                                     "; open the address that cwm-server printed")};
}

std::optional<std::string> Access::CookieFor(const HttpRequest& request) const {
  if (token_.empty()) return std::nullopt;
  const std::string_view target = View(request.target());
  const auto given = ParameterOf(target, kTokenParameter);
  if (PathOf(target) != "/" || !given || !EqualInConstantTime(*given, token_)) return std::nullopt;
  return absl::StrCat(CookieName(), "=", token_, "; Path=/; HttpOnly; SameSite=Strict");
}

std::vector<std::string> Access::Urls() const {
  std::vector<std::string> hosts;
  if (!IsUnspecified(bound_.host)) {
    const bool is_let_in = !IsLoopback(bound_.host) || IsLoopbackName(requested_.host);
    hosts = {is_let_in ? requested_.host : bound_.host};
  } else {
    // A listener on IPv4 is not reachable at the IPv6 addresses.
    const bool is_v4 = bound_.host.find(':') == std::string::npos;
    for (const std::string& address : machine_.addresses) {
      if (!is_v4 || address.find(':') == std::string::npos) hosts.push_back(address);
    }
    if (!machine_.names.empty()) hosts.push_back(machine_.names.front());
    if (hosts.empty()) hosts = {is_v4 ? "127.0.0.1" : "::1"};
  }
  std::vector<std::string> urls;
  for (const std::string& host : hosts) {
    const std::string base =
        absl::StrCat("http://", ViewerAddress{.host = host, .port = bound_.port}.Text(), "/");
    urls.push_back(token_.empty() ? base : absl::StrCat(base, "?token=", token_));
  }
  return urls;
}

// The name includes the port, since all ports of a host share their cookies.
std::string Access::CookieName() const { return absl::StrCat("cwm_viewer_", bound_.port); }

std::string RandomToken() {
  std::random_device bits;
  std::string token;
  for (int i = 0; i < 4; ++i) absl::StrAppendFormat(&token, "%08x", bits());
  return token;
}

bool IsToken(std::string_view text) {
  const auto allowed = [](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-';
  };
  return text.size() >= kMinTokenLength && text.size() <= kMaxTokenLength &&
         std::all_of(text.begin(), text.end(), allowed);
}

bool EqualInConstantTime(std::string_view given, std::string_view secret) {
  if (given.size() != secret.size()) return false;
  volatile unsigned char different = 0;
  for (std::size_t i = 0; i < secret.size(); ++i) {
    different = static_cast<unsigned char>(different | (given[i] ^ secret[i]));
  }
  return different == 0;
}

std::string_view PathOf(std::string_view target) {
  return target.substr(0, std::min(target.find('?'), target.size()));
}

std::optional<std::string_view> ParameterOf(std::string_view target, std::string_view name) {
  const std::size_t question_mark = target.find('?');
  if (question_mark == std::string_view::npos) return std::nullopt;
  std::string_view rest = target.substr(question_mark + 1);
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find('&'), rest.size());
    const std::string_view pair = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    const std::size_t equals = pair.find('=');
    if (equals != std::string_view::npos && pair.substr(0, equals) == name) {
      return pair.substr(equals + 1);
    }
  }
  return std::nullopt;
}

}  // namespace cwm::server
