// What a session of many sites costs the server: one thread runs the real session over real sockets on
// 127.0.0.1, as tandem-server does; another one plays N sites that each move a part, and M observers, without
// haptics. All sites send; every site and observer acknowledges what it gets, as the real ones do.
//
//   processor     of the server's thread, in s a second, and by stage (tests/bench/stage_sampler.h)
//   delay         from the time of a state to its arrival at a site that decodes it: both ends have one clock
//   lost          gaps in the sequences that the server gives to the updates for one receiver
//   yardstick     the same number of datagrams of the same mean size through bare sockets in the same run:
//                 sendmmsg on one thread, recvmmsg on another; processor time of both ends
//
// The load takes a core of its own, so that delays and losses are those of a machine that is full; the
// server's processor time is what counts.

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <memory>
#include <optional>
#include <thread>

#include "assets/base/command_line.h"
#include "assets/scene/scene_package.h"
#include "server/journal/memory_journal.h"
#include "server/session.h"
#include "sync/transport/socket_transport.h"
#include "sync/wire/state_bundle.h"
#include "sync/wire/state_receiver.h"
#include "sync/wire/state_sender.h"
#include "sync/wire/wire.h"
#include "tests/bench/bench_process.h"
#include "tests/bench/bench_report.h"
#include "tests/bench/stage_sampler.h"
#include "tests/support/shapes.h"

namespace {

using namespace tandem;
using bench::fail;
using bench::must;
using bench::now;
using bench::threadSeconds;
using sync::Micros;
using Kind = sync::TransportEvent::Kind;

constexpr Micros kPatience = 60 * sync::kSecond;  // for all to come in
constexpr Micros kPingPeriod = 100 * sync::kMillisecond;
constexpr int kDecoders = 6;  // sites and observers, each, that decode all that they get

struct Setup {
  int sites = 64, observers = 0;
  double hz = 60.0, seconds = 5.0;
  double spacing = 1.0;  // m between the places of the sites
  std::string json;
};

/// A box for each site, on a square grid.
assets::Scene boxes(const Setup& setup) {
  assets::Scene scene;
  scene.materials.emplace_back();
  scene.meshes.push_back(test::boxMesh({0.1, 0.1, 0.1}));
  const int side = static_cast<int>(std::ceil(std::sqrt(setup.sites)));
  for (int i = 0; i < setup.sites; ++i) {
    assets::Part& part = scene.parts.emplace_back();
    part.name = "box " + std::to_string(i);
    part.mesh = 0;
    part.movable = true;
    part.massProperties = {1.0, {0.0, 0.0, 0.0}, glm::dmat3(0.01)};
    part.worldFromPart.position = {setup.spacing * (i % side), setup.spacing * (i / side), 0.0};
  }
  scene.bounds = {glm::dvec3(-0.5), glm::dvec3(setup.spacing * side, setup.spacing * side, 0.5)};
  return scene;
}

/// One scripted site, or an observer.
class Light {
 public:
  Light(const sync::WireFrame& frame, std::string token, sync::Role role, bool decodes, std::uint16_t port,
        const std::string& pin)
      : frame_(frame),
        token_(std::move(token)),
        decodes_(decodes),
        role_(role),
        transport_(must(sync::connectTo("127.0.0.1", port, pin, {true, kPatience}))) {}

  bool ready() const { return ready_ && (role_ == sync::Role::observer || epoch_ != 0); }
  bool overUdp() const { return transport_->stateOverUdp(0); }

