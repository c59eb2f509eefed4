#pragma once

// A box in the way between one client and one server on 127.0.0.1: passes TCP, and datagrams unless it is
// told to drop them. For tests of a path that is blocked, and as the plain relay that benches measure
// against.
//
// No thread of its own: turn() moves what has arrived and never blocks. The three directions that it combines
// may also be run by three threads.

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tandem::test {

class Forwarder {
 public:
  /// To a server whose TCP and UDP port is `target`. Exits the program if there is no socket to be had.
  explicit Forwarder(std::uint16_t target);
  ~Forwarder();
  Forwarder(const Forwarder&) = delete;
  Forwarder& operator=(const Forwarder&) = delete;

  /// Where a client connects, TCP and UDP alike.
  std::uint16_t port() const { return port_; }
  /// Datagrams to the server, and to the client, pass from now on (as they do at first) or are lost.
  void pass(bool toServer, bool toClient) {
    toServer_ = toServer;
    toClient_ = toClient;
  }

  /// Longer datagrams are lost from now on, as where a tunnel leaves little room.
  void passUpTo(std::size_t bytes) { largest_ = bytes; }
  /// From now on the server sees the client's datagrams come from another port, as after an address
  /// translator forgot.
  void changePort();

  void turn() {
    turnTcp();
    while (relayToServer(false)) {
    }
    while (relayToClient(false)) {
    }
  }
  void turnTcp();
  /// Takes one datagram and sends it on; false if there was none. `block` waits for it, at most 100 ms.
  bool relayToServer(bool block);
  bool relayToClient(bool block);

  /// Datagrams passed on, and lost, in both directions.
  std::uint64_t passed() const { return passed_[0] + passed_[1]; }
  std::uint64_t lost() const { return lost_[0] + lost_[1]; }

 private:
  struct Pipe {
    std::vector<std::byte> held;  // read and not yet written
    bool ended = false;
  };
  void pump(int from, int to, Pipe& pipe);

  std::uint16_t target_ = 0, port_ = 0;
  int listener_ = -1, client_ = -1, server_ = -1;  // TCP
  int clientSide_ = -1, serverSide_ = -1;          // UDP
  std::atomic<std::uint16_t> clientPort_{0};  // of the client's UDP socket, network byte order; 0: unknown
  Pipe up_, down_;
  bool toServer_ = true, toClient_ = true;
  std::size_t largest_ = 2048;
  std::array<std::uint64_t, 2> passed_{}, lost_{};
};

}  // namespace tandem::test
