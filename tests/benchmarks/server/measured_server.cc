#include "tests/benchmarks/server/measured_server.h"

#include <grpcpp/create_channel.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>
#include <utility>
#include <vector>

namespace cwm::benchmarks {
namespace {

std::string& ProgramPath() {
  static std::string path;
  return path;
}

std::vector<std::string> Command(const MeasuredServerOptions& options, const std::string& socket,
                                 int tcp_port) {
  // The server ends when this program ends, for whatever reason.
  std::vector<std::string> words = {"setpriv", "--pdeathsig", "KILL"};
  if (options.max_descriptors > 0) {
    const std::string count = std::to_string(options.max_descriptors);
    words.insert(words.end(), {"prlimit", "--nofile=" + count + ":" + count});
  }
  if (options.cores > 0) {
    words.insert(words.end(), {"taskset", "--cpu-list", "0-" + std::to_string(options.cores - 1)});
  }
  words.insert(words.end(), {options.program, "--listen", "unix:" + socket, "--viewer", "off"});
  if (tcp_port != 0) {
    words.insert(words.end(), {"--listen", "127.0.0.1:" + std::to_string(tcp_port)});
  }
  words.insert(words.end(), options.arguments.begin(), options.arguments.end());
  return words;
}

}  // namespace

std::string ServerProgram() {
  if (!ProgramPath().empty()) return ProgramPath();
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / "cwm-server";
}

void UseServerProgram(std::string path) { ProgramPath() = std::move(path); }

int FreePort() {
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  int port = 0;
  if (bind(fd, reinterpret_cast<sockaddr*>(&address), size) == 0 &&
      getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size) == 0) {
    port = ntohs(address.sin_port);
  }
  close(fd);
  return port;
}

MeasuredServer::MeasuredServer(const MeasuredServerOptions& options)
    : socket_path_(scratch_ / "cwm.sock"),
      tcp_port_(options.listens_on_tcp ? FreePort() : 0),
      process_(Command(options, socket_path_, tcp_port_), scratch_ / "server.log") {
  connection_ = std::make_unique<client::Connection>(client::ConnectOptions{
      .address = "unix:" + socket_path_, .deadline = std::chrono::seconds(20)});
  const auto deadline = std::chrono::system_clock::now() + std::chrono::seconds(20);
  up_ = connection_->channel()->WaitForConnected(deadline);
}

MeasuredServer::~MeasuredServer() { process_.Signal(SIGKILL); }

std::shared_ptr<grpc::Channel> MeasuredServer::NewChannel() const {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);  // windows stay small
  arguments.SetInt(GRPC_ARG_ENABLE_RETRIES, 0);
  arguments.SetMaxReceiveMessageSize(-1);
  arguments.SetMaxSendMessageSize(-1);
  return grpc::CreateCustomChannel("unix:" + socket_path_, grpc::InsecureChannelCredentials(),
                                   arguments);
}

std::int64_t MeasuredServer::ResidentBytes() const {
  std::ifstream status("/proc/" + std::to_string(pid()) + "/status");
  std::string line;
  while (std::getline(status, line)) {
    if (line.rfind("RssAnon:", 0) == 0) return std::stoll(line.substr(8)) * 1024;
  }
  return 0;
}

double MeasuredServer::Cpu_s() const {
  clockid_t clock{};
  timespec time{};
  if (clock_getcpuclockid(pid(), &clock) != 0 || clock_gettime(clock, &time) != 0) return 0;
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) * 1e-9;
}

std::map<pid_t, double> MeasuredServer::ThreadCpu_s() const {
  std::map<pid_t, double> seconds;
  std::error_code ignored;
  const std::string tasks = "/proc/" + std::to_string(pid()) + "/task";
  for (const auto& entry : std::filesystem::directory_iterator(tasks, ignored)) {
    double nanoseconds = 0;
    std::ifstream(entry.path() / "schedstat") >> nanoseconds;
    seconds[std::stoi(entry.path().filename())] = nanoseconds * 1e-9;
  }
  return seconds;
}

bool MeasuredServer::HasRunnableThread() const {
  std::error_code ignored;
  const std::string tasks = "/proc/" + std::to_string(pid()) + "/task";
  for (const auto& entry : std::filesystem::directory_iterator(tasks, ignored)) {
    std::string stat;
    std::getline(std::ifstream(entry.path() / "stat"), stat);
    const std::size_t name_end = stat.rfind(')');  // names may have spaces
    if (name_end != std::string::npos && stat.substr(name_end + 1, 2) == " R") return true;
  }
  return false;
}

bool MeasuredServer::WaitUntilIdle(double cpu_limit_s) const {
  constexpr double kIdleShare = 0.02, kClockOverCpu = 3;
  constexpr auto kPeriod = std::chrono::milliseconds(50);
  const auto start = SteadyClock::now();
  const double start_s = Cpu_s();
  int idle_periods = 0;
  double before_s = start_s;
  while (SecondsSince(start) < kClockOverCpu * cpu_limit_s && before_s - start_s < cpu_limit_s) {
    const auto period_start = SteadyClock::now();
    std::this_thread::sleep_for(kPeriod);
    const double now_s = Cpu_s();
    if (now_s == 0) return false;
    const bool idle =
        now_s - before_s < kIdleShare * SecondsSince(period_start) && !HasRunnableThread();
    before_s = now_s;
    idle_periods = idle ? idle_periods + 1 : 0;
    if (idle_periods == 2) return true;
  }
  return false;
}

std::optional<double> MeasuredServer::Stop_s(double limit_s) {
  const auto start = SteadyClock::now();
  process_.Signal(SIGTERM);
  while (SecondsSince(start) < limit_s) {
    if (!running()) return SecondsSince(start);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return std::nullopt;
}

}  // namespace cwm::benchmarks
