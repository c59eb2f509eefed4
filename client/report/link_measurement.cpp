#include "client/report/link_measurement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "assets/base/assert.h"
#include "client/base/thread_clock.h"
#include "client/report/link_recording.h"
#include "sync/transport/seal.h"
#include "sync/wire/link_stream.h"
#include "sync/wire/wire.h"

namespace tandem::client::report {
namespace {

using bench::BenchSite;
using bench::HandBench;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kDivergence = 1.0;    // J, made at the devices
constexpr double kDragEnd = 8.0;       // s
constexpr double kMeasuredFrom = 3.0;  // s, in which bytes are counted until kDragEnd
// Bytes of a message with a pose and a twist on the link's wire, without sums and energy, and of the
// additions of other architectures.
constexpr double kPoseMessage = 45.0, kEnergy = 4.0, kWrench = 12.0;

bench::LinkEndMaker endsOf(const LinkSetting& setting) {
  using Made = std::unique_ptr<bench::LinkEnd>;
  const SpringGains gains = setting.gains;
  switch (setting.architecture) {
    case Architecture::plain:
      return [gains](const haptics::LinkParameters& p, double) -> Made {
        return std::make_unique<bench::PlainSpringEnd>(
            bench::PlainSpringEnd::Gains{gains.stiffness, gains.damping}, p);
      };
    case Architecture::tank:
      return [gains](const haptics::LinkParameters& p, double) -> Made {
        return std::make_unique<TankEnd>(gains, p);
      };
    default:
      return [](const haptics::LinkParameters& p, double delay) -> Made {
        return std::make_unique<bench::CoordinationLinkEnd>(p, delay);
      };
  }
}

haptics::LinkParameters parametersOf(const LinkSetting& setting) {
  haptics::LinkParameters p = bench::believing();
  p.packetPeriod = 1.0 / setting.packetHz;
  p.playOutMargin = setting.margin;
  if (!setting.inUse) p.impedance = p.softImpedance = setting.impedance;
  return p;
}

struct Case {
  double delay = 0.0;  // s
  unsigned seed = 1;
  std::vector<BenchSite> sites;
  bench::Block block;
};

/// `recording` may be null. It stays empty where the architecture has no replicas to link.
std::unique_ptr<HandBench> benchOf(const LinkSetting& setting, const Case& c,
                                   std::shared_ptr<LinkRecording> recording = nullptr) {
  const bench::Network network = networkOf(c.delay, setting);
  if (setting.architecture == Architecture::oneRoom) return std::make_unique<OneRoomBench>(c.sites, c.block);
  if (setting.architecture == Architecture::server)
    return std::make_unique<ServerBench>(
        ServerBench::Setup{c.sites, network, c.block, c.seed, setting.gains});
  bench::BenchSetup setup;
  setup.sites = c.sites;
  setup.network = network;
  setup.seed = c.seed;
  setup.block = c.block;
  setup.link = parametersOf(setting);
  setup.makeEnd = endsOf(setting);
  if (recording) setup.makeEnd = recordingFirst(setup.makeEnd, std::move(recording));
  return std::make_unique<bench::LinkBench>(setup);
}

Case dragCase(double delay, int seed) {
  return {delay, static_cast<unsigned>(seed), bench::twoHands(bench::firmArm(), bench::lightArm()), {}};
}

/// The bytes of a link's packet, sealed.
double bytesOf(const haptics::LinkPacket& packet) {
  sync::LinkState state;
  state.epoch = packet.epoch;
  state.sequence = packet.sequence + 1;
  state.on = packet.on;
  state.worldFromDrawn = packet.worldFromDrawn;
  std::vector<std::byte> bytes;
  sync::encodeState(sync::toWire(state, 1, 0), sync::WireFrame{}, bytes);
  return static_cast<double>(bytes.size() + sync::kSealOverheadBytes);
}

/// Bytes a second each way in the drag.
double bytesASecond(const LinkSetting& setting, const LinkRecording& recording) {
  const double sealed = setting.packetHz * (kPoseMessage + static_cast<double>(sync::kSealOverheadBytes));
  switch (setting.architecture) {
    case Architecture::oneRoom:
      return 0.0;
    case Architecture::plain:
      return sealed;
    case Architecture::tank:
      return sealed + setting.packetHz * kEnergy;
    case Architecture::server:  // the mean of poses up, and poses and forces down
      return sealed + setting.packetHz * 0.5 * kWrench;
    case Architecture::link:
      break;
  }
  double sum = 0.0;
  for (const haptics::LinkPacket& packet : recording.sent)
    if (packet.time >= kMeasuredFrom) sum += bytesOf(packet);
  return sum / (kDragEnd - kMeasuredFrom);
}

void note(const bench::Tally& tally, LinkMeasurement& out) {
  out.diverged = out.diverged || tally.astray || tally.created > kDivergence;
  out.created = std::max(out.created, tally.created);
}

void runDrag(const LinkSetting& setting, double delay, int seed, LinkMeasurement& out) {
  const auto recording = std::make_shared<LinkRecording>();
  const auto people = benchOf(setting, dragCase(delay, seed), recording);
  const bench::DragFigures d = bench::drag(*people, {.until = kDragEnd});
  note(d, out);
  out.apart = std::max(out.apart, d.rms);
  out.maxApart = std::max(out.maxApart, d.most);
  out.offGrip = std::max(out.offGrip, d.offGrip);
  out.load = std::max(out.load, d.load);
  out.change = std::max(out.change, d.change);
  out.bytes = bytesASecond(setting, *recording);
  if (const auto* link = dynamic_cast<const bench::LinkBench*>(people.get())) {
    out.playOut = std::max(out.playOut, link->end(0, 0).delay());
    out.off = std::max(out.off, recording->offShare());
  }
}

void runPulls(const LinkSetting& setting, double delay, int seed, LinkMeasurement& out) {
  const Case c{delay, static_cast<unsigned>(seed), bench::twoHands(bench::firmArm(), bench::firmArm()), {}};
  const bench::PullFigures held = bench::pull(*benchOf(setting, c), bench::LetGo::nobody, bench::kLetGo);
  note(held, out);
  out.handToHand = std::min(out.handToHand, held.stiffness);
  if (!setting.letsGo) return;
  for (const bench::LetGo who : {bench::LetGo::second, bench::LetGo::both}) {
    const bench::PullFigures loose = bench::pull(*benchOf(setting, c), who);
    note(loose, out);
    out.rest = std::max(out.rest, loose.astray ? 0.0 : loose.rest);
  }
}

void runPress(const LinkSetting& setting, double delay, int seed, LinkMeasurement& out) {
  const Case c{delay, static_cast<unsigned>(seed), bench::twoHands(bench::lightArm(), bench::relaxedArm()),
               bench::beforeWall({})};
  const bench::PressFigures p = bench::press(*benchOf(setting, c), c.sites[1].arm);
  note(p, out);
  out.wall = std::min(out.wall, p.stiffness);
}

/// The processor time of `work`, divided by `count`, us.
template <typename Work>
double timeOf(double count, const Work& work) {
  const double from = threadMicroseconds();
  work();
  return (threadMicroseconds() - from) / count;
}

/// The time of the implicit step of a body that `grips` hands hold and nothing else touches, us.
double heldStep(std::size_t grips) {
  constexpr int kSteps = 4000;
  haptics::RigidBody body = bench::bodyOf({});
  const Pose grip{bench::kCentreOfMass, {1.0, 0.0, 0.0, 0.0}};
  return timeOf(kSteps, [&] {
    std::array<haptics::Coupling, haptics::kMaxCouplings> couplings;
    for (int i = 0; i < kSteps; ++i) {
      const Pose device{{1e-3 * (i % 7), 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}};
      couplings.fill({grip, device, {}, bench::kGrasp});
      const haptics::CoupledStep step =
          haptics::coupleBody(body, {couplings.data(), grips}, {}, {}, bench::kTick);
      haptics::moveBody(body, step.freeVelocity, step.freeSpin, bench::kTick);
    }
  });
}

/// The least result of several runs of `work` over the least time of the yardstick; the two run in turn.
template <typename Work>
double inYardsticks(const Work& work) {
  double least = std::numeric_limits<double>::infinity(), yardstick = least;
  for (int i = 0; i < 7; ++i) {
    yardstick = std::min(yardstick, heldStep(1));
    least = std::min(least, work());
  }
  return least / yardstick;
}

}  // namespace

bench::Network networkOf(double delay, const LinkSetting& setting) {
  bench::Network network;
  network.delay = delay;
  network.jitter = 0.2;
  network.loss = 0.02;
  network.packetPeriod = 1.0 / setting.packetHz;
  return network;
}

LinkMeasurement measureLink(const LinkSetting& setting, double delay, int seeds, double aloneLoad) {
  ASSERT(seeds >= 1 && delay >= 0.0 && setting.packetHz > 0.0);
  LinkMeasurement out;
  out.setting = setting;
  out.handToHand = out.wall = std::numeric_limits<double>::infinity();
  out.rest = setting.letsGo ? 0.0 : kNone;
  out.cost = kNone;
  for (int seed = 1; seed <= seeds; ++seed) {
    runDrag(setting, delay, seed, out);
    runPulls(setting, delay, seed, out);
    runPress(setting, delay, seed, out);
  }
  if (aloneLoad > 0.0) out.load /= aloneLoad;
  if (!std::isfinite(out.wall)) out.wall = kNone;
  return out;
}

double loadWithoutNetwork() {
  LinkSetting alone;
  alone.architecture = Architecture::oneRoom;
  return bench::drag(*benchOf(alone, dragCase(0.0, 1)), {.until = kDragEnd}).load;
}

double tickCost(const LinkSetting& setting, double delay) {
  if (setting.architecture == Architecture::oneRoom) return kNone;
  if (setting.architecture == Architecture::server) return inYardsticks([] { return heldStep(2); });
  const auto recording = std::make_shared<LinkRecording>();
  bench::drag(*benchOf(setting, dragCase(delay, 1), recording), {.until = kDragEnd});
  return inYardsticks([&] {
    return timeOf(static_cast<double>(recording->ticks.size()),
                  [&] { replay(*recording, *endsOf(setting)(parametersOf(setting), delay)); });
  });
}

}  // namespace tandem::client::report
