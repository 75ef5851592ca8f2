// Speaks HTTP and WebSocket to a port of this machine, as rudely as a test wants. Nothing here waits
// for longer than it is told.
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

struct HttpAnswer {
  int status = 0;                             // 0: none came
  std::map<std::string, std::string> fields;  // by name in lower case
  std::string body;
};

// A connection of bytes.
class RawConnection {
 public:
  explicit RawConnection(int port);

  // False when the other side takes no more, or took nothing for that long.
  bool Send(const std::string& bytes,
            std::chrono::milliseconds patience = std::chrono::seconds(10));
  // The next answer on the connection; `to_head`: one without a body.
  HttpAnswer Receive(bool to_head = false,
                     std::chrono::milliseconds patience = std::chrono::seconds(20));
  // Reads so many bytes at most, of whatever comes next: how many there were.
  std::size_t Take(std::size_t most, std::chrono::milliseconds patience = std::chrono::seconds(10));
  // Whether the other side ends the connection within that time; what it sends is dropped.
  bool Ends(std::chrono::milliseconds patience);

 private:
  boost::asio::io_context context_;
  boost::asio::ip::tcp::socket socket_;
  boost::beast::flat_buffer buffer_;
};

// "GET TARGET HTTP/1.1" with these fields; Host is the port's own where none is given.
std::string RequestText(int port, const std::string& method, const std::string& target,
                        HttpFields fields = {});
// On a connection of its own.
HttpAnswer Ask(int port, const std::string& target, const HttpFields& fields = {},
               const std::string& method = "GET");

struct WebSocketOptions {
  HttpFields fields = {};
  std::optional<int> receive_bytes = {};  // of the kernel's buffer
};

class WebSocketClient {
 public:
  explicit WebSocketClient(int port, WebSocketOptions options = {});

  // Of the upgrade: 101 when it is one.
  int status() const { return status_; }

  bool Send(const std::string& message) { return Write(message, true); }
  bool SendText(const std::string& message) { return Write(message, false); }
  // The next message; nothing when none came, or when the socket was closed.
  std::optional<std::string> Read(std::chrono::milliseconds patience = std::chrono::seconds(20));

  // Once Read found the socket closed: 0 when nothing was said.
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
