// The server's end: accepts connections, completes handshakes, and assigns datagrams to connections by their
// id.

#include <openssl/rand.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/v6_only.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <cstring>
#include <limits>

#include "sync/transport/datagram_sorter.h"
#include "sync/transport/front_door.h"
#include "sync/transport/socket_core.h"
#include "sync/transport/tls_greeting.h"
#include "sync/transport/tls_identity.h"

namespace tandem::sync {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using asio::ip::udp;
using boost::system::error_code;

constexpr int kPortAttempts = 16;     // for a port that is free for TCP and UDP alike
constexpr int kListenBacklog = 4096;  // the system may have a lower limit
// A site that sends too many datagrams is treated as a stranger for so long.
constexpr Micros kStrangeTime = 2 * kSecond;
// Of strangers' datagrams few are kept, so that those that are read are not old.
constexpr int kOthersBufferBytes = 256 * 1024;

/// HOST:PORT of the other end; an IPv4 address in its own form.
std::string addressText(const tcp::socket& socket) {
  error_code failure;
  const tcp::endpoint peer = socket.remote_endpoint(failure);
  if (failure) return {};
  const asio::ip::address& address = peer.address();
  const std::string port = ':' + std::to_string(peer.port());
  if (address.is_v4()) return address.to_string() + port;
  if (address.to_v6().is_v4_mapped())
    return asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6()).to_string() + port;
  return '[' + address.to_string() + ']' + port;
}

class ServerTransport final : public SocketCore {
 public:
  ServerTransport(std::unique_ptr<SslContext> context, const ListenOptions& options)
      : SocketCore(Peers::many),
        context_(std::move(context)),
        options_(options),
        acceptor_(io_),
        doorEvents_(io_),
        door_(options) {
    maxMessageBytes_ = options.maxRequestBytes;
  }
  ~ServerTransport() override;

  Status listen(const std::string& host, std::uint16_t port);
  std::uint16_t port() const override { return port_; }

  void handshakeDone(Connection&) override {}  // the client sends the first frame
  void greeting(Connection& connection, FrameType type, std::span<const std::byte> bytes) override;
  void connectionClosed(Connection& connection, const std::string& reason) override;
  void trust(ConnectionId id) override;

 protected:
  Micros attend(Micros now, bool idle) override;
  void housekeeping(Micros now) override;
  Connection* connectionOf(std::uint64_t wireId) override;
  void sendsTooMuch(Connection& connection) override;

 private:
  Status bindDatagrams(const asio::ip::address& address);
  void sort(Micros at);
  Status bind(const asio::ip::address& address, std::uint16_t port);
  void watchDoor();
  void begin(const FrontDoor::Guest& guest, Micros at);
  void makeWay();
  std::uint64_t newWireId() const;
  /// Null if it is none.
  std::shared_ptr<Connection> removeStranger(const Connection& connection);

  std::unique_ptr<SslContext> context_;
  ListenOptions options_;
  tcp::acceptor acceptor_;
  std::uint16_t port_ = 0;
  asio::posix::stream_descriptor doorEvents_;
  FrontDoor door_;
  /// From the begin of the handshake to trust(); announced after the greeting.
  struct Stranger {
    std::shared_ptr<Connection> connection;
    Network network = 0;
    Micros begun = 0;
  };
  std::unordered_map<VisitorId, Stranger> strangers_;
  Crowd known_, unknown_;  // the strangers, by whether they have shown a genuine knock
  std::unordered_map<std::uint64_t, Connection*> byWireId_;
  bool sorts_ = false;                                  // the kernel tells known sites' datagrams from others
  Micros sortAt_ = std::numeric_limits<Micros>::max();  // when it is to be told of others
  ConnectionId nextId_ = 0;
};

ServerTransport::~ServerTransport() {
  door_.close();
  doorEvents_.release();  // the door closes its descriptor itself
  error_code ignored;
  acceptor_.close(ignored);
  shutDown();
  for (const auto& [visitor, stranger] : strangers_) stranger.connection->stream->abandon();
}

Status ServerTransport::bind(const asio::ip::address& address, std::uint16_t port) {
  error_code failure;
  const tcp::endpoint endpoint(address, port);
  acceptor_ = tcp::acceptor(io_);
  acceptor_.open(endpoint.protocol(), failure);
  if (!failure) acceptor_.set_option(tcp::acceptor::reuse_address(true), failure);
  if (!failure && address.is_v6())
    acceptor_.set_option(asio::ip::v6_only(!address.is_unspecified()), failure);
  if (!failure) acceptor_.bind(endpoint, failure);
  if (!failure) acceptor_.listen(kListenBacklog, failure);
  if (failure) return Error{"TCP: " + failure.message()};
  port_ = acceptor_.local_endpoint(failure).port();
  return bindDatagrams(address);
}

