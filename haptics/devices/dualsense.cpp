#include "haptics/devices/dualsense.h"

#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "haptics/devices/hid_worker.h"
#include "haptics/devices/pacer.h"

namespace tandem::haptics {
namespace {

constexpr double kPadInterval = 4e-3, kPadSilence = 0.05;  // s
constexpr double kDeadZone = 0.08;                         // of a stick
constexpr std::uint32_t kGraspBit = 1u << 0, kClutchBit = 1u << 1;

struct WantedOfPad {
  DualSenseOutput output;
  double renewedAt = -1e9;  // s, driverClock
};

/// Response curve: zero near the middle, then fine, then fast.
double shaped(double deflection) {
  const double beyond = std::max(0.0, std::abs(deflection) - kDeadZone) / (1.0 - kDeadZone);
  return std::copysign(beyond * (0.2 + 0.8 * beyond * beyond), deflection);
}

}  // namespace

const char* dualSenseName(std::uint16_t vendor, std::uint16_t product) {
  if (vendor != 0x054c) return nullptr;
  return product == 0x0ce6 ? "DualSense" : product == 0x0df2 ? "DualSense Edge" : nullptr;
}

bool isDualSense(const HidInfo& info) {
  const bool gamepad = (info.usagePage == 1 && info.usage == 5) || info.usagePage == 0;
  return gamepad && dualSenseName(info.vendor, info.product) != nullptr;
}

struct DualSense::Driver : HidClient {
  explicit Driver(HidBus& bus) : worker(bus, *this) {}

  const char* what() const override { return "dualsense"; }
  bool serves(const HidInfo& info) const override { return isDualSense(info); }
  Status begin(HidConnection& connection, const HidInfo& info) override;
  void report(std::span<const std::uint8_t> bytes) override;
  Status service(HidConnection& connection) override;
  void end(HidConnection& connection) override;
  void lost() override;
  Status send(HidConnection& connection, const DualSenseOutput& output);

  DualSenseReading reading;  // owned by the driver's thread
  std::uint8_t sequence = 0;
  Pacer<DualSenseOutput> pacer{kPadInterval, kPadSilence};
  TripleBuffer<DualSenseReading> published;
  TripleBuffer<WantedOfPad> wanted;
  HidWorker worker;  // last member: its thread uses all of the above
};

Status DualSense::Driver::begin(HidConnection& connection, const HidInfo&) {
  // Over Bluetooth this also switches from the short report to the full one. A controller that does not
  // answer works with nominal calibration.
  std::array<std::uint8_t, 64> calibration{0x05};
  const auto length = connection.getFeature(calibration);
  reading.gyro =
      length ? decodeGyroCalibration(std::span(calibration).first(std::min(*length, calibration.size())))
             : GyroCalibration{};
  pacer.reset();
  reading.connected = true;
  published.write(reading);
  return {};
}

void DualSense::Driver::report(std::span<const std::uint8_t> bytes) {
  if (decodeDualSenseReport(bytes, reading.state))
    ++reading.reports;
  else
    ++reading.rejected;
  published.write(reading);
}

Status DualSense::Driver::send(HidConnection& connection, const DualSenseOutput& output) {
  ++reading.written;
  return connection.write(encodeDualSense(output, reading.state.bluetooth, sequence++));
}

Status DualSense::Driver::service(HidConnection& connection) {
  // The connection type is unknown until the first report.
  if (reading.reports == 0) return {};
  const WantedOfPad& now = wanted.latest();
  const auto due = pacer.next(driverClock(), now.output, now.renewedAt);
  return due ? send(connection, *due) : Status{};
}

void DualSense::Driver::end(HidConnection& connection) {
  if (reading.reports > 0) static_cast<void>(send(connection, {}).ok());
}

void DualSense::Driver::lost() {
  reading.connected = false;
  reading.state = {};
  published.write(reading);
}

DualSense::DualSense(HidBus& bus, const Pose& worldFromStart)
    : SteeredHand(worldFromStart), driver_(std::make_unique<Driver>(bus)) {}

DualSense::~DualSense() { close(); }

Status DualSense::open() {
  if (Status opened = HandDevice::open(); !opened) return opened;
  return driver_->worker.open();
}

void DualSense::close() { driver_->worker.close(); }

void DualSense::beginPoll(double now) {
  interval_ = now - lastPoll_;
  lastPoll_ = now;
  reading_ = driver_->published.latest();
  if (!reading_.connected) return steer({});
  const DualSenseState& s = reading_.state;
  const SteeringView& steering = view();
  Twist wanted;
  wanted.linear = steering.maxSpeed *
                  (steering.worldFromView * glm::dvec3(shaped(s.leftX), -shaped(s.rightY), shaped(s.leftY)));
  if ((s.buttons & kPadR1) != 0 && s.hasMotion)
    wanted.angular = steering.worldFromView * reading_.gyro.rate(s.gyro);
  steer(wanted);
}

std::uint32_t DualSense::pressedButtons() const {
  if (!reading_.connected) return 0;
  const DualSenseState& s = reading_.state;
  const bool grasps = (s.buttons & kPadCross) != 0 || s.rightTrigger > 0.5;
  return (grasps ? kGraspBit : 0) | ((s.buttons & kPadCircle) != 0 ? kClutchBit : 0);
}

DeviceSample DualSense::poll(double now) {
  DeviceSample sample = HandDevice::poll(now);
  if (!reading_.connected) sample.valid = false;
  return sample;
}

void DualSense::apply(const Wrench& toHand) {
  HandDevice::apply(toHand);
  const double full = HandDevice::limits().maxForce;
  const DualSenseOutput output = cues_.step(glm::length(toHand.force), full, interval_);
  driver_->wanted.write({output, driverClock()});
}

}  // namespace tandem::haptics
