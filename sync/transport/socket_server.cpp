// The server's end: accepts connections, completes handshakes, and assigns datagrams to connections by their
// id.

#include <openssl/rand.h>
#include <sys/socket.h>

#include <algorithm>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/v6_only.hpp>
#include <cstring>

#include "sync/transport/socket_core.h"
#include "sync/transport/tls_greeting.h"
#include "sync/transport/tls_identity.h"

namespace tandem::sync {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using asio::ip::udp;
using boost::system::error_code;

constexpr int kPortAttempts = 16;  // for a port that is free for TCP and UDP alike
constexpr int kListenBacklog = 128;
constexpr Micros kAcceptPause = 100 * kMillisecond;  // when the process is out of file descriptors

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
      : SocketCore(Peers::many), context_(std::move(context)), options_(options), acceptor_(io_) {}
  ~ServerTransport() override;

  Status listen(const std::string& host, std::uint16_t port);
  std::uint16_t port() const override { return port_; }

  void handshakeDone(Connection&) override {}  // the client sends the first frame
  void greeting(Connection& connection, FrameType type, std::span<const std::byte> bytes) override;
  void connectionClosed(Connection& connection, const std::string& reason) override;

 protected:
  void housekeeping(Micros now) override;
  Connection* connectionOf(std::uint64_t wireId) override;

 private:
  Status bind(const asio::ip::address& address, std::uint16_t port);
  void accept();
  void accepted(tcp::socket socket);
  std::uint64_t newWireId() const;
  std::shared_ptr<Connection> removePending(Connection& connection);

  std::unique_ptr<SslContext> context_;
  ListenOptions options_;
  tcp::acceptor acceptor_;
  std::uint16_t port_ = 0;
  std::vector<std::shared_ptr<Connection>> pending_;  // oldest first
  std::unordered_map<std::uint64_t, Connection*> byWireId_;
  ConnectionId nextId_ = 0;
  Micros acceptAt_ = 0;  // if not 0, no connection is accepted before then
};

ServerTransport::~ServerTransport() {
  error_code ignored;
  acceptor_.close(ignored);
  shutDown();
  for (const auto& connection : pending_) connection->stream->abandon();
}

Status ServerTransport::bind(const asio::ip::address& address, std::uint16_t port) {
  error_code failure;
  const tcp::endpoint endpoint(address, port);
  acceptor_ = tcp::acceptor(io_);
  udp_ = udp::socket(io_);
  acceptor_.open(endpoint.protocol(), failure);
  if (!failure) acceptor_.set_option(tcp::acceptor::reuse_address(true), failure);
  if (!failure && address.is_v6())
    acceptor_.set_option(asio::ip::v6_only(!address.is_unspecified()), failure);
  if (!failure) acceptor_.bind(endpoint, failure);
  if (!failure) acceptor_.listen(kListenBacklog, failure);
  if (failure) return Error{"TCP: " + failure.message()};
  port_ = acceptor_.local_endpoint(failure).port();
  const udp::endpoint datagrams(address, port_);
  udp_.open(datagrams.protocol(), failure);
  if (!failure && address.is_v6()) udp_.set_option(asio::ip::v6_only(!address.is_unspecified()), failure);
  if (!failure) udp_.bind(datagrams, failure);
  if (!failure) udp_.non_blocking(true, failure);
  if (failure) return Error{"UDP: " + failure.message()};
  enlargeBuffers(udp_.native_handle());
  return {};
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
  watchUdp();
  accept();
  return {};
}

void ServerTransport::accept() {
  acceptor_.async_accept([this](const error_code& failure, tcp::socket socket) {
    if (!acceptor_.is_open() || failure == asio::error::operation_aborted) return;
    if (failure) {
      acceptAt_ = now() + kAcceptPause;
      return;
    }
    accepted(std::move(socket));
    accept();
  });
}

void ServerTransport::accepted(tcp::socket socket) {
  tuneTcp(socket);
  if (pending_.size() >= options_.maxPendingHandshakes) {
    // Honest handshakes are short, so the oldest one most likely belongs to a peer that only occupies a slot.
    pending_.front()->stream->abandon();
    connectionClosed(*pending_.front(), {});
  }
  const auto connection = std::make_shared<Connection>(*this);
  connection->address = addressText(socket);
  connection->stream = std::make_shared<TlsStream>(std::move(socket), *context_, *connection);
  connection->deadline = now() + options_.handshakeTimeout;
  pending_.push_back(connection);
  connection->stream->start(TlsStream::Side::server);
}

std::uint64_t ServerTransport::newWireId() const {
  std::uint64_t id = 0;
  do {
    ASSERT(RAND_bytes(reinterpret_cast<unsigned char*>(&id), sizeof id) == 1);
  } while (byWireId_.contains(id));
  return id;
}

std::shared_ptr<Connection> ServerTransport::removePending(Connection& connection) {
  const auto found =
      std::find_if(pending_.begin(), pending_.end(), [&](const auto& p) { return p.get() == &connection; });
  if (found == pending_.end()) return nullptr;
  std::shared_ptr<Connection> removed = std::move(*found);
  pending_.erase(found);
  return removed;
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
  announce(removePending(connection), nextId_++);
}

void ServerTransport::connectionClosed(Connection& connection, const std::string& reason) {
  if (connection.channel != nullptr) byWireId_.erase(connection.channel->wireId());
  if (auto pending = removePending(connection)) {
    ++counters_.failedHandshakes;
    retire(std::move(pending));
    return;
  }
  drop(connection, reason);
}

void ServerTransport::housekeeping(Micros at) {
  while (!pending_.empty() && pending_.front()->deadline < at) {
    pending_.front()->stream->abandon();
    connectionClosed(*pending_.front(), {});
  }
  if (acceptAt_ != 0 && at >= acceptAt_) {
    acceptAt_ = 0;
    accept();
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
