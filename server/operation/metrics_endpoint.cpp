#include "server/operation/metrics_endpoint.h"

#include <arpa/inet.h>
#include <microhttpd.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <mutex>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "assets/base/assert.h"

namespace tandem::server {
namespace {

using Clock = std::chrono::steady_clock;

constexpr unsigned kMaxConnections = 16, kMaxOfAddress = 8;
constexpr unsigned kSilence_s = 5;
constexpr std::size_t kMemory = 8 * 1024;  // of a connection: its request line and headers
constexpr std::int64_t kStepLimit_ms = 2000;
constexpr const char* kText = "text/plain; version=0.0.4; charset=utf-8";
constexpr const char* kJson = "application/json";

std::int64_t nowInMilliseconds() {
  return std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now().time_since_epoch()).count();
}

struct Answer {
  unsigned status = MHD_HTTP_OK;
  const char* type = kText;
  std::string body;
};

MHD_Result send(MHD_Connection* connection, const Answer& answer) {
  std::string body = answer.body;
  MHD_Response* response = MHD_create_response_from_buffer(body.size(), body.data(), MHD_RESPMEM_MUST_COPY);
  if (response == nullptr) return MHD_NO;
  MHD_add_response_header(response, "Content-Type", answer.type);
  MHD_add_response_header(response, "Connection", "close");
  const MHD_Result queued = MHD_queue_response(connection, answer.status, response);
  MHD_destroy_response(response);
  return queued;
}

}  // namespace

struct MetricsEndpoint::State {
  MHD_Daemon* daemon = nullptr;
  std::atomic<std::int64_t> steppedAt{nowInMilliseconds()};
  std::mutex mutex;                                // held to copy a pointer only
  std::shared_ptr<const ServerFigures> published;  // null: none yet
  // Of the HTTP thread: the text of the figures that were asked for last, so that a flood of questions costs
  // little.
  std::shared_ptr<const ServerFigures> written;
  std::string text;

  std::shared_ptr<const ServerFigures> newest() {
    const std::lock_guard lock(mutex);
    return published;
  }
  Answer metrics();
  Answer health();
  Answer answer(const std::string& method, const std::string& url);
  static MHD_Result handle(void* self, MHD_Connection* connection, const char* url, const char* method,
                           const char* version, const char* data, std::size_t* size, void** request);
};

Answer MetricsEndpoint::State::metrics() {
  const auto figures = newest();
  if (!figures) return {MHD_HTTP_SERVICE_UNAVAILABLE, kText, "the server is starting\n"};
  if (figures != written) {
    text = metricsText(*figures);
    written = figures;
  }
  return {MHD_HTTP_OK, kText, text};
}

Answer MetricsEndpoint::State::health() {
  const auto figures = newest();
  const std::string failure = figures ? figures->session.journalFailure : std::string();
  const bool steps = nowInMilliseconds() - steppedAt < kStepLimit_ms;
  const bool sound = failure.empty();
  nlohmann::ordered_json object{
      {"status", steps && sound ? "ok" : "failing"}, {"loop", steps}, {"journal", sound}};
  if (!sound) object["reason"] = "journal: " + failure;
  if (!steps) object["reason"] = "the server's loop has not stepped for two seconds";
  return {steps && sound ? unsigned{MHD_HTTP_OK} : unsigned{MHD_HTTP_SERVICE_UNAVAILABLE}, kJson,
          object.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + '\n'};
}

Answer MetricsEndpoint::State::answer(const std::string& method, const std::string& url) {
  if (method != MHD_HTTP_METHOD_GET && method != MHD_HTTP_METHOD_HEAD)
    return {MHD_HTTP_METHOD_NOT_ALLOWED, kText, "GET only\n"};
  if (url == "/metrics") return metrics();
  if (url == "/healthz") return health();
  return {MHD_HTTP_NOT_FOUND, kText, "/metrics or /healthz\n"};
}

MHD_Result MetricsEndpoint::State::handle(void* self, MHD_Connection* connection, const char* url,
                                          const char* method, const char*, const char*, std::size_t*,
                                          void**) {
  // An answer before the body, if there is one: libmicrohttpd then closes the connection without reading it.
  return send(connection, static_cast<State*>(self)->answer(method, url));
}

Result<std::unique_ptr<MetricsEndpoint>> MetricsEndpoint::open(const std::string& host, std::uint16_t port) {
  sockaddr_in v4{};
  sockaddr_in6 v6{};
  v4.sin_family = AF_INET;
  v6.sin6_family = AF_INET6;
  v4.sin_port = v6.sin6_port = htons(port);
  const bool isV4 = ::inet_pton(AF_INET, host.c_str(), &v4.sin_addr) == 1;
  if (!isV4 && ::inet_pton(AF_INET6, host.c_str(), &v6.sin6_addr) != 1)
    return Error{"--metrics: " + host + " is not an address in digits"};
  const void* address = isV4 ? static_cast<const void*>(&v4) : static_cast<const void*>(&v6);
  auto state = std::make_unique<State>();
  const unsigned flags = MHD_USE_INTERNAL_POLLING_THREAD | (isV4 ? 0u : unsigned{MHD_USE_IPv6});
  errno = 0;
  state->daemon = MHD_start_daemon(
      flags, port, nullptr, nullptr, &State::handle, state.get(), MHD_OPTION_SOCK_ADDR, address,
      MHD_OPTION_CONNECTION_LIMIT, kMaxConnections, MHD_OPTION_PER_IP_CONNECTION_LIMIT, kMaxOfAddress,
      MHD_OPTION_CONNECTION_TIMEOUT, kSilence_s, MHD_OPTION_CONNECTION_MEMORY_LIMIT, kMemory, MHD_OPTION_END);
  if (state->daemon == nullptr)
    return Error{"--metrics: cannot listen on " + host + " port " + std::to_string(port) + ": " +
                 std::generic_category().message(errno)};
  return std::unique_ptr<MetricsEndpoint>(new MetricsEndpoint(std::move(state)));
}

MetricsEndpoint::MetricsEndpoint(std::unique_ptr<State> state) : state_(std::move(state)) {}

MetricsEndpoint::~MetricsEndpoint() { MHD_stop_daemon(state_->daemon); }

std::uint16_t MetricsEndpoint::port() const {
  const MHD_DaemonInfo* info = MHD_get_daemon_info(state_->daemon, MHD_DAEMON_INFO_BIND_PORT);
  ASSERT(info != nullptr);
  return info->port;
}

void MetricsEndpoint::alive() { state_->steppedAt = nowInMilliseconds(); }

void MetricsEndpoint::publish(ServerFigures figures) {
  auto next = std::make_shared<const ServerFigures>(std::move(figures));
  const std::lock_guard lock(state_->mutex);
  state_->published.swap(next);
}

}  // namespace tandem::server
