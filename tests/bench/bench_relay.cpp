// What the server adds to a datagram's way from site to site, against a relay that only copies it: a thread
// with recvfrom and send. Both on 127.0.0.1, in one process, by turns in the same run.
//
//   plain    UDP socket          -> raw relay -> UDP socket              no encryption anywhere: the bare
//   relay sealed   SocketTransport     -> raw relay -> SocketTransport         the ends of the next line, the
//   relay of the last server   SocketTransport     -> Session   -> SocketTransport         what sites do
//
// Counted: from before the sender seals and sends until the receiver has opened the datagram and holds its
// bytes. Encoding before and decoding after are outside, as is play-out. Sender and receiver take turns on
// one thread, so there is one clock and each datagram meets an idle relay, as at 250 Hz it does. sealed
// against server isolates the relay, because the ends run the same code; plain against server also charges
// the server with the ends' encryption.
//
// Tens of microseconds drown in whatever else a machine does: `chrt -f 10 bench_relay` keeps other programs'
// load out of all three alike, and the report says whether it was so.

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <functional>
#include <memory>
#include <optional>
#include <thread>

#include "assets/scene/scene_package.h"
#include "server/journal/memory_journal.h"
#include "server/session.h"
#include "sync/transport/seal.h"
#include "sync/transport/socket_transport.h"
#include "sync/wire/state_bundle.h"
#include "sync/wire/state_receiver.h"
#include "sync/wire/wire.h"
#include "tests/bench/bench_process.h"
#include "tests/bench/bench_report.h"
#include "tests/support/forwarder.h"
#include "tests/support/shapes.h"

namespace {

using namespace tandem;
using bench::fail;
using bench::must;
using bench::now;
using bench::threadSeconds;
using sync::Micros;
using Kind = sync::TransportEvent::Kind;

constexpr Micros kPeriod = 4 * sync::kMillisecond;  // 250 Hz
constexpr Micros kLost = 100 * sync::kMillisecond;  // a datagram that takes longer counts as lost
constexpr Micros kSetupTime = 10 * sync::kSecond;
constexpr int kPingEvery = 25;  // periods, as a site does

/// A thread that relays until it is stopped; reports the processor time that it used.
class RelayThread {
 public:
  explicit RelayThread(std::function<void()> turn)
      : thread_([this, turn = std::move(turn)] {
          while (!stop_.load(std::memory_order_relaxed)) turn();
          used_ = threadSeconds();
        }) {}
  ~RelayThread() { stop(); }
  double stop() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    return used_;
  }

 private:
  std::atomic<bool> stop_{false};
  double used_ = 0.0;
  std::thread thread_;
};

/// One way through one relay. travel() gives the time in us, or nothing if the datagram was lost.
class Path {
 public:
  virtual ~Path() = default;
  virtual std::optional<double> travel(std::span<const std::byte> state, std::uint32_t sequence) = 0;
  /// Between datagrams: whatever else keeps the path alive.
  virtual void idle(int period) { static_cast<void>(period); }
  /// Ends the relay; processor time that it used, in s.
  virtual double stop() = 0;
};

// ---- plain: sockets without encryption ----

int udpSocket() {
  const int made = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in any{};
  any.sin_family = AF_INET;
  any.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const timeval limit{0, static_cast<suseconds_t>(kLost)};
  setsockopt(made, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  if (made < 0 || bind(made, reinterpret_cast<const sockaddr*>(&any), sizeof any) != 0) fail("no UDP socket");
  return made;
}
sockaddr_in addressOf(int socket) {
  sockaddr_in own{};
  socklen_t size = sizeof own;
  getsockname(socket, reinterpret_cast<sockaddr*>(&own), &size);
  return own;
}

class PlainPath final : public Path {
 public:
  PlainPath()
      : to_(addressOf(relay_)), relayThread_([this, target = addressOf(receiver_)] { relay(target); }) {}
  ~PlainPath() override {
    relayThread_.stop();
    for (const int socket : {sender_, relay_, receiver_}) close(socket);
  }
  std::optional<double> travel(std::span<const std::byte> state, std::uint32_t sequence) override {
    // As large as the sealed one.
    const std::size_t size = state.size() + sync::kSealOverheadBytes;
    std::memcpy(out_.data(), &sequence, sizeof sequence);
    const bench::Stopwatch watch;
    sendto(sender_, out_.data(), size, 0, reinterpret_cast<const sockaddr*>(&to_), sizeof to_);
    for (;;) {
      if (recv(receiver_, in_.data(), in_.size(), 0) < 0) return std::nullopt;
      const double took = 1e6 * watch.seconds();
      if (std::memcmp(in_.data(), &sequence, sizeof sequence) == 0) return took;
    }
  }
  double stop() override { return relayThread_.stop(); }

 private:
  void relay(const sockaddr_in& target) {
    std::array<std::byte, 2048> bytes;
    sockaddr_in from{};
    socklen_t size = sizeof from;
    const ssize_t got =
        recvfrom(relay_, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&from), &size);
    if (got < 0) return;
    sendto(relay_, bytes.data(), static_cast<std::size_t>(got), 0, reinterpret_cast<const sockaddr*>(&target),
           sizeof target);
  }

  int sender_ = udpSocket(), relay_ = udpSocket(), receiver_ = udpSocket();
  sockaddr_in to_;
  std::array<std::byte, 2048> out_{}, in_{};
  RelayThread relayThread_;
};

