#include "haptics/devices/pid_device.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "haptics/base/fixed_vector.h"
#include "haptics/base/triple_buffer.h"
#include "haptics/devices/hid_worker.h"
#include "haptics/devices/pacer.h"
#include "haptics/devices/pid_codec.h"

namespace tandem::haptics {
namespace {

constexpr double kPidInterval = 1e-3, kPidSilence = 0.05;  // s
constexpr double kReportFilterTime = 8e-3;                 // s: reports come every 1 to 10 ms
constexpr int kLoadTries = 60;                             // as Linux' hid-pidff

using Shares = std::array<std::int16_t, 2>;  // of full force, in 1/32767: equal ones are not sent twice

struct WantedOfPid {
  Shares shares{};
  double renewedAt = -1e9;  // s, driverClock
};

Status send(HidConnection& connection, const PidBytes& report) {
  return report.empty() ? Status{} : connection.write(report);
}

/// Requests an effect and waits until the device reports it as loaded.
Result<std::uint8_t> createEffect(const PidLayout& layout, HidConnection& connection, PidEffect type) {
  const PidBytes request = encodeCreate(layout, type);
  if (request.empty()) return Error{"the device does not offer this effect"};
  if (Status sent = connection.sendFeature(request); !sent) return sent.error();
  for (int i = 0; i < kLoadTries; ++i) {
    PidBytes answer(std::max<std::size_t>(layout.load.bytes, 1), 0);
    answer[0] = layout.load.id;
    Result<std::size_t> length = connection.getFeature(answer);
    if (!length) return length.error();
    const PidBlock block = decodeBlockLoad(layout, std::span(answer).first(std::min(*length, answer.size())));
    if (block.status == PidBlock::kLoaded) return block.index;
    if (block.status == PidBlock::kFull) return Error{"the device's memory for effects is full"};
    if (block.status == PidBlock::kError) return Error{"the device refused the effect"};
  }
  return Error{"the device did not answer the request for an effect"};
}

}  // namespace

bool mayBePid(const HidInfo& info) {
  if (info.vendor == 0x054c || info.vendor == 0x256f)
    return false;  // Sony and 3Dconnexion have drivers of their own
  return info.usagePage == 0x0F || (info.usagePage == 1 && (info.usage == 4 || info.usage == 5));
}

Status checkPid(HidBus& bus, const HidInfo& info) {
  auto descriptor = bus.descriptor(info.path);
  if (!descriptor) return descriptor.error();
  Result<PidLayout> layout = findPid(*descriptor);
  return layout ? Status{} : Status(layout.error());
}

struct PidDevice::Driver : HidClient {
  Driver(HidBus& bus, const PidSettings& s) : settings(s), worker(bus, *this) {}

  const char* what() const override { return "pid"; }
  bool serves(const HidInfo& info) const override { return mayBePid(info); }
  Status begin(HidConnection& connection, const HidInfo& info) override;
  Status startEffects(HidConnection& connection);
  void report(std::span<const std::uint8_t> bytes) override;
  Status service(HidConnection& connection) override;
  void end(HidConnection& connection) override;
  void lost() override;

