// The kinds of messages that this folder reads and writes.
#pragma once

#include <boost/asio/buffer.hpp>
#include <boost/beast/core/error.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/optional.hpp>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

namespace cwm::server {

namespace http = boost::beast::http;

// What a reply says: a text of its own, or a file that lives as long as the process, of which a
// crowd of slow readers holds no copies.
struct ReplyBody {
  struct value_type {
    std::string text = {};
    std::string_view file = {};

    std::string_view bytes() const { return file.empty() ? std::string_view(text) : file; }
  };

  static std::uint64_t size(const value_type& body) { return body.bytes().size(); }

  // As Beast's serializer asks for it.
  class writer {
   public:
    using const_buffers_type = boost::asio::const_buffer;

    template <bool isRequest, class Fields>
    writer(const http::header<isRequest, Fields>&, const value_type& body) : body_(body) {}

    void init(boost::beast::error_code& error) { error = {}; }
    boost::optional<std::pair<const_buffers_type, bool>> get(boost::beast::error_code& error) {
      error = {};
      const std::string_view bytes = body_.bytes();
      return {{const_buffers_type(bytes.data(), bytes.size()), false}};
    }

   private:
    const value_type& body_;
  };
};

using HttpRequest = http::request<http::empty_body>;
using HttpReply = http::response<ReplyBody>;

}  // namespace cwm::server