  /// Runs the sockets and answers what comes.
  void turn() {
    transport_->wait(0);
    for (sync::TransportEvent event; transport_->poll(event);) {
      if (event.kind == Kind::closed) fail("a connection ended: " + event.reason);
      if (event.kind == Kind::connected)
        say(sync::Hello{sync::kProtocolVersion, false, token_, "", {1, 2, 3}});
      if (event.kind == Kind::control) onControl(event.bytes);
      if (event.kind != Kind::state) continue;
      ++datagrams;
      for (auto rest = event.bytes; !rest.empty();) onState(sync::popMessage(rest));
    }
    acknowledge();
    if (ready_ && now() >= nextPing_) {
      nextPing_ = now() + kPingPeriod;
      send(sync::Ping{++pings_, now()});
    }
  }
  void grab(PartId part) {
    part_ = part;
    say(sync::Grab{1, part});
  }
  bool mayGrab() const { return ready_ && part_ == kNoPart && role_ != sync::Role::observer; }

  /// Sends where the part and the hand are now: they go round, 10 cm about their place, in two seconds.
  void move(const glm::dvec3& place) {
    const double angle = M_PI * sync::toSeconds(now());
    sync::StateUpdate update;
    update.sequence = ++sequence_;
    update.time = now();
    update.presence.worldFromTool.position = place + 0.1 * glm::dvec3(std::cos(angle), std::sin(angle), 0.0);
    update.presence.worldFromCamera.position = place + glm::dvec3(0.0, 0.0, 1.0);
    update.presence.touched = part_;
    update.parts.push_back({part_, epoch_, sequence_, update.presence.worldFromTool, {}});
    update.parts[0].twist.linear = 0.1 * M_PI * glm::dvec3(-std::sin(angle), std::cos(angle), 0.0);
    sender_.encode(update, frame_, bytes_);
    transport_->sendState(0, bytes_);
  }

  void beginMeasuring() {
    delays_ms.clear();
    datagrams = updates = gaps = undecoded = 0;
    counted_ = false;
  }

  std::vector<double> delays_ms;
  std::uint64_t datagrams = 0, updates = 0, gaps = 0, undecoded = 0;

 private:
  void say(const sync::ControlMessage& message) { transport_->sendControl(0, sync::encodeControl(message)); }
  void send(const sync::StateMessage& message) {
    sync::encodeState(message, frame_, bytes_);
    transport_->sendState(0, bytes_);
  }
  void onControl(std::span<const std::byte> bytes) {
    const auto message = must(sync::decodeControl(bytes));
    if (const auto* refused = std::get_if<sync::Refused>(&message)) fail(refused->reason);
    if (std::holds_alternative<sync::Welcome>(message)) {
      ready_ = true;
      say(sync::Ready{});
    }
    const auto* reply = std::get_if<sync::GrabReply>(&message);
    if (reply == nullptr) return;
    if (reply->denial != sync::Denial::none) fail(sync::toString(reply->denial));
    epoch_ = reply->part.epoch;
  }
  void onState(std::span<const std::byte> bytes) {
    if (bytes.size() > 1 && bytes[1] == static_cast<std::byte>(sync::StateKind::ack)) {
      if (sync::decodeState(bytes, frame_, message_))
        sender_.acknowledged(std::get<sync::StateAck>(message_));
      return;
    }
    if (!sync::isStateUpdate(bytes) || bytes.size() < 9) return;
    std::uint32_t sequence = 0;
    std::memcpy(&sequence, bytes.data() + 4, sizeof sequence);
    count(sequence);
    if (!decodes_) {
      const bool keep = (bytes[8] & std::byte{1}) != std::byte{0};
      if (keep && kept_.size() < sync::StateAck::kMax) kept_.push_back(sequence);
      return;
    }
    if (receiver_.decode(bytes, frame_, message_) != sync::StateReceiver::Outcome::decoded) {
      ++undecoded;
      return;
    }
    const auto* update = std::get_if<sync::StateUpdate>(&message_);
    delays_ms.push_back(1e-3 * static_cast<double>(now() - update->time));
  }
  void count(std::uint32_t sequence) {
    ++updates;
    if (counted_ && sequence > last_ + 1) gaps += sequence - last_ - 1;
    last_ = counted_ ? std::max(last_, sequence) : sequence;
    counted_ = true;
  }
  void acknowledge() {
    if (decodes_) {
      if (const auto ack = receiver_.drainAck(now())) send(*ack);
      return;
    }
    if (kept_.empty() || now() - acknowledgedAt_ < sync::kCrowdAckInterval) return;
    acknowledgedAt_ = now();
    sync::StateAck ack;
    for (const std::uint32_t sequence : kept_) ack.sequences[ack.count++] = sequence;
    kept_.clear();
    send(ack);
  }