// ---- sealed and server: the project's own ends ----

struct End {
  std::unique_ptr<sync::SocketTransport> transport;
  sync::ConnectionId peer = 0;
  bool connected = false;

  /// Runs the sockets, hands every event to `take`.
  template <typename Take>
  void turn(Micros timeout, Take&& take) {
    transport->wait(timeout);
    sync::TransportEvent event;
    while (transport->poll(event)) {
      if (event.kind == Kind::closed) fail("a connection ended: " + event.reason);
      if (event.kind == Kind::connected) {
        connected = true;
        peer = event.connection;
        transport->trust(peer);
      }
      take(event);
    }
  }
  void drain() {
    turn(0, [](const auto&) {});
  }
};

std::optional<double> travelBetween(End& sender, End& receiver, const sync::WireFrame& frame,
                                    std::span<const std::byte> state, std::uint32_t sequence,
                                    sync::StateReceiver& states, sync::StateMessage& message) {
  const bench::Stopwatch watch;
  sender.transport->sendState(sender.peer, state);
  std::optional<double> took;
  while (!took && watch.seconds() * 1e6 < static_cast<double>(kLost)) {
    receiver.turn(kLost, [&](const sync::TransportEvent& event) {
      const double at = 1e6 * watch.seconds();
      using Outcome = sync::StateReceiver::Outcome;
      for (auto rest = event.bytes; event.kind == Kind::state && !rest.empty();) {
        if (states.decode(sync::popMessage(rest), frame, message) != Outcome::decoded) continue;
        const auto* update = std::get_if<sync::StateUpdate>(&message);
        if (update != nullptr && update->parts.size() == 1 && update->parts[0].sequence == sequence)
          took = at;
      }
    });
  }
  return took;
}

template <typename Turn, typename Done>
void runUntil(const char* what, Turn&& turn, Done&& done) {
  const Micros deadline = now() + kSetupTime;
  while (!done()) {
    turn();
    if (now() > deadline) fail(std::string("not reached: ") + what);
  }
}

class SealedPath final : public Path {
 public:
  explicit SealedPath(const sync::WireFrame& frame, const sync::TlsIdentity& identity) : frame_(frame) {
    receiver_.transport = must(sync::listenOn("127.0.0.1", 0, identity));
    box_ = std::make_unique<test::Forwarder>(receiver_.transport->port());
    forward_ = std::make_unique<RelayThread>([this] { box_->relayToServer(true); });
    backward_ = std::make_unique<RelayThread>([this] { box_->relayToClient(true); });
    sender_.transport = must(sync::connectTo("127.0.0.1", box_->port(), must(sync::pinOf(identity))));
    runUntil(
        "UDP through the relay", [this] { idle(0); },
        [this] {
          return sender_.connected && receiver_.connected && sender_.transport->stateOverUdp(0) &&
                 receiver_.transport->stateOverUdp(receiver_.peer);
        });
  }
  std::optional<double> travel(std::span<const std::byte> state, std::uint32_t sequence) override {
    return travelBetween(sender_, receiver_, frame_, state, sequence, states_, message_);
  }
  void idle(int) override {
    box_->turnTcp();
    sender_.drain();
    receiver_.drain();
  }
  double stop() override {
    backward_->stop();
    return forward_->stop();
  }

 private:
  sync::WireFrame frame_;
  sync::StateReceiver states_;
  sync::StateMessage message_{sync::StateUpdate{}};
  End sender_, receiver_;
  std::unique_ptr<test::Forwarder> box_;
  std::unique_ptr<RelayThread> forward_, backward_;
};

