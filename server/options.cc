#include "server/options.h"

#include <CLI/CLI.hpp>

#include "proto/transfer/default_address.h"

namespace cwm::server {
namespace {

constexpr int kUsageExitCode = 1;  // as the command line's

}  // namespace

ParsedOptions ParseOptions(int argc, const char* const* argv) {
  CLI::App app("Collision world model server: point clouds in, geometric answers out",
               "cwm-server");
  app.footer(
      "Example: cwm-server --listen unix:/tmp/cwm.sock --listen 127.0.0.1:50051\n"
      "SIGTERM and SIGINT end it within 10 s: what is under way is finished first.");
  Options options;
  std::string store = "memory";
  app.add_option(
         "--listen", options.listen,
         "unix:PATH or HOST:PORT of loopback; may be given several times; default $CWM_ADDR, "
         "else unix:${XDG_RUNTIME_DIR:-/tmp}/cwm-$UID.sock")
      ->type_name("ADDRESS");
  app.add_option("--store", store, "where worlds are kept")
      ->check(CLI::IsMember({"memory"}))
      ->capture_default_str();
  app.add_option("--log-level", options.log_level, "what is told on stderr")
      ->check(CLI::IsMember({"debug", "info", "warn", "error", "off"}))
      ->capture_default_str();
  app.set_version_flag("--version", std::string("cwm-server ") + CWM_VERSION);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return {.options = std::nullopt, .exit_code = code == 0 ? 0 : kUsageExitCode};
  }
  if (options.listen.empty()) options.listen.push_back(DefaultAddress());
  return {.options = std::move(options), .exit_code = 0};
}

}  // namespace cwm::server
