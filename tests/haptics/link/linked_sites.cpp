#include "tests/haptics/link/linked_sites.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/allocation_counter.h"
#include "haptics/tick_data.h"
#include "tests/support/part_cases.h"
#include "tests/support/part_meshes.h"

namespace tandem::test {
namespace {

using haptics::PartCommand;
using haptics::SixAxes;
using Kind = haptics::PartCommand::Kind;

const glm::dquat kStraight(1.0, 0.0, 0.0, 0.0);

haptics::ContactScene modelled(const assets::Scene& scene) {
  haptics::ContactScene contact(scene, 1);
  contact.modelParts();
  return contact;
}

/// The grasp and the device of the link bench.
haptics::TickParameters benchParameters() {
  haptics::TickParameters p;
  p.graspStiffness = 1000.0;
  p.graspDamping = 2.0;
  p.graspRotStiffness = 2.5;
  p.graspRotDamping = 5e-3;
  p.forceLimit = haptics::SimulatedDeviceParameters{}.forceMax;
  p.torqueLimit = p.forceLimit * SixAxisArm::kLever;
  return p;
}

SiteId idOf(std::size_t site) { return static_cast<SiteId>(site + 1); }

}  // namespace

assets::Scene benchScene(double wall) {
  const glm::dvec3 size{0.12, 0.08, 0.06}, centre{0.01, -0.02, 0.015};  // as of the link bench
  assets::Scene scene = sceneOfParts({{.name = "block",
                                       .mesh = meshOf(moved(boxSoup(size, 2), centre)),
                                       .worldFromPart = {-centre, kStraight},
                                       .movable = true},
                                      {.name = "wall",
                                       .mesh = meshOf(boxSoup(glm::dvec3(0.2), 2)),
                                       .worldFromPart = {{0.5 * size.x + wall + 0.1, 0.0, 0.0}, kStraight}}});
  const glm::dvec3 s = size * size / 12.0;
  scene.parts[0].massProperties = {1.0, centre,
                                   glm::dmat3(s.y + s.z, 0, 0, 0, s.x + s.z, 0, 0, 0, s.x + s.y)};
  return scene;
}

const haptics::RigidBody& LinkedSites::Site::body() { return state.data().held.parts()[0].body; }

LinkedSites::LinkedSites(const LinkedSetup& setup)
    : parameters(benchParameters()), setup_(setup), contact_(modelled(setup_.scene)) {
  setup_.link.packetPeriod = setup.network.packetPeriod;
  const assets::Part& part = setup_.scene.parts[0];
  for (const BenchSite& given : setup_.sites) {
    const Pose grip = part.worldFromPart * Pose{part.massProperties.centreOfMass + given.grip, kStraight};
    sites_.push_back(std::make_unique<Site>(contact_, given, grip));
    sites_.back()->commands = {{Kind::own, 0, part.worldFromPart}, {Kind::grasp, 0, {}}};
  }
  const unsigned count = static_cast<unsigned>(sites_.size() * sites_.size());
  for (unsigned i = 0; i < count; ++i) lines_.emplace_back(setup_.network, 97u * setup_.seed + i);
  step([](double, int) { return SixAxes{}; });
}

void LinkedSites::linkAll() {
  const int links = static_cast<int>(sites_.size()) - 1;
  const double late = 1.15 * setup_.network.delay + 0.008;  // about what the ends will find
  if (links > 1) {
    setup_.link.impedance = haptics::linkImpedance(setup_.link.impedance, late, links);
    setup_.link.softImpedance = haptics::linkImpedance(setup_.link.softImpedance, late, links);
  }
  for (std::size_t i = 1; i < sites_.size(); ++i) {
    link(0, i, 1);
    link(i, 0, 1);
  }
  for (std::size_t i = 0; i < sites_.size(); ++i) share(i, links + 1);
}

void LinkedSites::link(std::size_t site, std::size_t peer, std::uint32_t epoch, bool carriesOn) {
  const std::uint64_t used = allocationsOfThisThread();
  sites_[site]->state.beginLink({{0, idOf(peer)}, setup_.link, setup_.network.delay, epoch, carriesOn});
  allocations += allocationsOfThisThread() - used;
}

void LinkedSites::command(std::size_t site, const haptics::PartCommand& command) {
  sites_[site]->commands.push_back(command);
}

void LinkedSites::exchange(std::size_t i) {
  Site& site = *sites_[i];
  for (std::size_t peer = 0; peer < sites_.size(); ++peer) {
    line(peer, i).deliver(time(), [&](const haptics::LinkPacket& packet) {
      const std::uint64_t used = allocationsOfThisThread();
      site.state.receive({{0, idOf(peer)}, packet});
      allocations += allocationsOfThisThread() - used;
    });
  }
}

void LinkedSites::tick(Site& site) {
  haptics::TickInput input;
  input.hands[0].device.worldFromDevice = site.arm.reading();
  input.hands[0].device.twist = site.arm.readingVelocity();
  input.hands[0].device.time = input.sessionTime = time();
  input.hands[0].device.valid = true;
  input.commands = site.commands;
  const std::uint64_t used = allocationsOfThisThread();
  site.out = haptics::tick(input, contact_, parameters, site.state);
  allocations += allocationsOfThisThread() - used;
  site.commands.clear();
  flags |= site.out.flags;
  Wrench& oldest = site.before[static_cast<std::size_t>(ticks_) % site.before.size()];
  site.change = ticks_ >= 20 ? glm::length(site.out.hands[0].toHand.force - oldest.force) : 0.0;
  oldest = site.out.hands[0].toHand;
}

void LinkedSites::moveArm(std::size_t i, const Intent& intent) {
  constexpr double e = 1e-4;
  const int who = static_cast<int>(i);
  const SixAxes before = intent(time() - e, who), at = intent(time(), who), after = intent(time() + e, who);
  sites_[i]->arm.step(at, (0.5 / e) * (after - before), (1.0 / (e * e)) * (after - at - (at - before)),
                      sites_[i]->onHand());
}

void LinkedSites::step(const Intent& intent) {
  for (std::size_t i = 0; i < sites_.size(); ++i) exchange(i);
  double given = 0.0;
  for (std::size_t i = 0; i < sites_.size(); ++i) {
    Site& site = *sites_[i];
    tick(site);
    std::array<haptics::AddressedPacket, haptics::ReplicaLinks::kMaxLinks> packets;
    const std::size_t count = site.state.drainPackets(packets);
    for (std::size_t k = 0; k < count && !site.silent; ++k) {
      const auto peer = static_cast<std::size_t>(packets[k].link.peer - 1);
      if (tamper && !tamper(i, packets[k].packet)) continue;
      if (peer < sites_.size()) line(i, peer).send(time(), packets[k].packet);
    }
    moveArm(i, intent);
    given += site.arm.given();
  }
  maxCreated = std::max(maxCreated, given);
  ++ticks_;
}

void LinkedSites::runTo(double until, const Intent& intent) {
  while (time() < until - 0.5 * kTick) step(intent);
}

}  // namespace tandem::test
