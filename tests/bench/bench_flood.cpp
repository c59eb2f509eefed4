// What an honest site feels while another admitted site floods the server, one kind of flood after the other:
// round trips of its pings, every 5 ms, against those of quiet stretches in the same run, and how much memory
// the whole process takes more. The server runs as tandem-server does, with its journal on a disk; the
// flooder sends as fast as its connection takes it, and comes back with its ticket when it is parted from.
// The last floods are of strangers: datagrams from a plain socket.
//
// The flooder, the honest site and the server share the machine: with two cores and other work a scheduler's
// turn is in every figure, so that what counts is the difference to quiet. Started with `chrt -f 1`, the
// server and the honest site run before other work, and the flooder, which stands for another machine, does
// not.

#include <arpa/inet.h>
#include <sched.h>
#include <sys/socket.h>

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

/// Takes the calling thread back to the share of the processor that a program has without `chrt`.
void giveWay() {
  const sched_param none{};
  if (sched_setscheduler(0, SCHED_OTHER, &none) != 0) fail("no ordinary scheduling for the flooder");
}

sockaddr_in loopback(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

/// A port whose datagrams nobody reads.
class DeafPort {
 public:
  DeafPort() : socket_(::socket(AF_INET, SOCK_DGRAM, 0)), address_(loopback(0)) {
    socklen_t size = sizeof address_;
    auto* address = reinterpret_cast<sockaddr*>(&address_);
    if (::bind(socket_, address, size) != 0 || ::getsockname(socket_, address, &size) != 0) fail("no socket");
  }
  ~DeafPort() { ::close(socket_); }
  DeafPort(const DeafPort&) = delete;
  DeafPort& operator=(const DeafPort&) = delete;
  std::uint16_t port() const { return ntohs(address_.sin_port); }

 private:
  int socket_;
  sockaddr_in address_;
};

/// Sends datagrams from a plain socket until told to stop; returns how many left, a second. The server knows
/// none of them; with `sealed` they have the size and form of sealed ones.
double floodAsStranger(std::uint16_t port, bool sealed, const std::atomic<bool>& stop) {
  constexpr unsigned kBurst = 64;
  const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
  const sockaddr_in to = loopback(port);
  if (::connect(socket, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) fail("no socket");
  std::mt19937 random{11};
  std::array<std::array<std::uint32_t, 300>, kBurst> bytes{};
  std::array<iovec, kBurst> vectors{};
  std::array<mmsghdr, kBurst> headers{};
  for (unsigned i = 0; i < kBurst; ++i) {
    for (std::uint32_t& word : bytes[i]) word = static_cast<std::uint32_t>(random());
    vectors[i] = {bytes[i].data(), sealed ? 200 : 1 + random() % sizeof bytes[i]};
    headers[i].msg_hdr.msg_iov = &vectors[i];
    headers[i].msg_hdr.msg_iovlen = 1;
  }
  std::uint64_t sent = 0;
  const Stopwatch watch;
  while (!stop) {
    for (auto& datagram : bytes) datagram[0] = static_cast<std::uint32_t>(random());
    const int left = ::sendmmsg(socket, headers.data(), kBurst, 0);
    sent += left > 0 ? static_cast<std::uint64_t>(left) : 0;
  }
  ::close(socket);
  return static_cast<double>(sent) / watch.seconds();
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
  double sent = 0.0, memory_MB = 0.0, processor = 0.0;  // processor: of the server's loop, s/s
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

/// Pings of the honest site while `flood` runs in a thread; it returns how much it sent.
template <typename Send>
Measured beside(Send&& flood, ServerThread& server, Site& honest, double seconds) {
  Measured result;
  std::atomic<bool> stop{false};
  const double before = residentMB();
  std::thread thread([&] {
    giveWay();
    result.sent = flood(stop);
  });
  honest.lost = 0;
  const double used = server.processor_s();
  const Stopwatch watch;
  result.ping_ms = pings(honest, seconds);
  result.processor = (server.processor_s() - used) / watch.seconds();
  result.lost = honest.lost;
  result.memory_MB = residentMB() - before;
  stop = true;
  thread.join();
  return result;
}

Measured besideSite(const Flood& flood, Flooder& flooder, ServerThread& server, Site& honest,
                    double seconds) {
  flooder.udp = flood.udp;
  if (!flood.udp) flooder.comeAnew();
  for (const Micros end = now() + kPatience; !flooder.ready() || flooder.overUdp() != flood.udp;) {
    if (now() > end) fail("a flooder did not come in");
    flooder.turn(sync::kMillisecond);
  }
  Measured result = beside([&](const std::atomic<bool>& stop) { return flooder.flood(flood.burst, stop); },
                           server, honest, seconds);
  result.partings = flooder.partings;
  return result;
}

using Results = std::vector<std::pair<std::string, Measured>>;

bool write(Report& report, const std::vector<double>& quiet, const Results& results) {
  const Percentiles still = percentiles(quiet);
  report.row("ping, quiet", "ms", still);
  bool met = true;
  for (const auto& [name, result] : results) {
    const Percentiles p = percentiles(result.ping_ms);
    report.row(name + ": ping", "ms", p);
    report.value(name + ": sent", "1/s", result.sent);
    report.value(name + ": pings lost", "", result.lost);
    report.value(name + ": parted from", "times", result.partings);
    report.value(name + ": server's processor", "s/s", result.processor);
    report.value(name + ": memory", "MB more", result.memory_MB);
    met = report.bound(name + ": ping - quiet, p99 (ms)", p.p99 - still.p99, kAllowance_ms) && met;
  }
  return met;
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
  Results results;
  const auto keep = [&](const char* name, Measured result) {
    results.emplace_back(name, std::move(result));
    const std::vector<double> more = pings(honest, 0.4 * seconds);
    quiet.insert(quiet.end(), more.begin(), more.end());
  };
  std::size_t used = 1;
  for (const Flood& flood : floods()) {
    Flooder flooder(server, server.token(used++), identity, frame);
    keep(flood.name, besideSite(flood, flooder, server, honest, seconds));
  }
  const DeafPort elsewhere;  // the control: the machine has as much to do, and the server gets nothing of it
  keep("datagrams to another port",
       beside([&](const auto& stop) { return floodAsStranger(elsewhere.port(), true, stop); }, server, honest,
              seconds));
  for (const bool sealed : {false, true})
    keep(sealed ? "sealed datagrams of strangers" : "garbage of strangers over UDP",
         beside([&](const auto& stop) { return floodAsStranger(server.port(), sealed, stop); }, server,
                honest, seconds));
  honest.release_ms(kOwned);  // fails if its lease ran out meanwhile
  return write(report, quiet, results);
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
