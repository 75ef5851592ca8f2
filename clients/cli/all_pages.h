// Reads paged lists completely.
#pragma once

#include "absl/status/statusor.h"
#include "clients/cli/session.h"

namespace cwm::cli {

// Requests all pages, each with the token of the previous one, and returns them as one reply.
template <class Response, class Method, class Stub, class Request>
absl::StatusOr<Response> ListAllPages(Session& session, Method method, Stub& stub,
                                      Request request) {
  Response all;
  do {
    const auto page = session.connection().Call(method, stub, request);
    if (!page.ok()) return page.status();
    request.set_page_token(page->next_page_token());
    all.MergeFrom(*page);
  } while (!request.page_token().empty());
  all.clear_next_page_token();
  return all;
}

}  // namespace cwm::cli
