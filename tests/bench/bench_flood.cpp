// What an honest site feels while another admitted site floods the server, one kind of flood after the other:
// round trips of its pings, every 5 ms, against those of quiet stretches in the same run, and how much memory
// the whole process takes more. The server runs as tandem-server does, with its journal on a disk; the
// flooder sends as fast as its connection takes it, and comes back with its ticket when it is parted from.
//
// The flooder, the honest site and the server share the machine: with two cores and other work a scheduler's
// turn is in every figure, so that what counts is the difference to quiet.

#include <algorithm>
#include <fstream>
#include <functional>
#include <random>

#include "sync/wire/state_sender.h"
#include "tests/bench/session_bench.h"

namespace {

using namespace tandem;
using namespace tandem::bench;

constexpr double kAllowance_ms = 5.0;
constexpr std::size_t kMaxQueued = 1 << 20;  // bytes that the flooder lets wait in its own process

double residentMB() {
  std::ifstream in("/proc/self/statm");
  double pages = 0.0, resident = 0.0;
  in >> pages >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / 1e6;
}

/// A site that sends what it is given, without a pause.
class Flooder {
 public:
  Flooder(const ServerThread& server, std::string token, const sync::TlsIdentity& identity,
          const sync::WireFrame& frame)
      : server_(server), credential_(std::move(token)), pin_(must(sync::pinOf(identity))), frame_(frame) {
    connect();
  }

  /// Messages that left, a second.
  double flood(const std::function<void(Flooder&)>& burst, const std::atomic<bool>& stop) {
    const Stopwatch watch;
    sent_ = 0;
    while (!stop) {
      if (ready_)
        for (int i = 0; i < 100 && transport_->controlBacklog(0) < kMaxQueued && ready_; ++i) burst(*this);
      turn(ready_ ? 0 : sync::kMillisecond);
    }
    return static_cast<double>(sent_) / watch.seconds();
  }
  void turn(Micros timeout) {
    transport_->wait(timeout);
    bool closed = false;
    for (sync::TransportEvent event; transport_->poll(event);) {
      if (event.kind == Kind::connected)
        transport_->sendControl(0, sync::encodeControl(sync::Hello{
                                       sync::kProtocolVersion, resumes_, credential_, name(), {1, 2, 3}}));
      if (event.kind == Kind::closed) closed = true;
      if (event.kind == Kind::control) take(event.bytes);
    }
    if (!closed) return;
    ++partings;
    connect();
  }
  void say(const sync::ControlMessage& message) { sayBytes(sync::encodeControl(message)); }
  void sayBytes(std::span<const std::byte> message) {
    transport_->sendControl(0, message);
    ++sent_;
  }
  void state(std::span<const std::byte> message) {
    transport_->sendState(0, message);
    ++sent_;
  }
  void comeAnew() {
    ++sent_;
    connect();
  }
  bool overUdp() const { return transport_->stateOverUdp(0); }
  bool ready() const { return ready_; }
  sync::RequestId nextRequest() { return ++requests_; }
  const sync::WireFrame& frame() const { return frame_; }

  bool udp = true;
  int partings = 0;
  Epoch epoch = 0;
  std::mt19937 random{7};
  sync::StateUpdate update;
  std::vector<std::byte> bytes;

 private:
  void connect() {
    ready_ = false;
    transport_ = must(sync::connectTo("127.0.0.1", server_.port(), pin_, {udp, kPatience}));
  }
  std::string name() { return "flooder " + std::to_string(++names_); }
  void take(std::span<const std::byte> received) {
    const auto message = sync::decodeControl(received);
    if (!message) return;
    if (const auto* welcome = std::get_if<sync::Welcome>(&*message)) {
      credential_ = welcome->resumeTicket;
      resumes_ = ready_ = true;
      transport_->sendControl(0, sync::encodeControl(sync::Ready{}));
    }
    if (const auto* reply = std::get_if<sync::GrabReply>(&*message)) epoch = reply->part.epoch;
  }

