#pragma once

// Peers without a token that keep a server busy, with plain sockets and OpenSSL, on a thread of their own.
// What they do is bounded: the number of connections in all and at a time.

#include <arpa/inet.h>
#include <netinet/in.h>
#include <openssl/ssl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <deque>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

namespace tandem::sync {

enum class Attack {
  silent,   // connects and says nothing
  closing,  // connects and goes
  garbage,  // sends what is not TLS
  opening,  // sends a ClientHello and nothing further
  shaking,  // completes TLS and says nothing
  greeting  // completes TLS and the greeting, and never says Hello
};
inline constexpr std::array kAttacks{Attack::silent,  Attack::closing, Attack::garbage,
                                     Attack::opening, Attack::shaking, Attack::greeting};
inline const char* nameOf(Attack attack) {
  constexpr std::array names{"silent", "closing", "garbage", "opening", "shaking", "greeting"};
  return names[static_cast<std::size_t>(attack)];
}

struct FloodPlan {
  Attack attack = Attack::silent;
  unsigned networks = 1;           // loopback addresses, from 127.0.1.0 on; 0: the newcomers' own
  unsigned most = 50000;           // connections in all
  unsigned perSecond = 5000;       // at most
  unsigned atOnce = 512;           // connections held
  unsigned seed = 1;
};

/// The first TLS message of a client.
inline std::string clientHello(SSL_CTX* context, const std::string& protocols = {}) {
  const std::unique_ptr<SSL, decltype(&SSL_free)> ssl(SSL_new(context), SSL_free);
  BIO* out = BIO_new(BIO_s_mem());
  SSL_set_bio(ssl.get(), BIO_new(BIO_s_mem()), out);
  SSL_set_connect_state(ssl.get());
  if (!protocols.empty())
    SSL_set_alpn_protos(ssl.get(), reinterpret_cast<const unsigned char*>(protocols.data()),
                        static_cast<unsigned>(protocols.size()));
  SSL_do_handshake(ssl.get());
  char* data = nullptr;
  const long size = BIO_get_mem_data(out, &data);
  return {data, static_cast<std::size_t>(size)};
}

class Flood {
 public:
  Flood(const FloodPlan& plan, std::uint16_t port)
      : plan_(plan), port_(port), random_(plan.seed), context_(SSL_CTX_new(TLS_client_method())) {
    hello_ = clientHello(context_);
    thread_ = std::thread([this] { run(); });
  }
  ~Flood() {
    stopped_ = true;
    thread_.join();
    for (Caller& caller : callers_) end(caller);
    SSL_CTX_free(context_);
  }
  Flood(const Flood&) = delete;
  Flood& operator=(const Flood&) = delete;

  unsigned made() const { return made_; }
  /// Connections a second so far, to be reported only.
  double rate() const {
    return made_ / std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  struct Caller {
    int socket = -1;
    SSL* ssl = nullptr;
    bool done = true;
  };
  void run() {
    while (!stopped_ && made_ < plan_.most) {
      const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start_;
      if (made_ > passed.count() * plan_.perSecond)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      else
        connect();
      for (std::size_t i = callers_.size() > 64 ? callers_.size() - 64 : 0; i < callers_.size(); ++i)
        step(callers_[i]);
    }
  }
  void connect() {
    Caller caller;
    caller.socket = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0);
    ++made_;
    if (caller.socket < 0) return;
    sockaddr_in from{}, to{};
    from.sin_family = to.sin_family = AF_INET;
    const unsigned network = plan_.networks == 0 ? 1 : 256 + random_() % plan_.networks;
    from.sin_addr.s_addr = htonl(0x7f000000u + network);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    to.sin_port = htons(port_);
    bind(caller.socket, reinterpret_cast<const sockaddr*>(&from), sizeof from);
    ::connect(caller.socket, reinterpret_cast<const sockaddr*>(&to), sizeof to);
    say(caller);
    callers_.push_back(caller);
    if (callers_.size() <= plan_.atOnce) return;
    end(callers_.front());
    callers_.pop_front();
  }
  void say(Caller& caller) {
    const std::string bytes = plan_.attack == Attack::garbage ? "GET / HTTP/1.0\r\n\r\n" : hello_;
    if (plan_.attack == Attack::closing) return end(caller);
    if (plan_.attack == Attack::garbage || plan_.attack == Attack::opening)
      send(caller.socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (plan_.attack < Attack::shaking) return;
    caller.ssl = SSL_new(context_);
    SSL_set_fd(caller.ssl, caller.socket);
    caller.done = false;
  }
  void step(Caller& caller) const {
    if (caller.done) return;
    const int result = SSL_connect(caller.ssl);
    const int error = SSL_get_error(caller.ssl, result);
    if (result != 1 && (error == SSL_ERROR_WANT_READ || error == SSL_ERROR_WANT_WRITE)) return;
    caller.done = true;
    constexpr std::array<char, 7> kOffer{0, 0, 0, 3, 2, 1, 2};
    if (result == 1 && plan_.attack == Attack::greeting) SSL_write(caller.ssl, kOffer.data(), kOffer.size());
  }
  static void end(Caller& caller) {
    if (caller.ssl != nullptr) SSL_free(std::exchange(caller.ssl, nullptr));
    caller.done = true;
    const linger none{.l_onoff = 1, .l_linger = 0};  // leaves no TIME_WAIT behind
    if (caller.socket < 0) return;
    setsockopt(caller.socket, SOL_SOCKET, SO_LINGER, &none, sizeof none);
    ::close(std::exchange(caller.socket, -1));
  }

  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  FloodPlan plan_;
  std::uint16_t port_;
  std::mt19937 random_;
  SSL_CTX* context_;
  std::string hello_;
  std::deque<Caller> callers_;  // the thread's
  std::atomic<unsigned> made_{0};
  std::atomic<bool> stopped_{false};
  std::thread thread_;
};

}  // namespace tandem::sync
