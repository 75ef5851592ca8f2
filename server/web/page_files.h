// The viewer's page, bundled from clients/web/src/viewer when this was built.
#pragma once

#include <string_view>

namespace cwm::server {

// A text and the same by gzip, where that was made.
struct PageFile {
  std::string_view bytes;
  std::string_view gzip = {};
};

// What lives as long as the process; empty where the page has none of the kind.
struct PageFiles {
  PageFile page = {};    // of "/"
  PageFile script = {};  // of "/viewer.js"
  PageFile worker = {};  // of "/worker.js"
  PageFile style = {};   // of "/style.css"
};

// Of a library of its own (cwm_viewer_page): only what links it is built with Node.
PageFiles BundledPage();

}  // namespace cwm::server
