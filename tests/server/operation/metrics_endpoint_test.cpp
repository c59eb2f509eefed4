#include "server/operation/metrics_endpoint.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "tests/server/operation/prometheus_text.h"

namespace tandem::server {
namespace {

/// Sends `request` and returns all that comes until the end of the connection.
std::string answerTo(std::uint16_t port, const std::string& request) {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const timeval patience{20, 0};
  ::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::string answer;
  char bytes[4096];
  if (::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0 &&
      ::send(socket, request.data(), request.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(request.size()))
    for (ssize_t n = 0; (n = ::recv(socket, bytes, sizeof(bytes), 0)) > 0;)
      answer.append(bytes, static_cast<std::size_t>(n));
  ::close(socket);
  return answer;
}

std::string get(std::uint16_t port, const std::string& path) {
  return answerTo(port, "GET " + path + " HTTP/1.1\r\nHost: a\r\n\r\n");
}

int statusOf(const std::string& answer) {
  return answer.starts_with("HTTP/1.") ? std::atoi(answer.c_str() + 9) : 0;
}

std::string bodyOf(const std::string& answer) {
  const auto end = answer.find("\r\n\r\n");
  return end == std::string::npos ? std::string() : answer.substr(end + 4);
}

std::unique_ptr<MetricsEndpoint> opened() {
  auto endpoint = MetricsEndpoint::open("127.0.0.1", 0);
  EXPECT_TRUE(endpoint.ok()) << endpoint.error().message;
  return std::move(*endpoint);
}

TEST(MetricsEndpoint, ServesTheFiguresThatWerePublishedLast) {
  const auto endpoint = opened();
  EXPECT_EQ(statusOf(get(endpoint->port(), "/metrics")), 503) << "there are no figures yet";
  for (const std::uint64_t grants : {7u, 8u}) {
    ServerFigures figures;
    figures.session.counters.grants = grants;
    endpoint->publish(figures);
    const std::string answer = get(endpoint->port(), "/metrics");
    EXPECT_EQ(statusOf(answer), 200);
    EXPECT_NE(answer.find("Content-Type: text/plain; version=0.0.4; charset=utf-8\r\n"), std::string::npos);
    const auto text = test::PrometheusText::parse(bodyOf(answer));
    ASSERT_TRUE(text.ok()) << text.error().message;
    EXPECT_EQ(text->value("tandem_decisions_total", {{"kind", "grant"}}), static_cast<double>(grants));
  }
}

TEST(MetricsEndpoint, IsIllWhileTheJournalFailsOrTheLoopStandsStill) {
  const auto endpoint = opened();
  const auto health = [&] { return get(endpoint->port(), "/healthz"); };
  ServerFigures figures;
  figures.session.journalFailure = "disk \"full\"\n";
  endpoint->publish(figures);
  endpoint->alive();
  EXPECT_EQ(statusOf(health()), 503);
  EXPECT_NE(bodyOf(health()).find(R"("reason":"journal: disk \"full\"\n")"), std::string::npos) << health();
  endpoint->publish({});
  std::string answer;
  for (int i = 0; i < 400 && statusOf(answer) != 503; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    answer = health();
  }
  EXPECT_EQ(statusOf(answer), 503) << "nothing has stepped";
  EXPECT_NE(answer.find("has not stepped"), std::string::npos) << answer;
  for (int i = 0; i < 400 && statusOf(answer) != 200; ++i) {
    endpoint->alive();
    answer = health();
  }
  EXPECT_EQ(bodyOf(answer), "{\"status\":\"ok\",\"loop\":true,\"journal\":true}\n");
}

TEST(MetricsEndpoint, RefusesWhatIsNoQuestion) {
  const auto endpoint = opened();
  endpoint->publish({});
  const std::uint16_t port = endpoint->port();
  EXPECT_EQ(statusOf(get(port, "/")), 404);
  EXPECT_EQ(statusOf(get(port, "/metrics/../../etc/passwd")), 404);
  EXPECT_EQ(statusOf(answerTo(port, "HEAD /metrics HTTP/1.1\r\nHost: a\r\n\r\n")), 200);
  for (const std::string method : {"DELETE", "PUT", "OPTIONS", "BREW"})
    EXPECT_EQ(statusOf(answerTo(port, method + " /metrics HTTP/1.1\r\nHost: a\r\n\r\n")), 405) << method;
  const std::string body = "POST /metrics HTTP/1.1\r\nHost: a\r\nContent-Length: 5\r\n\r\nhello";
  EXPECT_EQ(statusOf(answerTo(port, body)), 405);
  const std::string large = "GET /metrics HTTP/1.1\r\nHost: a\r\nX: " + std::string(20000, 'x') + "\r\n\r\n";
  EXPECT_NE(statusOf(answerTo(port, large)), 200);
  for (const std::string noise : {"\x16\x03\x01\x02\r\n\r\n", "GET\r\n\r\n"})
    EXPECT_NE(statusOf(answerTo(port, noise)), 200);
  EXPECT_EQ(statusOf(get(port, "/metrics")), 200) << "and serves on";
}

TEST(MetricsEndpoint, SaysWhereItCannotListen) {
  const auto endpoint = opened();
  const auto again = MetricsEndpoint::open("127.0.0.1", endpoint->port());
  ASSERT_FALSE(again.ok());
  EXPECT_EQ(again.error().message, "--metrics: cannot listen on 127.0.0.1 port " +
                                       std::to_string(endpoint->port()) + ": Address already in use");
  for (const char* host : {"", "localhost", "1.2.3", "::g", "256.0.0.1"})
    EXPECT_FALSE(MetricsEndpoint::open(host, 0).ok()) << host;
}

}  // namespace
}  // namespace tandem::server
