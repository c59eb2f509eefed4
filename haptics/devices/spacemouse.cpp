#include "haptics/devices/spacemouse.h"

#include <array>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <glm/geometric.hpp>
#include <mutex>
#include <thread>

namespace tandem::haptics {
namespace {

constexpr double kSilence = 0.1;  // s after which no report means no deflection
constexpr int kReadTimeout_ms = 50;
constexpr auto kRetry = std::chrono::milliseconds(200);
constexpr int kQuietReadsBeforeCheck = 10;
constexpr std::array<std::uint8_t, 2> kLightOn{4, 1}, kLightOff{4, 0};

}  // namespace

bool isSpaceMouse(const HidInfo& info) {
  const bool motion = (info.usagePage == 1 && info.usage == 8) || info.usagePage == 0;
  return motion && spaceMouseName(info.vendor, info.product) != nullptr;
}

HidInfo findSpaceMouse(HidBus& bus) {
  for (HidInfo& info : bus.enumerate())
    if (isSpaceMouse(info)) return std::move(info);
  return {};
}

struct SpaceMouseReader::State {
  explicit State(HidBus& b) : bus(b) {}

  void run();
  void readOnce();
  bool connect();
  void lose();
  void pause();

  HidBus& bus;
  std::unique_ptr<HidConnection> connection;  // the reader thread's once that runs
  std::string path;
  int quietReads = 0;
  SpaceMouseReading reading;
  TripleBuffer<SpaceMouseReading> published;

  std::thread thread;
  std::mutex mutex;
  std::condition_variable wake;
  bool stopping = false;  // under mutex
};

void SpaceMouseReader::State::run() {
  for (;;) {
    {
      const std::lock_guard lock(mutex);
      if (stopping) break;
    }
    if (connection || connect())
      readOnce();
    else
      pause();
  }
  if (connection) static_cast<void>(connection->write(kLightOff).ok());
  lose();
}

void SpaceMouseReader::State::readOnce() {
  std::array<std::uint8_t, 64> buffer{};
  const int length = connection->read(buffer, kReadTimeout_ms);
  if (length < 0) return lose();
  if (length == 0) {
    // Some buses report a removed device as silence: look whether its node is still there.
    if (++quietReads >= kQuietReadsBeforeCheck) {
      quietReads = 0;
      if (!bus.present(path)) lose();
    }
    return;
  }
  quietReads = 0;
  const auto report = std::span<const std::uint8_t>(buffer).first(static_cast<std::size_t>(length));
  if (decodeSpaceMouseReport(report, reading.state))
    ++reading.reports;
  else
    ++reading.rejected;
  published.write(reading);
}

bool SpaceMouseReader::State::connect() {
  const HidInfo info = findSpaceMouse(bus);
  if (info.path.empty()) return false;
  auto opened =
      bus.open(info.path);  // fails for a moment after plugging in, until udev has set the permissions
  if (!opened) return false;
  connection = std::move(opened).value();
  path = info.path;
  quietReads = 0;
  static_cast<void>(connection->write(kLightOn).ok());  // a device without a light is as good
  reading.connected = true;
  published.write(reading);
  return true;
}

void SpaceMouseReader::State::lose() {
  connection.reset();
  reading.connected = false;
  reading.state = {};
  published.write(reading);
}

void SpaceMouseReader::State::pause() {
  std::unique_lock lock(mutex);
  wake.wait_for(lock, kRetry, [this] { return stopping; });
}

SpaceMouseReader::SpaceMouseReader(HidBus& bus) : state_(std::make_unique<State>(bus)) {}

SpaceMouseReader::~SpaceMouseReader() { close(); }

Status SpaceMouseReader::open() {
  State& s = *state_;
  if (s.thread.joinable()) return {};
  const HidInfo info = findSpaceMouse(s.bus);
  if (info.path.empty()) return Error{"spacemouse: none is connected"};
  auto opened = s.bus.open(info.path);
  if (!opened) return Error{"spacemouse: " + opened.error().message};
  s.connection = std::move(opened).value();
  s.path = info.path;
  static_cast<void>(s.connection->write(kLightOn).ok());
  s.reading.connected = true;
  s.published.write(s.reading);
  s.stopping = false;
  s.thread = std::thread([state = state_.get()] { state->run(); });
  return {};
}

void SpaceMouseReader::close() {
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

const SpaceMouseReading& SpaceMouseReader::reading() { return state_->published.latest(); }

SpaceMouse::SpaceMouse(HidBus& bus, const Pose& worldFromStart) : SteeredHand(worldFromStart), reader_(bus) {}

SpaceMouse::~SpaceMouse() = default;

Status SpaceMouse::open() {
  if (Status opened = HandDevice::open(); !opened) return opened;
  return reader_.open();
}

void SpaceMouse::close() { reader_.close(); }

void SpaceMouse::beginPoll(double now) {
  const SpaceMouseReading& latest = reader_.reading();
  if (latest.reports != reading_.reports) lastNews_ = now;
  reading_ = latest;
  if (!reading_.connected || now - lastNews_ > kSilence) return steer({});
  curve_.maxSpeed = view().maxSpeed;
  steer(twistFromDeflection(reading_.state.axes, curve_, view().worldFromView));
}

DeviceSample SpaceMouse::poll(double now) {
  DeviceSample sample = HandDevice::poll(now);
  if (!reading_.connected) sample.valid = false;
  return sample;
}

}  // namespace tandem::haptics
