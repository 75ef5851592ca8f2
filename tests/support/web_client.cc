#include "tests/support/web_client.h"

#include <algorithm>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/http.hpp>
#include <cctype>
#include <utility>

namespace cwm::testing {
namespace {

namespace http = boost::beast::http;
using boost::beast::error_code;

boost::asio::ip::tcp::endpoint Endpoint(int port) {
  return {boost::asio::ip::address_v4::loopback(), static_cast<unsigned short>(port)};
}

std::string Lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// True if `done` became true in time.
bool RunUntil(boost::asio::io_context& context, const bool& done,
              std::chrono::milliseconds patience) {
  const auto end = std::chrono::steady_clock::now() + patience;
  context.restart();
  while (!done && std::chrono::steady_clock::now() < end) {
    if (context.run_one_until(end) == 0) break;
  }
  return done;
}

}  // namespace

RawConnection::RawConnection(int port) : socket_(context_) { socket_.connect(Endpoint(port)); }

bool RawConnection::Send(const std::string& bytes, std::chrono::milliseconds patience) {
  bool done = false;
  error_code failed;
  boost::asio::async_write(socket_, boost::asio::buffer(bytes), [&](error_code error, std::size_t) {
    done = true;
    failed = error;
  });
  if (RunUntil(context_, done, patience)) return !failed;
  socket_.cancel();
  RunUntil(context_, done, std::chrono::seconds(1));
  return false;
}

HttpResponse RawConnection::Receive(bool to_head, std::chrono::milliseconds patience) {
  http::response_parser<http::string_body> parser;
  parser.body_limit(std::uint64_t{1} << 30);
  parser.skip(to_head);
  bool done = false;
  error_code failed;
  http::async_read(socket_, buffer_, parser, [&](error_code error, std::size_t) {
    done = true;
    failed = error;
  });
  if (!RunUntil(context_, done, patience)) {
    socket_.cancel();
    RunUntil(context_, done, std::chrono::seconds(1));
    return {};
  }
  if (failed) return {};
  HttpResponse answer;
  const auto message = parser.release();
  answer.status = static_cast<int>(message.result_int());
  for (const auto& field : message) {
    answer.fields[Lower(std::string(field.name_string()))] = std::string(field.value());
  }
  answer.body = message.body();
  return answer;
}

std::size_t RawConnection::Take(std::size_t max_bytes, std::chrono::milliseconds patience) {
  std::string taken(max_bytes, '\0');
  bool done = false;
  std::size_t count = 0;
  socket_.async_read_some(boost::asio::buffer(taken), [&](error_code, std::size_t read) {
    done = true;
    count = read;
  });
  if (RunUntil(context_, done, patience)) return count;
  socket_.cancel();
  RunUntil(context_, done, std::chrono::seconds(1));
  return count;
}

bool RawConnection::Ends(std::chrono::milliseconds patience) {
  const auto end = std::chrono::steady_clock::now() + patience;
  std::string trash(1 << 16, '\0');
  for (;;) {
    bool done = false;
    error_code failed;
    socket_.async_read_some(boost::asio::buffer(trash), [&](error_code error, std::size_t) {
      done = true;
      failed = error;
    });
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        end - std::chrono::steady_clock::now());
    if (!RunUntil(context_, done, left)) {
      socket_.cancel();
      RunUntil(context_, done, std::chrono::seconds(1));
      return false;
    }
    if (failed) return true;
  }
}

std::string RequestText(int port, const std::string& method, const std::string& target,
                        HttpFields fields) {
  const bool has_host = std::any_of(fields.begin(), fields.end(),
                                    [](const auto& field) { return Lower(field.first) == "host"; });
  if (!has_host) fields.emplace_back("Host", "127.0.0.1:" + std::to_string(port));
  std::string text = method + " " + target + " HTTP/1.1\r\n";
  for (const auto& [name, value] : fields) text += name + ": " + value + "\r\n";
  return text + "\r\n";
}

HttpResponse SendRequest(int port, const std::string& target, const HttpFields& fields,
                         const std::string& method) {
  RawConnection connection(port);
  if (!connection.Send(RequestText(port, method, target, fields))) return {};
  return connection.Receive(method == "HEAD");
}

WebSocketClient::WebSocketClient(int port, WebSocketOptions options) : stream_(context_) {
  auto& socket = stream_.next_layer();
  socket.open(boost::asio::ip::tcp::v4());
  if (options.receive_bytes) {
    socket.set_option(boost::asio::socket_base::receive_buffer_size(*options.receive_bytes));
  }
  socket.connect(Endpoint(port));
  stream_.read_message_max(std::size_t{64} << 20);
  stream_.set_option(boost::beast::websocket::stream_base::decorator(
      [&options](boost::beast::websocket::request_type& request) {
        for (const auto& [name, value] : options.fields) request.set(name, value);
      }));
  boost::beast::websocket::response_type response;
  error_code failed;
  bool done = false;
  stream_.async_handshake(response, "127.0.0.1:" + std::to_string(port), "/socket",
                          [&](error_code error) {
                            done = true;
                            failed = error;
                          });
  RunUntil(context_, done, std::chrono::seconds(20));
  status_ = done ? static_cast<int>(response.result_int()) : 0;
  closed_ = status_ != 101;
}

bool WebSocketClient::Write(const std::string& message, bool is_binary) {
  stream_.binary(is_binary);
  bool done = false;
  error_code failed;
  stream_.async_write(boost::asio::buffer(message), [&](error_code error, std::size_t) {
    done = true;
    failed = error;
  });
  if (RunUntil(context_, done, std::chrono::seconds(10))) return !failed;
  stream_.next_layer().close();
  RunUntil(context_, done, std::chrono::seconds(1));
  closed_ = true;
  return false;
}

std::optional<std::string> WebSocketClient::Read(std::chrono::milliseconds patience) {
  if (closed_) return std::nullopt;
  if (!reading_) {
    reading_ = true;
    read_ = false;
    stream_.async_read(buffer_, [this](error_code error, std::size_t) {
      reading_ = false;
      read_ = true;
      if (error) closed_ = true;
    });
  }
  if (!RunUntil(context_, read_, patience) || closed_) return std::nullopt;
  read_ = false;
  std::string message(static_cast<const char*>(buffer_.data().data()), buffer_.size());
  buffer_.consume(buffer_.size());
  return message;
}

}  // namespace cwm::testing
