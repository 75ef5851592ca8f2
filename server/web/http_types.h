// The kinds of messages that this folder reads and writes.
#pragma once

#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>

namespace cwm::server {

namespace http = boost::beast::http;

using HttpRequest = http::request<http::empty_body>;
using HttpReply = http::response<http::string_body>;

}  // namespace cwm::server
