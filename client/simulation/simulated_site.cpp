#include "client/simulation/simulated_site.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "haptics/safety/device_defaults.h"

namespace tandem::client {

using namespace sync;

namespace {

constexpr Micros kTick = kSimulationTick;

DoubtLimits eagerDoubts() {
  DoubtLimits limits;
  constexpr double kShare = 0.005;
  for (MotionSum* sum : {&limits.motion.way, &limits.motion.turn, &limits.motion.change, &limits.motion.spin})
    sum->most *= kShare, sum->shrinks *= kShare;
  limits.motion.unseen *= kShare, limits.motion.unseenTurn *= kShare;
  limits.enough = 1;
  return limits;
}

}  // namespace

SimulatedSite::SimulatedSite(SimulationContext& context, std::size_t index, const ScenarioSite& description,
                             HandScript script, const Pose& worldFromStart, Micros clockOffset)
    : SimulatedClient(context.invariants, context.scene, index, description, clockOffset),
      context_(context),
      joinsAt_(static_cast<Micros>(description.joins * 1e6)),
      exchange_(std::make_unique<Exchange>()),
      hand_(std::make_unique<HandLoop>(context.contact, *exchange_)),
      device_(context.scene, std::move(script), description.arm, description.device, worldFromStart,
              [this](PartId part) { return hand_->worldFromPart(part); }),
      lastTarget_(worldFromStart.position) {
  for (const assets::Part& part : context.scene.parts) lastPoses_.push_back(part.worldFromPart);
  worldFromDrawn_ = lastPoses_;
  exchange_->settings.write(settings());
}

/// The parameters of this site's ticks: the plain defaults, so that scenarios compare whatever the device, or
/// on request those of a real session on such a device.
HandSettingsInput SimulatedSite::settings() const {
  HandSettingsInput settings;
  haptics::TickParameters& parameters = settings.parameters[0];
  if (description_.fit) haptics::fitToDevice(device_.limits(), 0.0, parameters);
  constexpr double kUnlimited = 1e9;  // N, N·m
  parameters.forceLimit =
      context_.mistake == Mistake::limitsUnknown ? kUnlimited : description_.device.forceMax;
  if (context_.mistake == Mistake::limitsUnknown || context_.mistake == Mistake::torqueUnknown)
    parameters.torqueLimit = kUnlimited;
  settings.believesPeers =
      context_.mistake == Mistake::limitsUnknown || context_.mistake == Mistake::linksLieBelieved;
  parameters.gravity = context_.scene.gravity;
  if (description_.stiffness > 0.0) {
    parameters.stiffness = parameters.graspStiffness = description_.stiffness;
    parameters.stiffnessLimit = 0.0;
  }
  return settings;
}

void SimulatedSite::start() {
  ASSERT(!started());
  ConnectionOptions options;
  options.name = description_.name;
  options.rates.max = context_.scenario.packetHz;
  options.rates.deadband = description_.deadband;
  if (context_.mistake == Mistake::doubtsAtOnce) options.doubts = eagerDoubts();
  options.token = context_.server.makeToken(description_.role);
  connection_ = std::make_unique<ServerConnection>(options, [this]() -> Result<std::unique_ptr<Transport>> {
    countTransport();
    return context_.network.connect(name());
  });
  connection_->setObserver(this);
}

void SimulatedSite::startWhenDue(Micros now) {
  if (started() || joinsAt_ < 0 || now < joinsAt_) return;
  joinsAt_ = -1;
  start();
}

void SimulatedSite::countTransport() {
  if (!connection_ || !connection_->transport()) return;
  const TransportCounters counters = connection_->transport()->counters();
  packetsBefore_ += counters.statePacketsOut;
  bytesBefore_ += counters.stateBytesOut + counters.controlBytesOut;
}

void SimulatedSite::crash() {
  countTransport();
  if (connection_) {
    droppedBefore_ += connection_->statistics().droppedStates;
    sentBefore_.add(connection_->statistics().sent);
    context_.invariants.onDead(index_, id_);
  }
  connection_.reset();
  id_ = kNoSite;
  exchange_ = std::make_unique<Exchange>();
  exchange_->settings.write(settings());
  hand_ = std::make_unique<HandLoop>(context_.contact, *exchange_);
}

void SimulatedSite::step(Micros now) {
  tickHand(now);
  if (paused(now) || !connection_) return;
  const bool lies = context_.mistake == Mistake::linksLie || context_.mistake == Mistake::linksLieBelieved;
  if (lies && index_ == 1) lieInLinks();
  connection_->step(local(now));
  if (connection_->stage() == ServerConnection::Stage::needScene) connection_->skipTransfer();
  if (connection_->stage() == ServerConnection::Stage::haveScene)
    connection_->sceneReady(context_.scene, *exchange_);
  id_ = connection_->welcome().site;
  if (connection_->stage() == ServerConnection::Stage::ended) context_.invariants.onConnection(index_, false);
}

void SimulatedSite::tickHand(Micros now) {
  const haptics::DeviceSample reading = device_.poll(toSeconds(now));
  Wrench toHand;
  // The device's watchdog gives zero force while no client runs: before it is started, while it stands still
  // and when it is dead.
  const bool running = !paused(now) && connection_;
  if (running) {
    hand_->setWish(device_.wish());
    hand_->setControl(device_.control());
    toHand = hand_->tick(reading, local(now));
  }
  if (context_.mistake == Mistake::negativeDamping && running) pushAlong(toHand);
  if (context_.mistake == Mistake::limitsUnknown)
    toHand.force = haptics::limited(toHand.force, description_.device.forceMax);
  device_.apply(toHand);
  // The device turns as the person wills, whatever the torque, which is paid for all the same.
  turned_ += glm::dot(toHand.torque, reading.twist.angular) * toSeconds(kTick);
  const HandSample sample = measure(toHand);
  if (running) addSources(tick());
  ShownPose shown;
  while (exchange_->shown.pop(shown)) worldFromDrawn_[shown.part] = shown.worldFromDrawn;
  measures_.add(sample);
  context_.fingerprint.add(sample.force);
  context_.fingerprint.add(sample.position);
  if (context_.trace.is_open() && now % (10 * kMillisecond) == 0) writeTrace(sample, now);
}

void SimulatedSite::pushAlong(Wrench& toHand) const {
  constexpr double kNegativeDamping = 0.5;  // N·s/m
  toHand.force = haptics::limited(toHand.force + kNegativeDamping * device_.hand().deviceVelocity(),
                                  description_.device.forceMax);
}

void SimulatedSite::lieInLinks() {
  constexpr double kWave = 4.0;        // sqrt(W): about 30 N at the impedance of a stiff link
  constexpr double kForPacket = 4e-3;  // s
  std::vector<haptics::AddressedPacket> packets;
  for (haptics::AddressedPacket packet; exchange_->linksOut.pop(packet);) packets.push_back(packet);
  const LinkLie& lie = context_.lie;
  for (haptics::AddressedPacket& packet : packets) {
    if (packet.packet.time >= lie.from) {
      const bool turned = std::fmod(2.0 * lie.hertz * packet.packet.time, 2.0) >= 1.0;
      liedWave_ += kForPacket * (turned ? -kWave : kWave) * lie.along;
      liedEnergy_ += kForPacket * kWave * kWave;
    }
    packet.packet.wave.along += liedWave_;
    packet.packet.energy += liedEnergy_;
    static_cast<void>(exchange_->linksOut.push(packet));
  }
}

HandSample SimulatedSite::measure(const Wrench& toHand) {
  HandSample sample;
  sample.force = toHand.force;
  sample.position = device_.hand().devicePose().position;
  sample.energyGiven = device_.hand().energyGiven() + turned_ - sourceEnergy_;
  for (int i = 0; i < tick().contactCount; ++i)
    noteContact(tick().contacts[static_cast<std::size_t>(i)].part, sample);
  const glm::dvec3 target = device_.target().worldFromTarget.position;
  sample.still = target == lastTarget_;
  lastTarget_ = target;
  return sample;
}

void SimulatedSite::noteContact(PartId part, HandSample& sample) const {
  ASSERT(part < lastPoses_.size());
  if (!context_.scene.parts[part].movable) {
    sample.pressing = true;
  } else {
    sample.brushes = true;
    sample.pushed = sample.pushed || hand_->worldFromPart(part).position != lastPoses_[part].position;
  }
}

void SimulatedSite::writeTrace(const HandSample& sample, Micros now) {
  const haptics::OwnedPart* held = tick().simulated(tick().hands[0].held);
  const haptics::LinkReport links = held != nullptr ? held->links : haptics::LinkReport{};
  const glm::dvec3& p = tick().worldFromProxy.position;
  char line[400];
  std::snprintf(
      line, sizeof line,
      "%.3f,%s,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.5f,%.5f,%.5f,%s,%u,%d,%.3f,%.1f,%.5f,%.5f,%.5f\n",
      toSeconds(now), name().c_str(), sample.position.x, sample.position.y, sample.position.z, p.x, p.y, p.z,
      sample.force.x, sample.force.y, sample.force.z,
      tick().hands[0].held == kNoPart ? "" : context_.scene.parts[tick().hands[0].held].name.c_str(),
      tick().flags, links.count, links.fade, links.delay * 1e3, links.pull.force.x, links.pull.force.y,
      links.pull.force.z);
  context_.trace << line;
}

/// Adds the energy that the scene itself gave to this hand in this tick, which the haptic loop did not
/// create: the work of force fields, of the weight of a held part and of parts that others push against the
/// tool.
void SimulatedSite::addSources(const haptics::TickOutput& tick) {
  sourceEnergy_ += tick.sourcePower * toSeconds(kTick);
  addLinkWork(tick);
  addWeight(tick);
  addPushedContacts(tick);
  for (std::size_t i = 0; i < lastPoses_.size(); ++i)
    if (context_.scene.parts[i].movable) lastPoses_[i] = hand_->worldFromPart(static_cast<PartId>(i));
}

/// The weight of the part in this hand; of a shared part, this replica's share of it.
void SimulatedSite::addWeight(const haptics::TickOutput& tick) {
  const haptics::OwnedPart* held = tick.simulated(tick.hands[0].held);
  if (held == nullptr) return;
  const assets::Part& part = context_.scene.parts[held->part];
  const glm::dvec3 centre = transformPoint(held->worldFromPart, part.massProperties.centreOfMass);
  const glm::dvec3 velocity = velocityAt(held->worldFromPart, held->twist, centre);
  sourceEnergy_ += held->links.share * part.massProperties.mass * part.gravityFactor *
                   glm::dot(context_.scene.gravity, velocity) * toSeconds(kTick);
}

/// What all links together do on all replicas: a measure of the links alone.
void SimulatedSite::addLinkWork(const haptics::TickOutput& tick) {
  for (int i = 0; i < tick.ownedCount; ++i) {
    const haptics::OwnedPart& part = tick.owned[static_cast<std::size_t>(i)];
    if (part.links.count == 0) continue;
    const glm::dvec3 centre =
        transformPoint(part.worldFromPart, context_.scene.parts[part.part].massProperties.centreOfMass);
    const glm::dvec3 velocity = velocityAt(part.worldFromPart, part.twist, centre);
    const Wrench& pull = part.links.pull;
    context_.linkWork +=
        toSeconds(kTick) * (glm::dot(pull.force, velocity) + glm::dot(pull.torque, part.twist.angular));
  }
}

/// Parts push the bare tool only: what pushes a held part is pushed back by it, here or at a linked site. The
/// hand gets no more of it than its device gives.
void SimulatedSite::addPushedContacts(const haptics::TickOutput& tick) {
  if (tick.hands[0].held != kNoPart) return;
  glm::dvec3 wanted(0.0);
  for (int i = 0; i < tick.contactCount; ++i) {
    const haptics::Contact& contact = tick.contacts[static_cast<std::size_t>(i)];
    wanted += contact.force * contact.normal;
  }
  const double given = glm::length(tick.hands[0].toHand.force);
  const double share = std::min(1.0, given / std::max(glm::length(wanted), 1e-300));
  for (int i = 0; i < tick.contactCount; ++i) {
    const haptics::Contact& contact = tick.contacts[static_cast<std::size_t>(i)];
    const Pose now = hand_->worldFromPart(contact.part);
    const glm::dvec3 before =
        transformPoint(lastPoses_[contact.part], transformPoint(inverse(now), contact.point));
    sourceEnergy_ += share * contact.force * std::max(0.0, glm::dot(contact.normal, contact.point - before));
  }
}

std::uint64_t SimulatedSite::droppedStates() const {
  return droppedBefore_ + (connection_ ? connection_->statistics().droppedStates : 0);
}

SimulatedSiteResult SimulatedSite::result(double duration, const std::vector<bool>& undisturbed) const {
  SimulatedSiteResult out;
  out.feltStiffness = measures_.feltStiffness();
  out.forceStep20ms = measures_.forceStep();
  out.handoverExcess = measures_.handoverExcess();
  out.rmsForce = measures_.rmsForce();
  out.maxForce = measures_.maxForce();
  const TransportCounters counters =
      connection_ && connection_->transport() ? connection_->transport()->counters() : TransportCounters{};
  out.packetsPerSecond = static_cast<double>(packetsBefore_ + counters.statePacketsOut) / duration;
  out.bytesPerSecond =
      static_cast<double>(bytesBefore_ + counters.stateBytesOut + counters.controlBytesOut) / duration;
  out.sent = sentBefore_;
  if (connection_) out.sent.add(connection_->statistics().sent);
  if (connection_) out.reconnects = connection_->statistics().reconnects;
  out.calm = measures_.calm(undisturbed);
  out.pushed = measures_.pushed();
  return out;
}

void SimulatedSite::onOwnership(const PartRecord& record) {
  SimulatedClient::onOwnership(record);
  ASSERT(record.part < context_.everOwned.size());
  context_.everOwned[record.part] = true;
  if (record.owner == connection_->welcome().site || tick().hands[0].held == record.part)
    measures_.roleChanged();
}
void SimulatedSite::onGrabReply(const GrabReply& reply) {
  if (reply.denial != Denial::none) ++denials_;
  SimulatedClient::onGrabReply(reply);
}

}  // namespace tandem::client
