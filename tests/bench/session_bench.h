#pragma once

// A server in a thread, with its journal on a disk, and a site that asks one thing at a time: for benches of
// what one site feels of a server.

#include <pthread.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <memory>
#include <thread>

#include "assets/scene/scene_package.h"
#include "server/session.h"
#include "server/journal/sqlite_journal.h"
#include "sync/transport/socket_transport.h"
#include "sync/wire/state_bundle.h"
#include "sync/wire/wire.h"
#include "tests/bench/bench_process.h"
#include "tests/bench/bench_report.h"
#include "tests/support/shapes.h"

namespace tandem::bench {

using sync::Micros;
using Kind = sync::TransportEvent::Kind;

constexpr Micros kPatience = 10 * sync::kSecond;
constexpr Micros kLost = 250 * sync::kMillisecond;  // a ping without an answer for so long
constexpr PartId kBox = 0, kFixed = 1, kOwned = 2;  // kOwned: only in bench_flood's scene

/// A directory of its own below `parent`, removed at the end.
class Folder {
 public:
  explicit Folder(const std::string& parent) : path_(parent + "/tandem-bench-XXXXXX") {
    if (::mkdtemp(path_.data()) == nullptr) fail(path_ + ": cannot be made");
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  std::string file(const char* name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

/// The loop of tandem-server, in a thread.
class ServerThread {
 public:
  ServerThread(const assets::Scene& scene, const std::string& journalPath, const sync::TlsIdentity& identity)
      : package_(assets::packScene(scene)),
        transport_(must(sync::listenOn("127.0.0.1", 0, identity))),
        journal_(must(server::SqliteJournal::open(journalPath, {"bench", 0}))) {
    journal_->onProgress([this] { transport_->wake(); });
    server::SessionConfig config;
    config.key = server::makeSigningKey();
    session_ = std::make_unique<server::Session>(scene, package_, config, *transport_, *journal_, nullptr,
                                                 now(), std::time(nullptr));
    for (std::string& token : tokens_)
      token = session_->makeToken(sync::Role::participant, std::time(nullptr) + 600);
    thread_ = std::thread([this] {
      while (!stop_) {
        transport_->wait(std::clamp<Micros>(session_->nextDeadline() - now(), 0, 100 * sync::kMillisecond));
        session_->step(now(), std::time(nullptr));
      }
    });
  }
  ~ServerThread() {
    stop_ = true;
    transport_->wake();
    thread_.join();
  }
  std::uint16_t port() const { return transport_->port(); }
  /// Processor time that the loop has used, s.
  double processor_s() {
    clockid_t clock{};
    timespec t{};
    if (pthread_getcpuclockid(thread_.native_handle(), &clock) != 0 || clock_gettime(clock, &t) != 0)
      fail("no clock of the server's thread");
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  }
  /// Only after the thread's end, in effect: figures that it may be changing.
  const server::SessionCounters& counters() const { return session_->counters(); }
  static constexpr std::size_t kTokens = 16;
  /// Each is good once.
  const std::string& token(std::size_t i) const { return tokens_[i]; }

 private:
  std::vector<std::byte> package_;
  std::unique_ptr<sync::SocketTransport> transport_;
  std::unique_ptr<server::SqliteJournal> journal_;  // after the transport: its thread wakes it
  std::unique_ptr<server::Session> session_;
  std::array<std::string, kTokens> tokens_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// A site that asks one thing at a time and waits for the answer.
class Site {
 public:
  Site(const ServerThread& server, const std::string& token, const sync::TlsIdentity& identity,
       const sync::WireFrame& frame)
      : frame_(frame),
        transport_(must(sync::connectTo("127.0.0.1", server.port(), must(sync::pinOf(identity))))) {
    waitFor([](const sync::TransportEvent& event) { return event.kind == Kind::connected; });
    say(sync::Hello{sync::kProtocolVersion, false, token, "bench", {1, 2, 3}});
    answer<sync::Welcome>();
    say(sync::Ready{});
    for (const Micros end = now() + kPatience; !transport_->stateOverUdp(0);) {
      if (now() > end) fail("no state over UDP");
      ping_ms();
    }
  }

  /// kLost for a ping that has no answer.
  double ping_ms() {
    const bench::Stopwatch watch;
    sync::encodeState(sync::Ping{++pings_, now()}, frame_, bytes_);
    transport_->sendState(0, bytes_);
    const bool answered = listen(kLost, [&](const sync::TransportEvent& event) {
      for (auto rest = event.bytes; event.kind == Kind::state && !rest.empty();) {
        if (!sync::decodeState(sync::popMessage(rest), frame_, state_)) continue;
        const auto* pong = std::get_if<sync::Pong>(&state_);
        if (pong != nullptr && pong->sequence == pings_) return true;
      }
      return false;
    });
    lost += answered ? 0 : 1;
    return 1e3 * watch.seconds();
  }
  double grab_ms(PartId part, sync::Denial expected) {
    const bench::Stopwatch watch;
    say(sync::Grab{++requests_, part});
    const auto reply = answer<sync::GrabReply>();
    const double took = 1e3 * watch.seconds();
    if (reply.denial != expected) fail(std::string("grab: ") + sync::toString(reply.denial));
    epoch_ = reply.part.epoch;
    return took;
  }
  double release_ms(PartId part) {
    const bench::Stopwatch watch;
    say(sync::Release{++requests_, part, epoch_, {}});
    const auto reply = answer<sync::ReleaseReply>();
    const double took = 1e3 * watch.seconds();
    if (reply.denial != sync::Denial::none) fail(std::string("release: ") + sync::toString(reply.denial));
    return took;
  }

  int lost = 0;  // pings without an answer

 private:
  void say(const sync::ControlMessage& message) { transport_->sendControl(0, sync::encodeControl(message)); }

  template <typename Message>
  Message answer() {
    Message found;
    waitFor([&](const sync::TransportEvent& event) {
      if (event.kind != Kind::control) return false;
      const auto message = must(sync::decodeControl(event.bytes));
      if (const auto* refused = std::get_if<sync::Refused>(&message)) fail(refused->reason);
      const auto* wanted = std::get_if<Message>(&message);
      if (wanted != nullptr) found = *wanted;
      return wanted != nullptr;
    });
    return found;
  }
  template <typename Take>
  void waitFor(Take&& take) {
    if (!listen(kPatience, take)) fail("no answer");
  }
  /// Until `take` has found what it wants; false if it has not after so long.
  template <typename Take>
  bool listen(Micros patience, Take&& take) {
    for (const Micros end = now() + patience; now() < end;) {
      transport_->wait(std::min(end - now(), sync::kSecond));
      bool found = false;
      for (sync::TransportEvent event; transport_->poll(event);) {
        if (event.kind == Kind::closed) fail("the connection ended: " + event.reason);
        found = take(event) || found;
      }
      if (found) return true;
    }
    return false;
  }

  sync::WireFrame frame_;
  std::unique_ptr<sync::SocketTransport> transport_;
  std::vector<std::byte> bytes_;
  sync::StateMessage state_{sync::Pong{}};
  std::uint32_t pings_ = 0;
  sync::RequestId requests_ = 0;
  Epoch epoch_ = 0;
};

inline assets::Scene twoBoxes() {
  assets::Scene scene;
  scene.materials.emplace_back();
  scene.meshes.push_back(test::boxMesh({0.1, 0.1, 0.1}));
  scene.parts.resize(2);
  for (auto& part : scene.parts) {
    part.mesh = 0;
    part.massProperties = {1.0, {0.0, 0.0, 0.0}, glm::dmat3(0.01)};
  }
  scene.parts[kBox].name = "box";
  scene.parts[kBox].movable = true;
  scene.parts[kFixed].name = "fixed";
  scene.bounds = scene.meshes[0].bounds;
  return scene;
}

}  // namespace tandem::bench
