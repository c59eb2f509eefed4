#include "haptics/link_bench/link_bench.h"

#include <algorithm>

namespace tandem::bench {

LinkBench::LinkBench(const BenchSetup& setup)
    : HandBench(setup.sites, setup.block), setup_(setup), masses_(setup.sites.size()) {
  setup_.link.packetPeriod = setup.network.packetPeriod;
  makeEnds();
  setMasses();
}

void LinkBench::makeEnds() {
  const double delay = setup_.network.delayNow(0.0);
  const int links = static_cast<int>(sites_.size()) - 1;
  if (links > 1) {
    const double late = 1.15 * delay + 0.008;  // estimate of the play-out delay
    setup_.link.impedance = haptics::linkImpedance(setup_.link.impedance, late, links);
    setup_.link.softImpedance = haptics::linkImpedance(setup_.link.softImpedance, late, links);
  }
  for (std::size_t i = 1; i < sites_.size(); ++i) {
    for (unsigned side = 0; side < 2; ++side) {
      const unsigned seed = 97u * setup_.seed + 2u * static_cast<unsigned>(i) + side;
      ends_.push_back({side == 0 ? 0 : i,
                       setup_.makeEnd ? setup_.makeEnd(setup_.link, delay)
                                      : std::make_unique<CoordinationLinkEnd>(setup_.link, delay),
                       LinkLine(setup_.network, seed), PacketClock(setup_.network.packetPeriod)});
    }
  }
}

void LinkBench::setMasses() {
  for (std::size_t i = 0; i < sites_.size(); ++i) {
    double added = 0.0;
    bool apart = ends_.empty();
    for (const End& end : ends_) {
      if (end.site != i) continue;
      added += 0.5 * end.link->addedMass();
      apart = apart || end.link->apart();
    }
    const int share = apart ? 1 : static_cast<int>(sites_.size());
    const assets::MassProperties target =
        haptics::replicaMass(setup_.block.massProperties(), share, added, setup_.link.lever);
    if (begins())
      haptics::changeMass(sites_[i].body, target, 1e9);
    else
      masses_[i].advance(sites_[i].body, target, kTick);
  }
}

void LinkBench::move(std::size_t index) {
  Site& site = sites_[index];
  const WallTouch touch = touchWall(setup_.block, site.body);
  site.push = touch.push;
  haptics::LinkPull load{touch.onBody};
  for (End& end : ends_) {
    if (end.site != index) continue;
    const haptics::LinkPull pull = end.link->pull(time(), site.centre(), twistOfCentre(site.body));
    load.held.force += pull.held.force;
    load.held.torque += pull.held.torque;
    load.damping += pull.damping;
    load.rotDamping += pull.rotDamping;
  }
  const haptics::Coupling grip = site.grip(kGrasp);
  const Twist twist = stepHeld(site.body, {&grip, 1}, load, {&site.onHand, 1});
  for (End& end : ends_)
    if (end.site == index) end.link->account(site.centre(), twist);
}

void LinkBench::tick() {
  const double now = time();
  for (std::size_t i = 0; i < ends_.size(); ++i)
    ends_[i ^ 1u].out.deliver(now,
                              [&](const haptics::LinkPacket& packet) { ends_[i].link->receive(packet); });
  setMasses();
  for (std::size_t i = 0; i < sites_.size(); ++i) move(i);
  for (End& end : ends_)
    if (end.clock.due(now)) end.out.send(now, end.link->packet(now));
  accountLinks();
}

void LinkBench::accountLinks() {
  for (std::size_t i = 0; i + 1 < ends_.size(); i += 2) {
    double sum = 0.0;
    for (std::size_t side = 0; side < 2; ++side) {
      const haptics::LinkAccount account = ends_[i + side].link->account();
      sum += account.work + account.stored + account.reserve;
    }
    maxInLinks = std::max(maxInLinks, sum);
  }
}

}  // namespace tandem::bench