/// Two sites of a real session: the first holds part 0.
class ServerPath final : public Path {
 public:
  ServerPath(const assets::Scene& scene, const sync::TlsIdentity& identity)
      : package_(assets::packScene(scene)), frame_(sync::wireFrame(scene.bounds)) {
    config_.key = server::makeSigningKey();
    server_ = must(sync::listenOn("127.0.0.1", 0, identity));
    session_ = std::make_unique<server::Session>(scene, package_, config_, *server_, journal_, nullptr, now(),
                                                 std::time(nullptr));
    const auto token = [this] {
      return session_->makeToken(sync::Role::participant, std::time(nullptr) + 600);
    };
    const std::array<std::string, 2> tokens{token(), token()};
    relay_ = std::make_unique<RelayThread>([this] { serve(); });
    join(sender_, tokens[0], identity);
    join(receiver_, tokens[1], identity);
    grab();
  }
  ~ServerPath() override { relay_->stop(); }

  std::optional<double> travel(std::span<const std::byte> state, std::uint32_t sequence) override {
    return travelBetween(sender_, receiver_, frame_, state, sequence, states_, message_);
  }
  void idle(int period) override {
    if (period % kPingEvery == 0) {
      ping(sender_);
      ping(receiver_);
    }
    sender_.drain();
    receiver_.drain();
  }
  double stop() override {
    server_->wake();
    const double used = relay_->stop();
    relayed_ = session_->counters().relayedUpdates;
    return used;
  }
  Epoch epoch() const { return epoch_; }
  Micros sessionTime() const { return now() + sessionOffset_; }
  std::uint64_t relayed() const { return relayed_; }

 private:
  /// What the server's program does all day.
  void serve() {
    journal_.advanceTo(now());
    server_->wait(std::max<Micros>(0, session_->nextDeadline() - now()));
    session_->step(now(), std::time(nullptr));
  }
  void join(End& site, const std::string& token, const sync::TlsIdentity& identity) {
    site.transport = must(sync::connectTo("127.0.0.1", server_->port(), must(sync::pinOf(identity))));
    bool welcome = false;
    const auto take = [&](const sync::TransportEvent& event) {
      if (event.kind == Kind::connected)
        say(site, sync::Hello{sync::kProtocolVersion, false, token, "bench", {1, 2, 3}});
      if (event.kind != Kind::control) return;
      const auto message = must(sync::decodeControl(event.bytes));
      if (const auto* refused = std::get_if<sync::Refused>(&message)) fail(refused->reason);
      const auto* answer = std::get_if<sync::Welcome>(&message);
      if (answer == nullptr) return;
      welcome = true;
      sessionOffset_ = answer->sessionTime - now();
      say(site, sync::Ready{});
    };
    runUntil(
        "joined", [&] { site.turn(sync::kMillisecond, take); },
        [&] { return welcome && site.transport->stateOverUdp(0); });
  }
  void grab() {
    bool granted = false;
    say(sender_, sync::Grab{1, 0});
    const auto take = [&](const sync::TransportEvent& event) {
      if (event.kind != Kind::control) return;
      const auto message = must(sync::decodeControl(event.bytes));
      const auto* reply = std::get_if<sync::GrabReply>(&message);
      if (reply == nullptr) return;
      if (reply->denial != sync::Denial::none) fail(sync::toString(reply->denial));
      granted = true;
      epoch_ = reply->part.epoch;
    };
    runUntil(
        "granted", [&] { sender_.turn(sync::kMillisecond, take); }, [&] { return granted; });
  }
  static void say(End& site, const sync::ControlMessage& message) {
    site.transport->sendControl(0, sync::encodeControl(message));
  }
  void ping(End& site) {
    sync::encodeState(sync::Ping{++pings_, now()}, frame_, bytes_);
    site.transport->sendState(0, bytes_);
  }

  std::vector<std::byte> package_, bytes_;
  sync::WireFrame frame_;
  sync::StateReceiver states_;
  sync::StateMessage message_{sync::StateUpdate{}};
  server::SessionConfig config_;
  server::MemoryJournal journal_;
  std::unique_ptr<sync::SocketTransport> server_;
  std::unique_ptr<server::Session> session_;
  End sender_, receiver_;
  Epoch epoch_ = 0;
  Micros sessionOffset_ = 0;
  std::uint32_t pings_ = 0;
  std::uint64_t relayed_ = 0;
  std::unique_ptr<RelayThread> relay_;
};

