#include "client/report/link_rivals.h"

#include <algorithm>
#include <cmath>

#include "assets/base/assert.h"

namespace tandem::client::report {

using haptics::SixAxes;

namespace {

constexpr double kServerDrag = 0.1;  // N·s/m: as a link has on its replica
constexpr double kLever = haptics::LinkParameters{}.lever;

haptics::CouplingGains couplingOf(const SpringGains& gains) {
  const double square = kLever * kLever;
  return {gains.stiffness, gains.damping, gains.stiffness * square, gains.damping * square};
}

haptics::LinkPull dragAnd(const Wrench& held) { return {held, kServerDrag, kServerDrag * kLever * kLever}; }

/// One of two equal legs: half the delay, and the loss that gives the whole one over both legs.
bench::Network legOf(bench::Network network) {
  network.delay *= 0.5;
  network.loss = 1.0 - std::sqrt(1.0 - network.loss);
  return network;
}

}  // namespace

void TankEnd::receive(const haptics::LinkPacket& packet) {
  if (hasPeer_ && packet.time <= peer_.time) return;
  if (!hasPeer_) drawnTo_ = own_.worldFromDrawn;
  peer_ = packet;
  hasPeer_ = true;
}

haptics::LinkPull TankEnd::pull(double, const Pose& worldFromCentre, const Twist&) {
  damping_ = gains_.damping + std::min(kMaxFilling, kFilling * std::max(0.0, kLevel - tank_));
  const double damping = damping_ + kDrag;
  if (!hasPeer_) return {{}, damping, damping * lever_ * lever_};
  tank_ += peer_.energy - taken_;
  taken_ = peer_.energy;
  const double half = 0.5 * gains_.stiffness;
  const SixAxes before = haptics::displacementBetween(worldFromCentre, drawnTo_, lever_);
  const double stored = half * haptics::dot(before, before);
  const SixAxes wanted = haptics::displacementBetween(worldFromCentre, peer_.worldFromDrawn, lever_);
  const SixAxes stretch = haptics::shortened(wanted, std::sqrt((stored + tank_) / half));
  tank_ = std::max(0.0, tank_ - (half * haptics::dot(stretch, stretch) - stored));
  drawnTo_ = haptics::applied(worldFromCentre, stretch, lever_);
  const double implicit = damping + gains_.stiffness * period_;
  return {haptics::wrenchOf(gains_.stiffness * stretch, lever_), implicit, implicit * lever_ * lever_};
}

void TankEnd::account(const Pose& worldFromCentre, const Twist& twist) {
  const SixAxes v = haptics::axesOf(twist, lever_);
  tank_ += period_ * damping_ * haptics::dot(v, v);
  own_.energy += std::max(0.0, tank_ - kLevel);
  tank_ = std::min(tank_, kLevel);
  own_.worldFromDrawn = worldFromCentre;
  own_.twist = twist;
}

haptics::LinkPacket TankEnd::packet(double now) {
  own_.time = now;
  ++own_.sequence;
  return own_;
}

ServerBench::ServerBench(const Setup& setup)
    : HandBench(setup.sites, setup.block),
      setup_(setup),
      clock_(setup.network.packetPeriod),
      body_(bodyOf(setup.block)),
      onHands_(setup.sites.size()) {
  ASSERT(setup.sites.size() <= haptics::kMaxCouplings);
  const bench::Network leg = legOf(setup.network);
  for (unsigned i = 0; i < setup.sites.size(); ++i) {
    const unsigned seed = 193u * setup.seed + 2u * i;
    legs_.push_back(
        {bench::DelayedLine<Up>(leg, seed), bench::DelayedLine<Down>(leg, seed + 1), {}, {}, false});
  }
}

void ServerBench::tick() {
  const double now = time();
  for (Leg& leg : legs_)
    leg.up.deliver(now, [&](const Up& up) {
      if (!leg.hasReceived || up.time > leg.received.time) leg.received = up;
      leg.hasReceived = true;
    });
  stepServer();
  if (clock_.due(now)) send(now);
  for (std::size_t i = 0; i < legs_.size(); ++i) {
    Leg& leg = legs_[i];
    leg.down.deliver(now, [&](const Down& down) {
      if (down.time < leg.shown.time) return;
      leg.shown = down;
      sites_[i].body.worldFromBody = down.part;
    });
    sites_[i].onHand = leg.shown.onHand;
    sites_[i].push = push_;
  }
}

void ServerBench::stepServer() {
  std::array<haptics::Coupling, haptics::kMaxCouplings> springs;
  std::array<Wrench, haptics::kMaxCouplings> given;
  std::array<std::size_t, haptics::kMaxCouplings> whose{};
  std::size_t count = 0;
  for (std::size_t i = 0; i < legs_.size(); ++i) {
    if (!legs_[i].hasReceived) continue;
    whose[count] = i;
    springs[count++] = {sites_[i].bodyFromGrip, legs_[i].received.device, legs_[i].received.twist,
                        couplingOf(setup_.gains)};
  }
  const bench::WallTouch touch = bench::touchWall(setup_.block, body_);
  push_ = touch.push;
  bench::stepHeld(body_, {springs.data(), count}, dragAnd(touch.onBody), {given.data(), count});
  for (std::size_t i = 0; i < count; ++i) onHands_[whose[i]] = given[i];
}

void ServerBench::send(double now) {
  for (std::size_t i = 0; i < legs_.size(); ++i) {
    legs_[i].up.send(now, {now, sites_[i].arm.reading(), sites_[i].arm.readingVelocity()});
    legs_[i].down.send(now, {now, body_.worldFromBody, onHands_[i]});
  }
}

OneRoomBench::OneRoomBench(const std::vector<bench::BenchSite>& sites, const bench::Block& block)
    : HandBench(sites, block), block_(block), body_(bodyOf(block)) {
  ASSERT(sites.size() <= haptics::kMaxCouplings);
}

void OneRoomBench::tick() {
  std::array<haptics::Coupling, haptics::kMaxCouplings> grips;
  std::array<Wrench, haptics::kMaxCouplings> onHands;
  for (std::size_t i = 0; i < sites_.size(); ++i) grips[i] = sites_[i].grip(bench::kGrasp);
  const bench::WallTouch touch = bench::touchWall(block_, body_);
  bench::stepHeld(body_, {grips.data(), sites_.size()}, dragAnd(touch.onBody),
                  {onHands.data(), sites_.size()});
  for (std::size_t i = 0; i < sites_.size(); ++i) {
    sites_[i].body = body_;
    sites_[i].onHand = onHands[i];
    sites_[i].push = touch.push;
  }
}

}  // namespace tandem::client::report