  sync::WireFrame frame_;
  std::string token_;
  bool decodes_, ready_ = false, counted_ = false;
  sync::Role role_;
  std::unique_ptr<sync::SocketTransport> transport_;
  sync::StateReceiver receiver_;
  sync::StateSender sender_;
  sync::StateMessage message_{sync::StateUpdate{}};
  std::vector<std::byte> bytes_;
  std::vector<std::uint32_t> kept_;
  PartId part_ = kNoPart;
  Epoch epoch_ = 0;
  std::uint32_t sequence_ = 0, pings_ = 0, last_ = 0;
  Micros nextPing_ = 0, acknowledgedAt_ = 0;
};

/// All sites and observers, on the thread that calls.
class Load {
 public:
  Load(const Setup& setup, const assets::Scene& scene, std::vector<std::string> tokens, std::uint16_t port,
       std::string pin)
      : setup_(setup),
        scene_(scene),
        frame_(sync::wireFrame(scene.bounds)),
        tokens_(std::move(tokens)),
        port_(port),
        pin_(std::move(pin)) {}

  /// A few at a time, so that nobody's handshake waits for long.
  void joinAll() {
    constexpr std::size_t kAtOnce = 8;
    const Micros end = now() + kPatience;
    for (std::size_t in = 0; in < tokens_.size() || !allReady();) {
      if (now() > end)
        fail("not all came in: " + std::to_string(in) + " of " + std::to_string(tokens_.size()));
      if (in < tokens_.size() && (in < kAtOnce || lights_[in - kAtOnce]->ready())) {
        const bool observer = in >= static_cast<std::size_t>(setup_.sites);
        const std::size_t place = observer ? in - static_cast<std::size_t>(setup_.sites) : in;
        lights_.push_back(std::make_unique<Light>(frame_, tokens_[in],
                                                  observer ? sync::Role::observer : sync::Role::participant,
                                                  place < kDecoders, port_, pin_));
        ++in;
      }
      turnAll();
      for (std::size_t i = 0; i < lights_.size(); ++i)
        if (lights_[i]->mayGrab()) lights_[i]->grab(static_cast<PartId>(i));
    }
  }
  void run(double seconds) {
    const auto period = static_cast<Micros>(1e6 / setup_.hz);
    const Micros start = now(), end = start + static_cast<Micros>(seconds * 1e6);
    const auto sites = static_cast<std::size_t>(setup_.sites);
    std::vector<Micros> next(sites);
    for (std::size_t i = 0; i < sites; ++i)
      next[i] = start + static_cast<Micros>(i) * period / static_cast<Micros>(sites);
    while (now() < end) {
      for (std::size_t i = 0; i < sites; ++i) {
        if (now() < next[i]) continue;
        next[i] = std::max(next[i] + period, now() - period);
        lights_[i]->move(scene_.parts[i].worldFromPart.position);
        ++sent;
      }
      turnAll();
    }
  }
  void beginMeasuring() {
    sent = 0;
    for (const auto& light : lights_) light->beginMeasuring();
  }
  const std::vector<std::unique_ptr<Light>>& lights() const { return lights_; }
  std::uint64_t sent = 0;
  double processor_s = 0.0;  // of run()

 private:
  /// Observers only send pings and acknowledgements, and take turns, so that the load fits on one core.
  void turnAll() {
    constexpr std::size_t kObserverTurns = 8;
    ++turns_;
    const auto sites = static_cast<std::size_t>(setup_.sites);
    for (std::size_t i = 0; i < lights_.size(); ++i)
      if (i < sites || i % kObserverTurns == turns_ % kObserverTurns) lights_[i]->turn();
  }
  bool allReady() const {
    return std::all_of(lights_.begin(), lights_.end(),
                       [](const auto& light) { return light->ready() && light->overUdp(); });
  }

