#include "server/options.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <string_view>

#include "manual/manual_page.h"
#include "proto/transfer/default_address.h"

namespace cwm::server {
namespace {

constexpr char kDescription[] =
    "cwm-server: a collision world model server, point clouds in, geometric answers out\n\n"
    "Examples:\n"
    "  cwm-server                                 for this user's programs; viewer on port 8640\n"
    "  cwm-server --listen unix:/tmp/cwm.sock --listen 127.0.0.1:50051\n"
    "  cwm-server --viewer 0.0.0.0:8640           who has the printed token looks from "
    "anywhere\n"
    "  cwm-server --store sqlite:/var/lib/cwm     worlds outlive the server and a power cut\n\n"
    "Without --listen its socket lies where this user and root alone can put one:\n"
    "XDG_RUNTIME_DIR, which others must not be able to write to, else /tmp/cwm-$UID,\n"
    "which it makes (mode 0700). On loopback the viewer is for this user and root;\n"
    "CWM_VIEWER_TOKEN chooses its token, and then whoever has that looks, here too.\n"
    "SIGTERM and SIGINT end it within 10 s: what is under way is finished first.";

// Interpreting a scan of 640 x 480 points takes about 40 MiB.
constexpr std::int64_t kMinMemoryLimit = std::int64_t{64} << 20;

constexpr char kMemory[] = "memory";

constexpr int kUsageExitCode = 1;  // the command-line client's exit code for a usage error

// Sets options.viewer. Returns an empty string, or the error message if the text is invalid.
std::string ParseViewer(const std::string& text, Options& options) {
  if (text == "off") {
    options.viewer.reset();
    return {};
  }
  auto address = ParseViewerAddress(text);
  if (!address.ok()) return std::string(address.status().message());
  const char* const token = std::getenv("CWM_VIEWER_TOKEN");
  options.viewer =
      Options::Viewer{.address = *std::move(address), .token = token == nullptr ? "" : token};
  return {};
}

// Sets the directory. Returns an empty string, or the error message if the text is invalid.
std::string ParseStore(const std::string& text, Options::Store& store) {
  constexpr std::string_view kSqlite = "sqlite:";
  if (text != kMemory) {
    if (!text.starts_with(kSqlite) || text.size() == kSqlite.size()) {
      return "--store: \"" + text + "\" must be memory or sqlite:PATH";
    }
    store.directory = text.substr(kSqlite.size());
  } else if (store.accept_loss || store.allow_network_mount) {
    const char* const flag =
        store.accept_loss ? "--store-accept-loss" : "--store-allow-network-mount";
    return std::string(flag) + ": must come with --store sqlite:PATH";
  }
  return {};
}

}  // namespace

ParsedOptions ParseOptions(int argc, const char* const* argv) {
  CLI::App app(kDescription, "cwm-server");
  Options options;
  std::string store = kMemory;
  app.add_option(
         "--listen", options.listen.addresses,
         std::string("unix:PATH (mode 0600) or HOST:PORT of loopback; may be given several times; "
                     "default ") +
             kDefaultAddressRule)
      ->type_name("ADDRESS");
  app.add_flag("--allow-any-local-user", options.listen.allow_any_local_user,
               "at HOST:PORT, serve every user of this machine, changes included; without it, this "
               "user and root alone");
  std::string viewer = kDefaultViewer;
  app.add_option(
         "--viewer", viewer,
         "where browsers see the world: HOST:PORT (port 0 picks one), or off; nothing can be "
         "changed there, and beyond loopback a token is needed")
      ->type_name("HOST:PORT|off")
      ->capture_default_str();
  app.add_option(
         "--store", store,
         "where worlds are kept: memory, until the server ends, or sqlite:PATH, a directory "
         "from which the next server restores them")
      ->type_name("memory|sqlite:PATH")
      ->envname("CWM_STORE")
      ->capture_default_str();
  app.add_flag(
      "--store-accept-loss", options.store.accept_loss,
      "open a store whose newest records are missing, and keep aside what is left of them");
  app.add_flag("--store-allow-network-mount", options.store.allow_network_mount,
               "open a store on a network file system, which may lose what it reported as written");
  app.add_option(
         "--memory-limit", options.memory_limit_bytes,
         "bytes that requests and worlds may take together, as 12GiB or 500MB; default three "
         "quarters of the machine's memory or of the control group's")
      ->type_name("SIZE")
      ->transform(CLI::AsSizeValue(false))
      ->check(CLI::Range(kMinMemoryLimit, std::numeric_limits<std::int64_t>::max()));
  app.add_option("--log-level", options.log_level, "what is told on stderr")
      ->check(CLI::IsMember({"debug", "info", "warn", "error", "off"}))
      ->capture_default_str();
  manual::AddManualPage(
      app, {.section = "8",
            .version = CWM_VERSION,
            .environment = {{"CWM_ADDR", "where it listens, when --listen does not say it"},
                            {"XDG_RUNTIME_DIR", "the directory of its socket, when neither does"},
                            {"CWM_STORE", "where worlds are kept, when --store does not say it"},
                            {"CWM_VIEWER_TOKEN", "the viewer's token"}}});
  app.set_version_flag("--version", std::string("cwm-server ") + CWM_VERSION);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return {.options = std::nullopt, .exit_code = code == 0 ? 0 : kUsageExitCode};
  }
  std::string wrong = ParseViewer(viewer, options);
  if (wrong.empty()) wrong = ParseStore(store, options.store);
  if (!wrong.empty()) {
    std::fprintf(stderr, "%s\nRun with --help for more information.\n", wrong.c_str());
    return {.options = std::nullopt, .exit_code = kUsageExitCode};
  }
  if (options.viewer) options.viewer->is_default = app.count("--viewer") == 0;
  return {.options = std::move(options), .exit_code = 0};
}

}  // namespace cwm::server