  PidSettings settings;
  PidLayout layout;
  FixedVector<std::uint8_t, 2> blocks;  // the effect of each motor
  PidState state;
  PidReading reading;  // the driver's thread's
  Pacer<Shares> pacer{kPidInterval, kPidSilence};
  TripleBuffer<PidReading> published;
  TripleBuffer<WantedOfPid> wanted;
  PidReading latest;  // the servo thread's
  HidWorker worker;   // last: its thread uses all of the above
};

Status PidDevice::Driver::begin(HidConnection& connection, const HidInfo&) {
  auto descriptor = connection.descriptor();
  if (!descriptor) return descriptor.error();
  Result<PidLayout> found = findPid(*descriptor);
  if (!found) return found.error();
  layout = std::move(*found);
  if (Status started = startEffects(connection); !started) return started;
  pacer.reset();
  reading.connected = true;
  published.write(reading);
  return {};
}

Status PidDevice::Driver::startEffects(HidConnection& connection) {
  for (const PidControl what : {PidControl::kReset, PidControl::kEnable})
    if (Status sent = send(connection, encodeControl(layout, what)); !sent) return sent;
  const PidBytes gain = encodeGain(layout, 1.0);
  if (Status sent = layout.gain.kind == HidKind::kFeature && !gain.empty() ? connection.sendFeature(gain)
                                                                           : send(connection, gain);
      !sent)
    return sent;
  blocks.clear();
  for (int axis = 0; axis < layout.forceAxes(); ++axis) {
    Result<std::uint8_t> block = createEffect(layout, connection, PidEffect::kConstant);
    if (!block) return block.error();
    for (const PidBytes& step :
         {encodeSetEffect(layout, *block, PidEffect::kConstant, axis), encodeConstant(layout, *block, 0.0),
          encodeOperation(layout, *block, PidOperation::kStart)})
      if (Status sent = send(connection, step); !sent) return sent;
    blocks.push_back(*block);
    if (settings.damper <= 0.0) continue;
    // The damper is optional: the device works without it.
    Result<std::uint8_t> damper = createEffect(layout, connection, PidEffect::kDamper);
    if (!damper) continue;
    for (const PidBytes& step : {encodeSetEffect(layout, *damper, PidEffect::kDamper, axis),
                                 encodeCondition(layout, *damper, axis, {.coefficient = settings.damper}),
                                 encodeOperation(layout, *damper, PidOperation::kStart)})
      if (Status sent = send(connection, step); !sent) return sent;
  }
  return {};
}

void PidDevice::Driver::report(std::span<const std::uint8_t> bytes) {
  if (decodePidInput(layout, bytes, state)) {
    ++reading.reports;
    reading.axes[0] = state.axes[0];
    reading.axes[1] = state.axes[1];
    reading.buttons = state.buttons;
  } else {
    ++reading.rejected;
  }
  published.write(reading);
}

Status PidDevice::Driver::service(HidConnection& connection) {
  const WantedOfPid& now = wanted.latest();
  const double start = driverClock();
  const std::optional<Shares> due = pacer.next(start, now.shares, now.renewedAt);
  if (!due) return {};
  for (std::size_t axis = 0; axis < blocks.size(); ++axis) {
    const double share = static_cast<double>((*due)[axis]) / 32767.0;
    if (Status sent = send(connection, encodeConstant(layout, blocks[axis], share)); !sent) return sent;
  }
  ++reading.written;
  reading.writeTime = driverClock() - start;
  published.write(reading);
  return {};
}

void PidDevice::Driver::end(HidConnection& connection) {
  for (const std::uint8_t block : blocks) {
    static_cast<void>(send(connection, encodeConstant(layout, block, 0.0)).ok());
    static_cast<void>(send(connection, encodeOperation(layout, block, PidOperation::kStop)).ok());
    static_cast<void>(send(connection, encodeFree(layout, block)).ok());
  }
  static_cast<void>(send(connection, encodeControl(layout, PidControl::kDisable)).ok());
}

void PidDevice::Driver::lost() {
  reading.connected = false;
  published.write(reading);
}

PidDevice::PidDevice(HidBus& bus, const Pose& worldFromStart, const PidSettings& settings)
    : worldFromStart_(worldFromStart),
      settings_(settings),
      driver_(std::make_unique<Driver>(bus, settings)) {}

PidDevice::~PidDevice() { close(); }

DeviceLimits PidDevice::limits() const {
  DeviceLimits limits;
  limits.sensedAxes = limits.actuatedAxes = 3;
  limits.maxForce = settings_.maxForce;
  limits.quantum = 2.0 * settings_.reach / 65536.0;
  limits.workspaceRadius = settings_.reach;
  limits.rate = 500.0;
  return limits;
}

Status PidDevice::open() {
  started_ = false;
  return driver_->worker.open();
}

void PidDevice::close() { driver_->worker.close(); }

DeviceSample PidDevice::poll(double now) {
  driver_->latest = driver_->published.latest();
  const PidReading& reading = driver_->latest;
  const double interval = now - lastPoll_;
  for (int axis = 0; axis < 2; ++axis) {
    const double before = position_[axis];
    position_[axis] = settings_.reach * reading.axes[axis];
    if (!started_ || !(interval > 0.0)) continue;
    const double fresh = 1.0 - std::exp(-interval / kReportFilterTime);
    speed_[axis] += fresh * ((position_[axis] - before) / interval - speed_[axis]);
  }
  started_ = true;
  lastPoll_ = now;
  DeviceSample sample;
  sample.worldFromDevice = worldFromStart_;
  sample.worldFromDevice.position += glm::dvec3(position_[0], 0.0, position_[1]);
  sample.twist.linear = {speed_[0], 0.0, speed_[1]};
  sample.buttons = reading.buttons;
  sample.time = now;
  sample.valid = reading.connected;
  return sample;
}

void PidDevice::apply(const Wrench& toHand) {
  const auto share = [this](double force, bool invert) {
    const double part = std::clamp(force / settings_.maxForce, -1.0, 1.0);
    return std::isfinite(part) ? static_cast<std::int16_t>(std::lround((invert ? -part : part) * 32767.0))
                               : std::int16_t{0};
  };
  driver_->wanted.write(
      {{share(toHand.force.x, settings_.invertX), share(toHand.force.z, settings_.invertY)}, driverClock()});
}

const PidReading& PidDevice::reading() const { return driver_->latest; }

}  // namespace tandem::haptics