  const ServerThread& server_;
  std::string credential_, pin_;
  sync::WireFrame frame_;
  std::unique_ptr<sync::SocketTransport> transport_;
  bool ready_ = false, resumes_ = false;
  int names_ = 0;
  std::uint64_t sent_ = 0;
  sync::RequestId requests_ = 0;
};

void sendState(Flooder& flooder) {
  flooder.update.sequence++;
  flooder.update.time = now();
  flooder.update.presence.worldFromTool.position.x = 1e-3 * (flooder.update.sequence % 100);
  sync::encodeState(flooder.update, flooder.frame(), flooder.bytes);
  flooder.state(flooder.bytes);
}

struct Flood {
  const char* name;
  bool udp;
  std::function<void(Flooder&)> burst;
};

std::vector<Flood> floods() {
  return {
      {"grab and release", true,
       [](Flooder& f) {
         f.say(sync::Grab{f.nextRequest(), kBox});
         f.say(sync::Release{f.nextRequest(), kBox, f.epoch, {}});
       }},
      {"engage and let be", true,
       [](Flooder& f) {
         f.say(sync::Engage{f.nextRequest(), kOwned});
         f.say(sync::Disengage{f.nextRequest(), kOwned});
       }},
      {"scene requests", true, [](Flooder& f) { f.say(sync::SceneRequest{0}); }},
      {"hellos with new names", true, [](Flooder& f) { f.comeAnew(); }},
      {"control garbage", true,
       [](Flooder& f) {
         f.bytes.resize(1 + f.random() % 2000);
         for (std::byte& b : f.bytes) b = static_cast<std::byte>(f.random());
         f.sayBytes(f.bytes);
       }},
      {"large messages", true,
       [](Flooder& f) { f.sayBytes(std::vector<std::byte>(sync::kMaxControlBytes)); }},
      {"states over UDP", true, sendState},
      {"garbage over UDP", true,
       [](Flooder& f) {
         f.bytes.assign(1 + f.random() % 1100, static_cast<std::byte>(f.random()));
         f.state(f.bytes);
       }},
      {"states over TLS", false, sendState},
  };
}

struct Measured {
  std::vector<double> ping_ms;
  double sent = 0.0, memory_MB = 0.0;
  int partings = 0, lost = 0;
};

std::vector<double> pings(Site& honest, double seconds) {
  std::vector<double> ms;
  for (const Stopwatch watch; watch.seconds() < seconds;) {
    ms.push_back(honest.ping_ms());
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return ms;
}

bool run(Report& report, const std::string& data, double seconds) {
  const Folder folder(data);
  assets::Scene scene = twoBoxes();
  scene.parts.push_back(scene.parts[kBox]);
  scene.parts[kOwned].name = "held by the honest site";
  const sync::TlsIdentity identity = must(sync::makeTlsIdentity());
  ServerThread server(scene, folder.file("session.db"), identity);
  const sync::WireFrame frame = sync::wireFrame(scene.bounds);
  Site honest(server, server.token(0), identity, frame);
  honest.grab_ms(kOwned, sync::Denial::none);
  std::vector<double> quiet = pings(honest, seconds);
  std::vector<std::pair<std::string, Measured>> results;
  std::size_t used = 1;
  for (const Flood& flood : floods()) {
    Flooder flooder(server, server.token(used++), identity, frame);
    flooder.udp = flood.udp;
    if (!flood.udp) flooder.comeAnew();
    for (const Micros end = now() + kPatience; !flooder.ready() || flooder.overUdp() != flood.udp;) {
      if (now() > end) fail("a flooder did not come in");
      flooder.turn(sync::kMillisecond);
    }
    Measured result;
    std::atomic<bool> stop{false};
    const double before = residentMB();
    std::thread thread([&] { result.sent = flooder.flood(flood.burst, stop); });
    honest.lost = 0;
    result.ping_ms = pings(honest, seconds);
    result.lost = honest.lost;
    std::fprintf(stderr, "%s\n", flood.name);
    result.memory_MB = residentMB() - before;
    stop = true;
    thread.join();
    result.partings = flooder.partings;
    results.emplace_back(flood.name, std::move(result));
    const std::vector<double> more = pings(honest, 0.4 * seconds);
    quiet.insert(quiet.end(), more.begin(), more.end());
  }
  const Percentiles still = percentiles(quiet);
  report.row("ping, quiet", "ms", still);
  bool met = true;
  for (auto& [name, result] : results) {
    const Percentiles p = percentiles(result.ping_ms);
    report.row(name + ": ping", "ms", p);
    report.value(name + ": sent", "1/s", result.sent);
    report.value(name + ": pings lost", "", result.lost);
    report.value(name + ": parted from", "times", result.partings);
    report.value(name + ": memory", "MB more", result.memory_MB);
    met = report.bound(name + ": ping - quiet, p99 (ms)", p.p99 - still.p99, kAllowance_ms) && met;
  }
  honest.release_ms(kOwned);  // fails if its lease ran out meanwhile
  return met;
}

}  // namespace

int main(int argc, char** argv) {
  std::string json, data = std::filesystem::temp_directory_path().string();
  double seconds = 3.0;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string argument = argv[i];
    if (argument == "--json")
      json = argv[i + 1];
    else if (argument == "--data")
      data = argv[i + 1];
    else if (argument == "--seconds")
      seconds = std::atof(argv[i + 1]);
    else
      seconds = 0.0;
  }
  if (argc % 2 == 0 || seconds <= 0.0) {
    std::fprintf(stderr, "usage: bench_flood [--seconds S] [--data DIR] [--json OUT]\n");
    return 2;
  }
  Report out("bench_flood");
  const bool met = run(out, data, seconds);
  if (!json.empty() && !out.writeJson(json)) {
    std::fprintf(stderr, "%s: cannot be written\n", json.c_str());
    return 2;
  }
  return met ? 0 : 1;
}
