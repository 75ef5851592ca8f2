#include "server/web/viewer_server.h"

#include <spdlog/spdlog.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/v6_only.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <exception>
#include <optional>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/net/peer_uid.h"
#include "server/web/http_connection.h"
#include "server/web/viewer_context.h"

namespace cwm::server {
namespace {

using boost::asio::ip::tcp;
using boost::system::error_code;

// chosen: if no file descriptor is free for a connection, one may be free after this time.
constexpr auto kAcceptRetryDelay = std::chrono::milliseconds(100);

absl::Status CannotListen(const ViewerAddress& address, const error_code& error) {
  const std::string what = absl::StrCat("--viewer ", address.Text(), ": ", error.message());
  return error == boost::asio::error::address_in_use ? absl::AlreadyExistsError(what)
                                                     : absl::UnavailableError(what);
}

absl::StatusOr<tcp::endpoint> Resolve(boost::asio::io_context& context,
                                      const ViewerAddress& address) {
  error_code error;
  const auto found = tcp::resolver(context).resolve(address.host, std::to_string(address.port),
                                                    tcp::resolver::passive, error);
  if (error) return CannotListen(address, error);
  return found.begin()->endpoint();
}

absl::StatusOr<tcp::acceptor> Listen(boost::asio::io_context& context,
                                     const ViewerAddress& address) {
  const auto endpoint = Resolve(context, address);
  if (!endpoint.ok()) return endpoint.status();
  tcp::acceptor acceptor(context);
  error_code error;
  acceptor.open(endpoint->protocol(), error);
  if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error && endpoint->address().is_v6() && endpoint->address().is_unspecified()) {
    // All interfaces include IPv4, even if the system's default differs (bindv6only).
    acceptor.set_option(boost::asio::ip::v6_only(false), error);
  }
  if (!error) acceptor.bind(*endpoint, error);
  if (!error) acceptor.listen(boost::asio::socket_base::max_listen_connections, error);
  if (error) return CannotListen(address, error);
  return acceptor;
}

}  // namespace

struct ViewerServer::State {
  State(std::unique_ptr<boost::asio::io_context> context_in, tcp::acceptor acceptor_in,
        const ViewerLimits& limits, Site site, const std::shared_ptr<grpc::Channel>& services)
      : context(std::move(context_in)),
        viewer{.limits = limits,
               .site = std::move(site),
               .bridge = {*context, grpc::GenericStub(services)}},
        acceptor(std::move(acceptor_in)),
        pause(*context),
        urls(viewer.site.access().Urls()) {
    AcceptNext();
    thread = std::thread([this] { Run(); });
  }

  void Run() {
    for (;;) {
      try {
        context->run();
        return;
      } catch (const std::exception& error) {  // of one connection, which ends with it
        spdlog::error("viewer: {}", error.what());
      }
    }
  }

  void AcceptNext() {
    acceptor.async_accept([this](error_code error, tcp::socket socket) {
      if (viewer.connections.closed) return;
      if (!error) {
        StartConnection(std::move(socket));
        return AcceptNext();
      }
      pause.expires_after(kAcceptRetryDelay);
      pause.async_wait([this](error_code) {
        if (!viewer.connections.closed) AcceptNext();
      });
    });
  }

  // A connection above a limit replaces the oldest idle one, of the same user if that user has too
  // many. If none is idle, the new connection is closed.
  void StartConnection(tcp::socket socket) {
    const std::optional<std::uint32_t> uid = PeerUid(socket.native_handle());
    const bool user_has_too_many =
        viewer.connections.CountOf(uid) >= viewer.limits.connections_of_user;
    if (user_has_too_many || viewer.connections.size() >= viewer.limits.connections) {
      Connection* const idle = user_has_too_many ? viewer.connections.LongestIdleOf(uid)
                                                 : viewer.connections.LongestIdle();
      if (idle == nullptr) return;
      idle->Close();
    }
    std::make_shared<HttpConnection>(std::move(socket), uid, viewer)->ReadRequest();
  }

  void Close() {
    viewer.connections.closed = true;
    error_code ignored;
    acceptor.close(ignored);
    pause.cancel();
    viewer.connections.CloseAll();
  }

  const std::unique_ptr<boost::asio::io_context> context;
  ViewerContext viewer;
  tcp::acceptor acceptor;
  boost::asio::steady_timer pause;
  const std::vector<std::string> urls;
  std::thread thread;
};

absl::StatusOr<std::unique_ptr<ViewerServer>> ViewerServer::Start(
    const ViewerOptions& options, const std::shared_ptr<grpc::Channel>& services) {
  if (!options.token.empty() && !IsToken(options.token)) {
    return absl::InvalidArgumentError(
        absl::StrCat("CWM_VIEWER_TOKEN: has ", options.token.size(),
                     " characters, must be 16 to 128 letters, digits, _ and -"));
  }
  auto context = std::make_unique<boost::asio::io_context>(1);
  auto acceptor = Listen(*context, options.address);
  if (!acceptor.ok()) return acceptor.status();
  const tcp::endpoint endpoint = acceptor->local_endpoint();
  const ViewerAddress bound{.host = endpoint.address().to_string(), .port = endpoint.port()};
  std::string token = options.token;
  if (token.empty() && !endpoint.address().is_loopback()) token = RandomToken();
  Site site(Access(options.address, bound, std::move(token), LookUpThisMachine()), options.files);
  return std::unique_ptr<ViewerServer>(new ViewerServer(std::make_unique<State>(
      std::move(context), *std::move(acceptor), options.limits, std::move(site), services)));
}

ViewerServer::ViewerServer(std::unique_ptr<State> state) : state_(std::move(state)) {}

ViewerServer::~ViewerServer() { Stop(); }

const std::vector<std::string>& ViewerServer::urls() const { return state_->urls; }

void ViewerServer::Stop() {
  if (!state_->thread.joinable()) return;
  boost::asio::post(*state_->context, [this] { state_->Close(); });
  state_->thread.join();
}

}  // namespace cwm::server