/// Two sockets on one port: the kernel sorts what comes, or, where it cannot, all comes to one of them.
Status ServerTransport::bindDatagrams(const asio::ip::address& address) {
  const udp::endpoint here(address, port_);
  using ReusePort = asio::detail::socket_option::boolean<SOL_SOCKET, SO_REUSEPORT>;
  const auto bindTo = [&](udp::socket& socket, bool together) {
    error_code failure;
    socket = udp::socket(io_);
    socket.open(here.protocol(), failure);
    if (!failure && address.is_v6()) socket.set_option(asio::ip::v6_only(!address.is_unspecified()), failure);
    if (!failure && together) socket.set_option(ReusePort(true), failure);
    if (!failure) socket.bind(here, failure);
    if (!failure) socket.non_blocking(true, failure);
    return failure;
  };
  error_code failure = bindTo(others_.socket, true);
  sorts_ = !failure && sortDatagrams(others_.socket.native_handle(), {});
  if (!sorts_) others_.socket.close(failure);
  failure = bindTo(datagrams_.socket, sorts_);
  if (failure) return Error{"UDP: " + failure.message()};
  enlargeBuffers(datagrams_.socket.native_handle());
  if (sorts_) others_.socket.set_option(asio::socket_base::receive_buffer_size(kOthersBufferBytes), failure);
  return {};
}

/// Tells the kernel which datagrams are known sites'.
void ServerTransport::sort(Micros at) {
  sortAt_ = std::numeric_limits<Micros>::max();
  std::vector<std::uint64_t> known;
  for (const auto& [wireId, connection] : byWireId_) {
    if (!connection->trusted) continue;
    if (connection->strangeUntil > at)
      sortAt_ = std::min(sortAt_, connection->strangeUntil);
    else
      known.push_back(wireId);
  }
  if (sorts_) sortDatagrams(datagrams_.socket.native_handle(), std::move(known));
}

void ServerTransport::sendsTooMuch(Connection& connection) {
  const Micros at = now();
  if (!connection.trusted || connection.strangeUntil > at) return;
  connection.strangeUntil = at + kStrangeTime;
  sort(at);
}

Status ServerTransport::listen(const std::string& host, std::uint16_t port) {
  const std::string place =
      "cannot listen on " + (host.empty() ? "every address" : host) + " port " + std::to_string(port) + ": ";
  error_code failure;
  asio::ip::address address = asio::ip::make_address(host.empty() ? "::" : host, failure);
  if (failure) {
    tcp::resolver resolver(io_);
    const auto found = resolver.resolve(host, "", tcp::resolver::passive, failure);
    if (failure || found.empty()) return Error{place + "no such host"};
    address = found.begin()->endpoint().address();
  }
  Status bound = bind(address, port);
  if (!bound && host.empty()) {  // a machine without IPv6
    address = asio::ip::address_v4::any();
    bound = bind(address, port);
  }
  for (int i = 1; !bound && port == 0 && i < kPortAttempts; ++i) bound = bind(address, port);
  if (!bound) return Error{place + bound.error().message};
  acceptor_.native_non_blocking(true, failure);
  if (failure || !door_.open(acceptor_.native_handle())) return Error{place + "the system gives no epoll"};
  doorEvents_.assign(door_.descriptor());
  watchUdp();
  watchDoor();
  return {};
}

void ServerTransport::watchDoor() {
  doorEvents_.async_wait(asio::posix::stream_descriptor::wait_read, [this](const error_code& failure) {
    if (failure) return;
    door_.work(now());
    counters_.failedHandshakes += door_.drainDropped();
    watchDoor();
  });
}

/// Begins one handshake at most: it takes its time from whatever else is to be done.
Micros ServerTransport::attend(Micros at, bool idle) {
  if (const std::optional<FrontDoor::Guest> guest = door_.next(at, idle)) begin(*guest, at);
  return door_.nextAt(at);
}

void ServerTransport::begin(const FrontDoor::Guest& guest, Micros at) {
  if (strangers_.size() >= options_.maxStrangers) makeWay();
  tcp::socket socket(io_);
  error_code failure;
  socket.assign(acceptor_.local_endpoint(failure).protocol(), guest.socket, failure);
  if (failure) {
    ::close(guest.socket);
    ++counters_.failedHandshakes;
    return;
  }
  tuneTcp(socket);
  const auto connection = std::make_shared<Connection>(*this);
  connection->address = addressText(socket);
  connection->stream = std::make_shared<TlsStream>(std::move(socket), *context_, *connection);
  connection->deadline = guest.since + options_.handshakeTimeout;
  connection->visitor = guest.id;
  strangers_[guest.id] = {connection, guest.network, at};
  (guest.known ? known_ : unknown_).add(guest.id, options_.handshakes.tellApart ? guest.network : 0);
  connection->stream->start(TlsStream::Side::server);
}

