#pragma once

// Certificates and pins: the identities of the two ends of a TLS connection. Internal to the transport:
// includes Asio.

#include <utility>
// Asio needs <utility> before it.
#include <boost/asio/ssl/context.hpp>
#include <string>

#include "assets/base/result.h"
#include "sync/transport/socket_transport.h"

namespace tandem::sync {

using SslContext = boost::asio::ssl::context;

/// TLS 1.3 only, no tickets, with this identity.
Result<std::unique_ptr<SslContext>> serverContext(const TlsIdentity& identity);
/// TLS 1.3 only; accepts any certificate whose key has this pin, and no other.
Result<std::unique_ptr<SslContext>> clientContext(const std::string& pin);

/// Whether a failed handshake failed because of the pin.
bool failedByPin(SSL* ssl);

}  // namespace tandem::sync
