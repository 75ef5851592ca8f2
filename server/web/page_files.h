// The viewer's page, bundled from clients/web/src/viewer when this was built.
#pragma once

#include <string_view>

namespace cwm::server {

// Texts that live as long as the process; empty where the page has none of the kind.
struct PageFiles {
  std::string_view page;    // of "/"
  std::string_view script;  // of "/viewer.js"
  std::string_view worker;  // of "/worker.js"
  std::string_view style;   // of "/style.css"
};

// Of a library of its own (cwm_viewer_page): only what links it is built with Node.
PageFiles BundledPage();

}  // namespace cwm::server
