// The viewer's page, bundled from clients/web/src/viewer at build time.
#pragma once

#include <string_view>

namespace cwm::server {

// A text, and the same compressed by gzip if available.
struct PageFile {
  std::string_view bytes;
  std::string_view gzip = {};
};

// Files that live as long as the process; empty if the page has none of the kind.
struct PageFiles {
  PageFile page = {};    // served at "/"
  PageFile script = {};  // served at "/viewer.js"
  PageFile worker = {};  // served at "/worker.js"
  PageFile style = {};   // served at "/style.css"
};

// Defined in a library of its own (cwm_viewer_page), so that only targets that link it need Node.
PageFiles BundledPage();

}  // namespace cwm::server
