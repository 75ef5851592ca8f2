// Speaks HTTP and WebSocket to a local port, and can break their rules. No function waits longer
// than its argument says.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace cwm::testing {

using HttpFields = std::vector<std::pair<std::string, std::string>>;

struct HttpResponse {
  int status = 0;                             // 0: no answer
  std::map<std::string, std::string> fields;  // by name in lower case
  std::string body;
};

// A connection for bytes.
class RawConnection {
 public:
  explicit RawConnection(int port);

  // False if the other side accepts no more, or accepted nothing for that long.
  bool Send(const std::string& bytes,
            std::chrono::milliseconds patience = std::chrono::seconds(10));
  // The next answer on the connection; with `to_head` an answer without a body.
  HttpResponse Receive(bool to_head = false,
                       std::chrono::milliseconds patience = std::chrono::seconds(20));
  // Reads up to `max_bytes` bytes, and returns their number.
  std::size_t Take(std::size_t max_bytes,
                   std::chrono::milliseconds patience = std::chrono::seconds(10));
  // True if the other side ends the connection within that time; its bytes are dropped.
  bool Ends(std::chrono::milliseconds patience);

 private:
  boost::asio::io_context context_;
  boost::asio::ip::tcp::socket socket_;
  boost::beast::flat_buffer buffer_;
};

// "GET TARGET HTTP/1.1" with these fields; Host is that of the port if it is not given.
std::string RequestText(int port, const std::string& method, const std::string& target,
                        HttpFields fields = {});
// Sends a request on a connection of its own.
HttpResponse SendRequest(int port, const std::string& target, const HttpFields& fields = {},
                         const std::string& method = "GET");

struct WebSocketOptions {
  HttpFields fields = {};
  std::optional<int> receive_bytes = {};  // size of the kernel's buffer
};

class WebSocketClient {
 public:
  explicit WebSocketClient(int port, WebSocketOptions options = {});

  // The status of the upgrade; 101 if it succeeded.
  int status() const { return status_; }

  bool Send(const std::string& message) { return Write(message, true); }
  bool SendText(const std::string& message) { return Write(message, false); }
  // The next message; empty if none came, or if the socket was closed.
  std::optional<std::string> Read(std::chrono::milliseconds patience = std::chrono::seconds(20));

  // Valid once Read found the socket closed; the code is 0 if the other side gave none.
  bool closed() const { return closed_; }
  int close_code() const { return stream_.reason().code; }
  std::string close_reason() const { return stream_.reason().reason.c_str(); }

 private:
  bool Write(const std::string& message, bool is_binary);

  boost::asio::io_context context_;
  boost::beast::websocket::stream<boost::asio::ip::tcp::socket> stream_;
  boost::beast::flat_buffer buffer_;
  int status_ = 0;
  bool reading_ = false;
  bool read_ = false;
  bool closed_ = false;
};

}  // namespace cwm::testing
