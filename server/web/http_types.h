// The HTTP message types of this folder.
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

// The body of a reply: a text of its own, or a file that lives as long as the process and is not
// copied for each reader.
struct ReplyBody {
  struct value_type {
    std::string text = {};
    std::string_view file = {};

    std::string_view bytes() const { return file.empty() ? std::string_view(text) : file; }
  };

  static std::uint64_t size(const value_type& body) { return body.bytes().size(); }

  // The interface that Beast's serializer requires.
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
