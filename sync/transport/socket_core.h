#pragma once

// What server and client share: the connections, the queue of events, the path of a datagram. Internal to the
// transport.

#include <utility>
// Asio needs <utility> before it.
#include <atomic>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "sync/transport/connection.h"
#include "sync/transport/event_queue.h"
#include "sync/transport/socket_transport.h"
#include "sync/transport/state_channel.h"
#include "sync/transport/tls_stream.h"
#include "sync/transport/udp_socket.h"

namespace tandem::sync {

class SocketCore : public SocketTransport {
 public:
  enum class Peers : std::uint8_t { one, many };
  explicit SocketCore(Peers peers);
  ~SocketCore() override;

  bool poll(TransportEvent& event) final;
  void sendControl(ConnectionId id, std::span<const std::byte> bytes) final;
  void sendState(ConnectionId id, std::span<const std::byte> bytes) final;
  std::size_t controlBacklog(ConnectionId id) const final;
  void flush() final;
  void hold(ConnectionId id, bool held) final { queue_.hold(id, held); }
  void close(ConnectionId id) final;
  const TransportCounters& counters() const final { return counters_; }
  std::string addressOf(ConnectionId id) const final;
  void wait(Micros timeout) final;
  bool stateOverUdp(ConnectionId id) const final;
  void wake() final;

  // From a connection.
  virtual void handshakeDone(Connection& connection) = 0;
  /// Offer or accept; anything wrong ends the connection.
  virtual void greeting(Connection& connection, FrameType type, std::span<const std::byte> bytes) = 0;
  /// Removes a connection that is over. It lives until retire() has been called and the caller has returned.
  virtual void connectionClosed(Connection& connection, const std::string& reason) = 0;
  void payload(Connection& connection, FrameType type, std::span<const std::byte> bytes);

 protected:
  static Micros now();
  /// Does the next piece of work that can wait, a short one; `idle`: nothing else is to be done. Returns when
  /// to call again.
  virtual Micros attend(Micros now, bool idle);
  /// Does the work that is due by the clock, every kHousekeeping.
  virtual void housekeeping(Micros now) = 0;
  /// The connection whose datagrams have this id, or null.
  virtual Connection* connectionOf(std::uint64_t wireId) = 0;
  Connection* find(ConnectionId id) const;
  void announce(const std::shared_ptr<Connection>& connection, ConnectionId id);
  /// Sends the peer the reason, then closes; the application gets a `closed` event with it.
  void refuse(Connection& connection, const std::string& reason);
  /// Removes an announced connection and queues its `closed`.
  void drop(Connection& connection, const std::string& reason);
  /// Keeps a connection alive until no handler can use it.
  void retire(std::shared_ptr<Connection> connection) { retired_.push_back(std::move(connection)); }
  void queueClosed(ConnectionId id, std::string reason);
  /// For destructors: gives close() half a second to finish, then cuts all connections.
  void shutDown();
  /// A socket for datagrams, and what was received last.
  struct Intake {
    explicit Intake(boost::asio::io_context& io) : socket(io) {}
    boost::asio::ip::udp::socket socket;
    UdpBatch batch;
    bool watched = false, readable = false;
  };
  void watchUdp();
  /// A server's connection sends more state than a site may.
  virtual void sendsTooMuch(Connection&) {}
  void sendProbe(Connection& connection, Micros now);
  bool agree(Connection& connection, SealAlgorithm algorithm, std::uint64_t wireId, StateChannel::Side side);

  boost::asio::io_context io_;
  Intake datagrams_;
  Intake others_;  // of a server that tells them apart: datagrams of others than its sites
  std::unordered_map<ConnectionId, std::shared_ptr<Connection>> connections_;
  TransportCounters counters_;
  std::size_t maxMessageBytes_ = kMaxControlBytes;  // of control, from the other end

 private:
  using Event = EventQueue::Event;
  std::size_t maxUndelivered() const;
  void push(Connection& connection, TransportEvent::Kind kind, std::span<const std::byte> bytes);
  bool pollQueue(TransportEvent& event);
  /// Opens received datagrams until one is state for the application.
  bool findState();
  bool open(const UdpBatch::Datagram& datagram);
  static bool withinRate(Connection& connection, Micros at);
  void rest(Connection& connection, bool resting);
  bool eventReady();
  void receiveUdp();
  void watch(Intake& intake);
  void armTimer(Micros at);
  void keepHouse();
  void overflow(Connection& connection);
  /// Seals a datagram and sends it, at once or in a batch. False if it does not leave.
  bool sendSealed(Connection& connection, std::span<const std::byte> bytes);

  Peers peers_;
  boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work_;
  boost::asio::steady_timer timer_;
  std::atomic<bool> woken_{false};
  Micros armedAt_ = 0, nextHousekeeping_ = 0, datagramTime_ = 0;
  bool timerArmed_ = false;

  EventQueue queue_;
  std::vector<std::vector<std::byte>> spare_;  // storage of polled events, to be used again
  std::vector<std::byte> current_;             // of the event polled last
  std::vector<std::shared_ptr<Connection>> retired_;

  std::size_t othersLeft_ = 0;  // batches of others_ that may be received until the next housekeeping
  UdpSendBatch unsent_;         // a server's datagrams, until flush()
  std::array<std::array<std::byte, kMaxDatagramBytes>, 2>
      opened_;  // one is the application's, one is being filled
  std::array<std::byte, kMaxDatagramBytes> outgoing_;
  std::size_t openedIndex_ = 0, openedSize_ = 0;
  ConnectionId openedFrom_ = 0;
  bool stateReady_ = false;
};

}  // namespace tandem::sync