  const Setup& setup_;
  const assets::Scene& scene_;
  sync::WireFrame frame_;
  std::vector<std::string> tokens_;
  std::uint16_t port_;
  std::string pin_;
  std::vector<std::unique_ptr<Light>> lights_;
  std::size_t turns_ = 0;
};

// ---- the server ----

struct ServerFigures {
  double processor_s = 0.0, time_s = 0.0;
  sync::TransportCounters transport;
  server::SessionCounters session;
  std::map<std::string, double> stages;
  std::size_t samples = 0;
};

sync::TransportCounters operator-(sync::TransportCounters a, const sync::TransportCounters& b) {
  a.stateBytesOut -= b.stateBytesOut;
  a.statePacketsIn -= b.statePacketsIn;
  a.statePacketsOut -= b.statePacketsOut;
  a.droppedFull -= b.droppedFull;
  return a;
}

/// Innermost first: what a stage calls belongs to it.
const std::vector<bench::StageSampler::Rule> kStages{
    {"sendmmsg", "send"},
    {"sendto", "send"},
    {"__send", "send"},
    {"DatagramQueue::flush", "send"},
    {"sendDatagram", "send"},
    {"Sealer::seal", "seal"},
    {"Opener::open", "open"},
    {"recvmmsg", "receive"},
    {"UdpBatch", "receive"},
    {"StateReceiver::", "decode"},
    {"StateSender::", "encode"},
    {"SharedState", "encode"},
    {"sync::encodeState", "encode"},
    {"StateBundle", "encode"},
    {"StateRelay::relay", "fan out"},
    {"StateRelay::send", "fan out"},
    {"StateRelay::flush", "fan out"},
    {"StateRelay", "check"},
    {"OwnershipTable", "check"},
    {"sendState", "send"},
    {"SocketCore::", "receive"},
    {"server::Session", "session, else"},
};

class Server {
 public:
  Server(const Setup& setup, const assets::Scene& scene, const sync::TlsIdentity& identity)
      : package_(assets::packScene(scene)), transport_(must(listen(setup, identity))) {
    server::SessionConfig config;
    config.key = server::makeSigningKey();
    config.places = {static_cast<std::size_t>(setup.sites), static_cast<std::size_t>(setup.observers)};
    session_ = std::make_unique<server::Session>(scene, package_, config, *transport_, journal_, nullptr,
                                                 now(), std::time(nullptr));
  }
  std::vector<std::string> tokens(const Setup& setup) const {
    std::vector<std::string> made;
    for (int i = 0; i < setup.sites + setup.observers; ++i)
      made.push_back(session_->makeToken(i < setup.sites ? sync::Role::participant : sync::Role::observer,
                                         std::time(nullptr) + 600));
    return made;
  }
  std::uint16_t port() const { return transport_->port(); }

  /// Serves until `phase` is 2; measures while it is 1.
  ServerFigures serve(const std::atomic<int>& phase) {
    ServerFigures figures;
    bench::StageSampler sampler;
    while (phase == 0) step();
    const double processor = threadSeconds();
    const Micros began = now();
    const sync::TransportCounters before = transport_->counters();
    const server::SessionCounters sessionBefore = session_->counters();
    sampler.begin();
    while (phase == 1) step();
    sampler.end();
    figures.processor_s = threadSeconds() - processor;
    figures.time_s = sync::toSeconds(now() - began);
    figures.transport = transport_->counters() - before;
    figures.session = session_->counters();
    figures.session.relayedUpdates -= sessionBefore.relayedUpdates;
    figures.session.droppedFlood -= sessionBefore.droppedFlood;
    figures.session.sent.parts.packets -= sessionBefore.sent.parts.packets;
    figures.stages = sampler.shares(kStages);
    figures.samples = sampler.samples();
    return figures;
  }

