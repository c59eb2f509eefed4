// A site's end: looks the server up, connects, checks its key, probes the path for datagrams.

#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>

#include "sync/transport/knock.h"
#include "sync/transport/socket_core.h"
#include "sync/transport/tls_greeting.h"
#include "sync/transport/tls_identity.h"

namespace tandem::sync {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using asio::ip::udp;
using boost::system::error_code;

class ClientTransport final : public SocketCore {
 public:
  ClientTransport(std::unique_ptr<SslContext> context, const std::string& host, std::uint16_t port,
                  const ConnectOptions& options);
  ~ClientTransport() override;

  void start();
  std::uint16_t port() const override;

  void handshakeDone(Connection& connection) override;
  void greeting(Connection& connection, FrameType type, std::span<const std::byte> bytes) override;
  void connectionClosed(Connection& connection, const std::string& reason) override;

 protected:
  void housekeeping(Micros now) override;
  Connection* connectionOf(std::uint64_t wireId) override;

 private:
  void connect(const tcp::resolver::results_type& endpoints);
  void connected(const error_code& failure);
  void openUdp();
  void fail(const std::string& reason);

  std::unique_ptr<SslContext> context_;
  std::string host_, place_;
  std::uint16_t port_;
  ConnectOptions options_;
  tcp::resolver resolver_;
  tcp::socket socket_;
  tcp::endpoint server_;
  std::shared_ptr<Connection> connection_;  // null once it is closed
};

ClientTransport::ClientTransport(std::unique_ptr<SslContext> context, const std::string& host,
                                 std::uint16_t port, const ConnectOptions& options)
    : SocketCore(Peers::one),
      context_(std::move(context)),
      host_(host),
      place_(host + " port " + std::to_string(port)),
      port_(port),
      options_(options),
      resolver_(io_),
      socket_(io_),
      connection_(std::make_shared<Connection>(*this)) {}

ClientTransport::~ClientTransport() {
  resolver_.cancel();
  error_code ignored;
  socket_.close(ignored);
  shutDown();
}

std::uint16_t ClientTransport::port() const {
  error_code ignored;
  return datagrams_.socket.is_open() ? datagrams_.socket.local_endpoint(ignored).port() : std::uint16_t{0};
}

void ClientTransport::start() {
  connection_->deadline = now() + options_.timeout;
  connections_[0] = connection_;
  resolver_.async_resolve(host_, std::to_string(port_),
                          [this](const error_code& failure, const tcp::resolver::results_type& endpoints) {
                            if (connection_ == nullptr || failure == asio::error::operation_aborted) return;
                            if (failure) return fail("cannot find the host " + host_);
                            connect(endpoints);
                          });
}

void ClientTransport::connect(const tcp::resolver::results_type& endpoints) {
  asio::async_connect(socket_, endpoints, [this](const error_code& failure, const tcp::endpoint& server) {
    if (connection_ == nullptr || failure == asio::error::operation_aborted) return;
    server_ = server;
    connected(failure);
  });
}

void ClientTransport::connected(const error_code& failure) {
  if (failure == asio::error::connection_refused) return fail("no server answers at " + place_);
  if (failure) return fail("cannot connect to " + place_ + ": " + failure.message());
  tuneTcp(socket_);
  connection_->stream = std::make_shared<TlsStream>(std::move(socket_), *context_, *connection_);
  if (const auto knock = knockOf(options_.credential))
    connection_->stream->showProtocol(protocolName(*knock));
  connection_->stream->start(TlsStream::Side::client);
}

void ClientTransport::handshakeDone(Connection& connection) {
  announce(connection_, 0);
  connection.stream->send(FrameType::offer, encode(Offer{kTransportVersion, offeredAlgorithms()}));
}

void ClientTransport::greeting(Connection& connection, FrameType type, std::span<const std::byte> bytes) {
  const std::optional<Accept> accept = parseAccept(bytes, offeredAlgorithms());
  if (type != FrameType::accept || connection.channel != nullptr || !accept ||
      !agree(connection, accept->algorithm, accept->wireId, StateChannel::Side::client)) {
    return refuse(connection, "the server sent a greeting that cannot be read");
  }
  if (options_.udp) openUdp();
}

void ClientTransport::openUdp() {
  // Without a socket the probes are not sent, and state stays on TLS.
  const udp::endpoint server(server_.address(), server_.port());
  error_code failure;
  datagrams_.socket.open(server.protocol(), failure);
  if (!failure) datagrams_.socket.connect(server, failure);
  if (!failure) datagrams_.socket.non_blocking(true, failure);
  if (failure) {
    datagrams_.socket.close(failure);
    return;
  }
  enlargeBuffers(datagrams_.socket.native_handle());
  watchUdp();
  sendProbe(*connection_, now());
}

void ClientTransport::fail(const std::string& reason) { connectionClosed(*connection_, reason); }

void ClientTransport::connectionClosed(Connection& connection, const std::string& reason) {
  if (connection_ == nullptr) return;
  if (!connection.announced && connection.stream != nullptr) ++counters_.failedHandshakes;
  error_code ignored;
  resolver_.cancel();
  socket_.close(ignored);
  drop(connection, reason);
  connection_.reset();
}

void ClientTransport::housekeeping(Micros at) {
  if (connection_ == nullptr) return;
  if (!connection_->announced && at > connection_->deadline) {
    if (connection_->stream != nullptr) connection_->stream->abandon();
    const auto seconds = std::to_string((options_.timeout + kSecond / 2) / kSecond);
    return fail("no answer from " + place_ + " within " + seconds + " s");
  }
  if (datagrams_.socket.is_open() && connection_->channel != nullptr && !connection_->closing)
    sendProbe(*connection_, at);
}

Connection* ClientTransport::connectionOf(std::uint64_t wireId) {
  const bool known =
      connection_ != nullptr && connection_->channel != nullptr && connection_->channel->wireId() == wireId;
  return known ? connection_.get() : nullptr;
}

}  // namespace

Result<std::unique_ptr<SocketTransport>> connectTo(const std::string& host, std::uint16_t port,
                                                   const std::string& pin, const ConnectOptions& options) {
  auto context = clientContext(pin);
  if (!context) return context.error();
  auto transport = std::make_unique<ClientTransport>(std::move(context).value(), host, port, options);
  transport->start();
  return std::unique_ptr<SocketTransport>(std::move(transport));
}

}  // namespace tandem::sync
