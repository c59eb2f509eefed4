#include "tests/support/forwarder.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>

namespace tandem::test {
namespace {

constexpr std::size_t kHeld = 64 * 1024;
constexpr std::size_t kDatagram = 2048;
constexpr int kPortAttempts = 16;

sockaddr_in loopback(std::uint16_t networkOrderPort) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = networkOrderPort;
  return address;
}

void need(bool good, const char* what) {
  if (good) return;
  std::perror(what);
  std::exit(2);
}

bool bindTo(int socket, std::uint16_t networkOrderPort) {
  const sockaddr_in address = loopback(networkOrderPort);
  return bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
}

bool connectTo(int socket, std::uint16_t port) {
  const sockaddr_in address = loopback(htons(port));
  return connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
}

void limitWait(int socket) {
  const timeval limit{0, 100000};
  setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
}

void closeAll(std::initializer_list<int> sockets) {
  for (const int socket : sockets)
    if (socket >= 0) close(socket);
}

}  // namespace

Forwarder::Forwarder(std::uint16_t target) : target_(target) {
  bool bound = false;
  for (int i = 0; i < kPortAttempts && !bound; ++i) {
    closeAll({listener_, clientSide_});
    listener_ = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0);
    clientSide_ = socket(AF_INET, SOCK_DGRAM, 0);
    need(listener_ >= 0 && clientSide_ >= 0 && bindTo(listener_, 0) && listen(listener_, 4) == 0,
         "forwarder");
    sockaddr_in own{};
    socklen_t size = sizeof own;
    need(getsockname(listener_, reinterpret_cast<sockaddr*>(&own), &size) == 0, "forwarder");
    port_ = ntohs(own.sin_port);
    bound = bindTo(clientSide_, own.sin_port);
  }
  need(bound, "forwarder: no port is free for TCP and UDP alike");
  limitWait(clientSide_);
  changePort();
}

Forwarder::~Forwarder() { closeAll({listener_, client_, server_, clientSide_, serverSide_}); }

void Forwarder::changePort() {
  const int before = serverSide_;
  serverSide_ = socket(AF_INET, SOCK_DGRAM, 0);
  need(serverSide_ >= 0 && connectTo(serverSide_, target_), "forwarder: server");
  limitWait(serverSide_);
  closeAll({before});  // after the new one is bound, which so has another port
}

void Forwarder::turnTcp() {
  if (client_ < 0) {
    client_ = accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK);
    if (client_ < 0) return;
    server_ = socket(AF_INET, SOCK_STREAM, 0);
    need(server_ >= 0 && connectTo(server_, target_), "forwarder: server");
    const int on = 1;
    for (const int end : {client_, server_}) setsockopt(end, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  }
  pump(client_, server_, up_);
  pump(server_, client_, down_);
}

void Forwarder::pump(int from, int to, Pipe& pipe) {
  if (pipe.ended) return;
  bool over = false;
  if (pipe.held.size() < kHeld) {
    const std::size_t before = pipe.held.size();
    pipe.held.resize(kHeld);
    const ssize_t got = recv(from, pipe.held.data() + before, kHeld - before, MSG_DONTWAIT);
    pipe.held.resize(before + static_cast<std::size_t>(got > 0 ? got : 0));
    over = got == 0 || (got < 0 && errno != EAGAIN);
  }
  if (!pipe.held.empty()) {
    const ssize_t sent = send(to, pipe.held.data(), pipe.held.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent > 0) pipe.held.erase(pipe.held.begin(), pipe.held.begin() + sent);
    if (sent < 0 && errno != EAGAIN) pipe.held.clear();  // nobody is there to take it
  }
  if (!over || !pipe.held.empty()) return;
  pipe.ended = true;
  shutdown(to, SHUT_WR);
}

bool Forwarder::relayToServer(bool block) {
  std::array<std::byte, kDatagram> bytes;
  sockaddr_in from{};
  socklen_t size = sizeof from;
  const ssize_t got = recvfrom(clientSide_, bytes.data(), bytes.size(), block ? 0 : MSG_DONTWAIT,
                               reinterpret_cast<sockaddr*>(&from), &size);
  if (got < 0) return false;
  clientPort_ = from.sin_port;
  const bool passes = toServer_ && static_cast<std::size_t>(got) <= largest_;
  ++(passes ? passed_ : lost_)[0];
  if (passes) send(serverSide_, bytes.data(), static_cast<std::size_t>(got), MSG_NOSIGNAL);
  return true;
}

bool Forwarder::relayToClient(bool block) {
  std::array<std::byte, kDatagram> bytes;
  const ssize_t got = recv(serverSide_, bytes.data(), bytes.size(), block ? 0 : MSG_DONTWAIT);
  if (got < 0) return false;
  const bool passes = toClient_ && clientPort_ != 0 && static_cast<std::size_t>(got) <= largest_;
  ++(passes ? passed_ : lost_)[1];
  if (!passes) return true;
  const sockaddr_in to = loopback(clientPort_);
  sendto(clientSide_, bytes.data(), static_cast<std::size_t>(got), MSG_NOSIGNAL,
         reinterpret_cast<const sockaddr*>(&to), sizeof to);
  return true;
}

}  // namespace tandem::test