 private:
  static Result<std::unique_ptr<sync::SocketTransport>> listen(const Setup& setup,
                                                               const sync::TlsIdentity& identity) {
    sync::ListenOptions options;
    options.maxConnections = static_cast<std::size_t>(setup.sites + setup.observers) + 8;
    return sync::listenOn("127.0.0.1", 0, identity, options);
  }
  void step() {
    journal_.advanceTo(now());
    transport_->wait(std::clamp<Micros>(session_->nextDeadline() - now(), 0, 100 * sync::kMillisecond));
    session_->step(now(), std::time(nullptr));
    session_->drainLog();
    session_->drainUsedTokens();
  }

  std::vector<std::byte> package_;
  std::unique_ptr<sync::SocketTransport> transport_;
  server::MemoryJournal journal_;
  std::unique_ptr<server::Session> session_;
};

// ---- the yardstick ----

/// Processor time of sending a datagram of this size with sendmmsg, and of receiving it with recvmmsg, in us.
std::array<double, 2> bareSockets(std::size_t bytes, int datagrams) {
  constexpr int kBatch = 32;
  const int from = socket(AF_INET, SOCK_DGRAM, 0), to = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  const timeval limit{0, 20000};
  setsockopt(to, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  if (bind(to, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) fail("no UDP socket");
  getsockname(to, reinterpret_cast<sockaddr*>(&address), &size);
  std::vector<std::byte> storage(kBatch * bytes);
  std::array<iovec, kBatch> vectors{};
  std::array<mmsghdr, kBatch> out{}, in{};
  for (int i = 0; i < kBatch; ++i) {
    const auto k = static_cast<std::size_t>(i);
    vectors[k] = {storage.data() + k * bytes, bytes};
    out[k].msg_hdr = {&address, sizeof address, &vectors[k], 1, nullptr, 0, 0};
    in[k].msg_hdr = {nullptr, 0, &vectors[k], 1, nullptr, 0, 0};
  }
  double sendTime = 0.0, receiveTime = 0.0;
  int received = 0;
  for (int i = 0; i < datagrams; i += kBatch) {
    const double begun = threadSeconds();
    if (sendmmsg(from, out.data(), kBatch, 0) != kBatch) fail("sendmmsg");
    const double sent = threadSeconds();
    received += std::max(0, recvmmsg(to, in.data(), kBatch, MSG_DONTWAIT, nullptr));
    sendTime += sent - begun;
    receiveTime += threadSeconds() - sent;
  }
  close(from);
  close(to);
  return {1e6 * sendTime / datagrams, 1e6 * receiveTime / std::max(received, 1)};
}

// ---- the report ----

void delayRow(bench::Report& report, const std::string& name, const Load& load, std::size_t from,
              std::size_t to) {
  std::vector<double> all;
  for (std::size_t i = from; i < to; ++i) {
    const auto& some = load.lights()[i]->delays_ms;
    all.insert(all.end(), some.begin(), some.end());
  }
  if (!all.empty()) report.row(name, "ms", bench::percentiles(all));
}

void write(bench::Report& report, const Setup& setup, const Load& load, const ServerFigures& figures) {
  const double seconds = figures.time_s;
  const auto sites = static_cast<std::size_t>(setup.sites);
  std::uint64_t datagrams = 0, updates = 0, gaps = 0, undecoded = 0;
  for (const auto& light : load.lights()) {
    datagrams += light->datagrams;
    updates += light->updates;
    gaps += light->gaps;
    undecoded += light->undecoded;
  }
  const auto in = static_cast<double>(figures.transport.statePacketsIn),
             out = static_cast<double>(figures.transport.statePacketsOut);
  report.value("sites", "", setup.sites);
  report.value("observers", "", setup.observers);
  report.value("load: processor", "s/s", load.processor_s / seconds);
  report.value("updates that sites sent", "1/s", static_cast<double>(load.sent) / seconds);
  report.value("server: datagrams in", "1/s", in / seconds);
  report.value("server: datagrams out", "1/s", out / seconds);
  report.value("server: bytes out", "MB/s",
               1e-6 * static_cast<double>(figures.transport.stateBytesOut) / seconds);
  report.value("updates delivered", "1/s", static_cast<double>(updates) / seconds);
  report.value("server: processor", "s/s", figures.processor_s / seconds);
  for (const auto& [stage, share] : figures.stages)
    report.value("  " + stage, "s/s", share * figures.processor_s / seconds);
  report.value("samples of the stages", "", static_cast<double>(figures.samples));
  const double each = 1e6 * figures.processor_s;
  report.value("server: processor", "us a datagram", each / (in + out));
  report.value("server: processor", "us an update delivered", each / static_cast<double>(updates));
  delayRow(report, "delay to a site", load, 0, std::min<std::size_t>(kDecoders, sites));
  delayRow(report, "delay to an observer", load, sites,
           std::min<std::size_t>(sites + kDecoders, load.lights().size()));
  report.value("lost on the way", "share", static_cast<double>(gaps) / static_cast<double>(gaps + updates));
  report.value("not decoded, baseline lost", "", static_cast<double>(undecoded));
  report.value("dropped at the socket", "", static_cast<double>(figures.transport.droppedFull));
  const auto bare = bareSockets(
      static_cast<std::size_t>(static_cast<double>(figures.transport.stateBytesOut) / std::max(out, 1.0)) +
          32,
      200000);
  report.value("bare sendmmsg", "us a datagram", bare[0]);
  report.value("bare recvmmsg", "us a datagram", bare[1]);
  report.value("server / bare sockets", "", each / (out * bare[0] + in * bare[1]));
}

bool run(bench::Report& report, const Setup& setup) {
  const assets::Scene scene = boxes(setup);
  const sync::TlsIdentity identity = must(sync::makeTlsIdentity());
  Server server(setup, scene, identity);
  Load load(setup, scene, server.tokens(setup), server.port(), must(sync::pinOf(identity)));
  std::atomic<int> phase{0};
  ServerFigures figures;
  std::thread thread([&] { figures = server.serve(phase); });
  load.joinAll();
  load.run(1.5);  // until all have baselines
  load.beginMeasuring();
  phase = 1;
  const double begun = threadSeconds();
  load.run(setup.seconds);
  load.processor_s = threadSeconds() - begun;
  phase = 2;
  thread.join();
  write(report, setup, load, figures);
  return report.bound("server: processor (s/s)", figures.processor_s / figures.time_s, 1.0);
}

}  // namespace

int main(int argc, char** argv) {
  Setup setup;
  assets::CommandLine line("What a session of many sites costs the server.", "bench_load_server");
  line.option("--sites", setup.sites, "sites that each move a part").showDefault().integerFrom(1, 100'000);
  line.option("--observers", setup.observers, "sites that look on").showDefault().integerFrom(0, 100'000);
  line.option("--hz", setup.hz, "updates a second of a site").showDefault().numberFrom(1e-9, 1e9);
  line.option("--seconds", setup.seconds, "of the session").showDefault().numberFrom(1e-9, 1e9);
  line.option("--spacing", setup.spacing, "m between the places of the sites").showDefault();
  line.option("--json", setup.json, "writes the figures").typeName("FILE");
  if (const std::optional<int> code = line.parse("bench_load_server", argc, argv)) return *code;
  const rlimit files{8192, 8192};
  setrlimit(RLIMIT_NOFILE, &files);
  bench::Report report("bench_load_server");
  const bool met = run(report, setup);
  if (!setup.json.empty() && !report.writeJson(setup.json)) {
    std::fprintf(stderr, "%s: cannot be written\n", setup.json.c_str());
    return 2;
  }
  return met ? 0 : 1;
}
