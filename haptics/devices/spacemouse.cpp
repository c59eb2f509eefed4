#include "haptics/devices/spacemouse.h"

#include <array>

#include "haptics/devices/hid_worker.h"

namespace tandem::haptics {
namespace {

constexpr double kSilence = 0.1;  // s after which no report means no deflection
constexpr int kReadTimeout_ms = 50;
constexpr std::array<std::uint8_t, 2> kLightOn{4, 1}, kLightOff{4, 0};

}  // namespace

bool isSpaceMouse(const HidInfo& info) {
  const bool motion = (info.usagePage == 1 && info.usage == 8) || info.usagePage == 0;
  return motion && spaceMouseName(info.vendor, info.product) != nullptr;
}

struct SpaceMouseReader::Driver : HidClient {
  explicit Driver(HidBus& bus) : worker(bus, *this) {}

  const char* what() const override { return "spacemouse"; }
  bool serves(const HidInfo& info) const override { return isSpaceMouse(info); }
  Status begin(HidConnection& connection, const HidInfo& info) override;
  void report(std::span<const std::uint8_t> bytes) override;
  Status service(HidConnection&) override { return {}; }
  void end(HidConnection& connection) override { static_cast<void>(connection.write(kLightOff).ok()); }
  void lost() override;
  int readTimeout_ms() const override { return kReadTimeout_ms; }

  SpaceMouseReading reading;  // the driver's thread's
  TripleBuffer<SpaceMouseReading> published;
  HidWorker worker;  // last: its thread uses all of the above
};

Status SpaceMouseReader::Driver::begin(HidConnection& connection, const HidInfo&) {
  static_cast<void>(connection.write(kLightOn).ok());  // a device without a light is as good
  reading.connected = true;
  published.write(reading);
  return {};
}

void SpaceMouseReader::Driver::report(std::span<const std::uint8_t> bytes) {
  if (decodeSpaceMouseReport(bytes, reading.state))
    ++reading.reports;
  else
    ++reading.rejected;
  published.write(reading);
}

void SpaceMouseReader::Driver::lost() {
  reading.connected = false;
  reading.state = {};
  published.write(reading);
}

SpaceMouseReader::SpaceMouseReader(HidBus& bus) : driver_(std::make_unique<Driver>(bus)) {}

SpaceMouseReader::~SpaceMouseReader() { close(); }

Status SpaceMouseReader::open() { return driver_->worker.open(); }

void SpaceMouseReader::close() { driver_->worker.close(); }

const SpaceMouseReading& SpaceMouseReader::reading() { return driver_->published.latest(); }

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