/// Ends the connection of one stranger. Honest ones are strangers for a few round trips only.
void ServerTransport::makeWay() {
  const VisitorId visitor = unknown_.size() > 0 ? unknown_.first() : known_.first();
  const auto connection = strangers_.at(visitor).connection;
  connection->stream->abandon();
  connectionClosed(*connection, "it made way for other newcomers");
}

std::uint64_t ServerTransport::newWireId() const {
  std::uint64_t id = 0;
  do {
    ASSERT(RAND_bytes(reinterpret_cast<unsigned char*>(&id), sizeof id) == 1);
  } while (byWireId_.contains(id));
  return id;
}

std::shared_ptr<Connection> ServerTransport::removeStranger(const Connection& connection) {
  const auto found = strangers_.find(connection.visitor);
  if (found == strangers_.end()) return nullptr;
  std::shared_ptr<Connection> removed = std::move(found->second.connection);
  strangers_.erase(found);
  known_.remove(connection.visitor);
  unknown_.remove(connection.visitor);
  return removed;
}

void ServerTransport::trust(ConnectionId id) {
  const Connection* connection = find(id);
  const auto found = connection == nullptr ? strangers_.end() : strangers_.find(connection->visitor);
  if (found == strangers_.end()) return;
  found->second.connection->trusted = true;
  sortAt_ = 0;
  if (unknown_.contains(connection->visitor)) door_.takeBack(found->second.network, found->second.begun);
  removeStranger(*connection);
}

void ServerTransport::greeting(Connection& connection, FrameType type, std::span<const std::byte> bytes) {
  if (type != FrameType::offer || connection.announced || !connection.refusal.empty()) {
    return refuse(connection, "a frame that does not belong here");
  }
  const std::optional<Offer> offer = parseOffer(bytes);
  if (!offer) return refuse(connection, "a greeting that cannot be read");
  if (offer->version != kTransportVersion) {
    return refuse(connection, "the server speaks transport version " + std::to_string(kTransportVersion) +
                                  ", this site version " + std::to_string(offer->version));
  }
  if (connections_.size() >= options_.maxConnections) return refuse(connection, "the server is full");
  const Accept accept{chooseAlgorithm(offeredAlgorithms(), offer->algorithms), newWireId()};
  if (!agree(connection, accept.algorithm, accept.wireId, StateChannel::Side::server)) {
    return refuse(connection, "no keys for state could be made");
  }
  byWireId_[accept.wireId] = &connection;
  connection.stream->send(FrameType::accept, encode(accept));
  announce(strangers_.at(connection.visitor).connection, nextId_++);
}

void ServerTransport::connectionClosed(Connection& connection, const std::string& reason) {
  if (connection.channel != nullptr) byWireId_.erase(connection.channel->wireId());
  if (connection.trusted) sortAt_ = 0;
  auto stranger = removeStranger(connection);
  if (connection.announced) return drop(connection, reason);
  ++counters_.failedHandshakes;
  if (stranger != nullptr) retire(std::move(stranger));
}

void ServerTransport::housekeeping(Micros at) {
  door_.expire(at);
  counters_.failedHandshakes += door_.drainDropped();
  if (sortAt_ <= at) sort(at);
  std::vector<std::shared_ptr<Connection>> late;
  for (const auto& [visitor, stranger] : strangers_)
    if (!stranger.connection->announced && stranger.connection->deadline < at)
      late.push_back(stranger.connection);
  for (const auto& connection : late) {
    connection->stream->abandon();
    connectionClosed(*connection, {});
  }
}

Connection* ServerTransport::connectionOf(std::uint64_t wireId) {
  const auto found = byWireId_.find(wireId);
  return found == byWireId_.end() ? nullptr : found->second;
}

}  // namespace

Result<std::unique_ptr<SocketTransport>> listenOn(const std::string& host, std::uint16_t port,
                                                  const TlsIdentity& identity, const ListenOptions& options) {
  auto context = serverContext(identity);
  if (!context) return context.error();
  auto transport = std::make_unique<ServerTransport>(std::move(context).value(), options);
  if (const Status listening = transport->listen(host, port); !listening) return listening.error();
  return std::unique_ptr<SocketTransport>(std::move(transport));
}

}  // namespace tandem::sync