// ---- the run ----

assets::Scene oneBox() {
  assets::Scene scene;
  scene.materials.emplace_back();
  scene.meshes.push_back(test::boxMesh({0.1, 0.1, 0.1}));
  scene.parts.emplace_back();
  scene.parts[0].name = "box";
  scene.parts[0].mesh = 0;
  scene.parts[0].movable = true;
  scene.parts[0].massProperties = {1.0, {0.0, 0.0, 0.0}, glm::dmat3(0.01)};
  scene.bounds = scene.meshes[0].bounds;
  return scene;
}

struct Measured {
  std::vector<double> us;
  int lost = 0;
};

void run(std::array<Path*, 3> paths, const ServerPath& server, const sync::WireFrame& frame, int packets,
         std::array<Measured, 3>& measured) {
  sync::StateUpdate update;
  update.parts.resize(1);
  update.parts[0].part = 0;
  update.parts[0].epoch = server.epoch();
  update.parts[0].twist.linear = {0.1, 0.0, 0.0};
  std::vector<std::byte> bytes;
  Micros at = now();
  const int warmUp = 250;
  for (int i = 0; i < packets + warmUp; ++i) {
    at += kPeriod;
    std::this_thread::sleep_until(std::chrono::steady_clock::time_point(std::chrono::microseconds(at)));
    for (Path* path : paths) path->idle(i);
    update.sequence = update.parts[0].sequence = static_cast<std::uint32_t>(i + 1);
    update.parts[0].worldFromPart.position.x = 1e-4 * (i % 1000);
    update.time = server.sessionTime();
    sync::encodeState(update, frame, bytes);
    for (int k = 0; k < 3; ++k) {
      const auto which = static_cast<std::size_t>((i + k) % 3);
      const auto took = paths[which]->travel(bytes, update.sequence);
      if (i < warmUp) continue;
      if (took) measured[which].us.push_back(*took);
      if (!took) ++measured[which].lost;
    }
  }
}

bool compare(bench::Report& report, int packets) {
  const assets::Scene scene = oneBox();
  const sync::WireFrame frame = sync::wireFrame(scene.bounds);
  const sync::TlsIdentity identity = must(sync::makeTlsIdentity());
  PlainPath plain;
  SealedPath sealed(frame, identity);
  ServerPath server(scene, identity);
  const std::array<Path*, 3> paths{&plain, &sealed, &server};
  const std::array<std::string, 3> names{"raw relay, plain ends", "raw relay, sealed ends", "server"};
  std::array<Measured, 3> measured;
  run(paths, server, frame, packets, measured);

  std::array<bench::Percentiles, 3> p;
  for (std::size_t i = 0; i < 3; ++i) {
    p[i] = bench::percentiles(measured[i].us);
    report.row(names[i], "us", p[i]);
  }
  int lost = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double used = paths[i]->stop();
    report.value(names[i] + ", processor", "us/datagram", 1e6 * used / packets);
    lost += measured[i].lost;
  }
  report.value("datagrams a path", "", packets);
  report.value("under SCHED_FIFO", "", sched_getscheduler(0) == SCHED_FIFO ? 1.0 : 0.0);
  bool met = report.bound("lost", lost, 0.0);
  met = report.bound("server / raw relay, p50", p[2].p50 / p[1].p50, 1.5) && met;
  met = report.bound("server / raw relay, p99", p[2].p99 / p[1].p99, 1.5) && met;
  report.value("server / raw relay, p99.9", "", p[2].p999 / p[1].p999);
  report.value("server / plain, p50", "", p[2].p50 / p[0].p50);
  report.value("server / plain, p99", "", p[2].p99 / p[0].p99);
  report.value("server - raw relay, p50", "us", p[2].p50 - p[1].p50);
  return met;
}

}  // namespace

int main(int argc, char** argv) {
  std::string json;
  int packets = 5000;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--json" && i + 1 < argc) {
      json = argv[++i];
    } else if (argument == "--packets" && i + 1 < argc) {
      packets = std::atoi(argv[++i]);
    } else {
      packets = 0;
    }
  }
  if (packets <= 0) {
    std::fprintf(stderr, "usage: bench_relay [--packets N] [--json OUT]\n");
    return 2;
  }
  bench::Report report("bench_relay");
  const bool met = compare(report, packets);
  if (!json.empty() && !report.writeJson(json)) {
    std::fprintf(stderr, "%s: cannot be written\n", json.c_str());
    return 2;
  }
  return met ? 0 : 1;
}
