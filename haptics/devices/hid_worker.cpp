#include "haptics/devices/hid_worker.h"

#include <array>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <thread>

#include "assets/base/assert.h"

namespace tandem::haptics {
namespace {

constexpr auto kRetry = std::chrono::milliseconds(200);
constexpr auto kSettling =
    std::chrono::milliseconds(600);  // udev sets a new node's permissions after it is there
constexpr auto kPresenceCheck = std::chrono::milliseconds(500);

}  // namespace

struct HidWorker::State {
  State(HidBus& b, HidClient& c) : bus(b), client(c) {}

  void run();
  void work();
  Status connect();
  Status reconnect();
  void lose();

  HidBus& bus;
  HidClient& client;
  std::unique_ptr<HidConnection> connection;
  std::string path;
  std::chrono::steady_clock::time_point lastPresent;
  std::array<std::uint8_t, kLongestReport> buffer{};
  bool forbidden = false;          // the last attempt failed for want of permission
  bool reportedForbidden = false;  // since the device was lost
  std::chrono::steady_clock::time_point forbiddenSince;

  std::thread thread;
  std::mutex mutex;
  std::condition_variable wake;
  bool stopping = false;  // under mutex
};

void HidWorker::State::run() {
  for (;;) {
    {
      std::unique_lock lock(mutex);
      if (!connection && !stopping) wake.wait_for(lock, kRetry, [this] { return stopping; });
      if (stopping) break;
    }
    if (connection || reconnect().ok()) work();
  }
  if (connection) client.end(*connection);
  lose();
}

void HidWorker::State::work() {
  ASSERT(connection != nullptr);
  const int length = connection->read(buffer, client.readTimeout_ms());
  ASSERT(length <= static_cast<int>(buffer.size()));
  if (length < 0) return lose();
  const auto now = std::chrono::steady_clock::now();
  if (length > 0) {
    lastPresent = now;
    client.report(std::span<const std::uint8_t>(buffer).first(static_cast<std::size_t>(length)));
  } else if (now - lastPresent > kPresenceCheck) {
    // Some buses report a removed device as silence, so the presence of its node is checked.
    lastPresent = now;
    if (!bus.present(path)) return lose();
  }
  if (!client.service(*connection).ok()) lose();
}

Status HidWorker::State::connect() {
  Error why{std::string(client.what()) + ": none is connected"};
  forbidden = false;
  for (const HidInfo& info : bus.enumerate()) {
    if (!client.serves(info)) continue;
    auto opened = bus.open(info.path);
    if (!opened) {
      why = {std::string(client.what()) + ": " + opened.error().message};
      if (bus.forbids(info.path)) {
        forbidden = true;
        why.message += "; 'tandem devices --udev-rule' prints the rule that lets you open it";
      }
      continue;
    }
    if (Status begun = client.begin(**opened, info); !begun) {
      why = {std::string(client.what()) + ": " + info.path + ": " + begun.error().message};
      continue;
    }
    connection = std::move(opened).value();
    path = info.path;
    lastPresent = std::chrono::steady_clock::now();
    reportedForbidden = false;
    return {};
  }
  return why;
}

/// An attempt of the thread itself to find the device again. No caller receives its error, so a lack of
/// permission that lasts is reported once on standard error.
Status HidWorker::State::reconnect() {
  const bool before = forbidden;
  Status connected = connect();
  const auto now = std::chrono::steady_clock::now();
  if (!forbidden || !before) forbiddenSince = now;
  if (forbidden && !reportedForbidden && now - forbiddenSince > kSettling) {
    reportedForbidden = true;
    std::fprintf(stderr, "tandem: %s; still trying\n", connected.error().message.c_str());
  }
  return connected;
}

void HidWorker::State::lose() {
  connection.reset();
  client.lost();
}

HidWorker::HidWorker(HidBus& bus, HidClient& client) : state_(std::make_unique<State>(bus, client)) {}

HidWorker::~HidWorker() { close(); }

Status HidWorker::open() {
  State& s = *state_;
  if (s.thread.joinable()) return {};
  const auto start = std::chrono::steady_clock::now();
  Status connected = s.connect();
  while (!connected && s.forbidden && std::chrono::steady_clock::now() - start < kSettling) {
    std::this_thread::sleep_for(kRetry);
    connected = s.connect();
  }
  if (!connected) return connected;
  s.stopping = false;
  s.thread = std::thread([state = state_.get()] { state->run(); });
  return {};
}

void HidWorker::close() {
  State& s = *state_;
  if (!s.thread.joinable()) return;
  {
    const std::lock_guard lock(s.mutex);
    s.stopping = true;
  }
  s.wake.notify_all();
  s.thread.join();
  s.thread = std::thread();
}

double driverClock() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace tandem::haptics
