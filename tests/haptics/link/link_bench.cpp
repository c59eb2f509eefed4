#include "tests/haptics/link/link_bench.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <glm/geometric.hpp>

namespace tandem::test {
namespace {

using haptics::minimumJerk;
using haptics::SixAxes;

constexpr int kSubsteps = 10;
constexpr double kFrictionSpeed = 1e-3;  // m/s
constexpr haptics::CouplingGains kGrasp{1000.0, 2.0, 2.5, 5e-3};
constexpr double kWallStiffness = 5000.0, kWallDamping = 20.0;  // of all four corners together
constexpr glm::dvec3 kCentreOfMass{0.01, -0.02, 0.015};         // m, body frame: anywhere but in its origin
constexpr std::uint32_t kSequenceStep = 1000;  // room for forged packets between two real ones

SixAxes coulomb(const SixAxes& v, double friction) {
  const auto axis = [friction](double x) {  // a smooth sign
    const double s = x / kFrictionSpeed;
    return friction * s / std::sqrt(1.0 + s * s);
  };
  return {{axis(v.along.x), axis(v.along.y), axis(v.along.z)},
          {axis(v.about.x), axis(v.about.y), axis(v.about.z)}};
}

glm::dvec3 quantised(const glm::dvec3& x, double quantum) {
  return {quantum * std::floor(x.x / quantum + 0.5), quantum * std::floor(x.y / quantum + 0.5),
          quantum * std::floor(x.z / quantum + 0.5)};
}

Wrench withinLimits(const Wrench& onHand) {
  const double most = haptics::SimulatedDeviceParameters{}.forceMax;
  return {haptics::limited(onHand.force, most), haptics::limited(onHand.torque, most * SixAxisArm::kLever)};
}

assets::MassProperties blockOf(double mass, const glm::dvec3& size) {
  const glm::dvec3 s = size * size;
  glm::dmat3 inertia(0.0);
  inertia[0][0] = mass / 12.0 * (s.y + s.z);
  inertia[1][1] = mass / 12.0 * (s.x + s.z);
  inertia[2][2] = mass / 12.0 * (s.x + s.y);
  return {mass, glm::dvec3(0.0), inertia};
}

}  // namespace

SixAxes dragWay(double t, double amplitude) {
  const double s = t - 1.0;
  if (s < 0.0) return {};
  const double share = s < 1.0 ? minimumJerk(s) : s > 8.0 ? 1.0 - minimumJerk(s - 8.0) : 1.0;
  return {{amplitude * share * std::sin(3.14159265358979 * s), 0.0, 0.0}, {}};
}

int seeds(int few) { return std::getenv("TANDEM_FULL_SIZE") != nullptr ? 20 : few; }

SixAxisArm::SixAxisArm(const haptics::ArmParameters& arm, const Pose& start)
    : arm_(arm), start_(start), armPose_(start), device_(start), read_(start) {}

Twist SixAxisArm::readingVelocity() const { return {readVelocity_.along, readVelocity_.about / kLever}; }

void SixAxisArm::step(const SixAxes& way, const SixAxes& velocity, const SixAxes& acceleration,
                      const Wrench& command) {
  const double h = kTick / kSubsteps;
  const SixAxes given{command.force, command.torque / kLever};
  const Pose target = haptics::gone(start_, way, kLever);
  for (int i = 0; i < kSubsteps; ++i) {
    SixAxes grip, drive = -50.0 * armVelocity_;
    if (held_) {
      grip = arm_.gripStiffness * haptics::wayBetween(device_, armPose_, kLever) +
             arm_.gripDamping * (armVelocity_ - velocity_);
      drive = arm_.stiffness * haptics::wayBetween(armPose_, target, kLever) +
              arm_.damping * (velocity - armVelocity_) + arm_.mass * acceleration;
    }
    velocity_ += (h / p_.mass) * (grip + given - p_.damping * velocity_ - coulomb(velocity_, p_.friction));
    armVelocity_ += (h / arm_.mass) * (drive - grip);
    device_ = haptics::gone(device_, h * velocity_, kLever);
    armPose_ = haptics::gone(armPose_, h * armVelocity_, kLever);
    given_ += h * haptics::dot(given, velocity_);
  }
  read();
}

void SixAxisArm::read() {
  const SixAxes way = haptics::wayBetween(start_, device_, kLever);
  const SixAxes seen{quantised(way.along, p_.quantum), quantised(way.about, p_.quantum)};
  const Pose last = read_;
  read_ = haptics::gone(start_, seen, kLever);
  readVelocity_ = 0.73 * readVelocity_ + (0.27 / kTick) * haptics::wayBetween(last, read_, kLever);
}

void DelayedLine::fly(double now, double jitter, const haptics::LinkPacket& packet) {
  const double delay = network_.delayAt ? network_.delayAt(now) : network_.delay;
  double arrives = now + std::max(kTick, delay * (1.0 + network_.jitter * (2.0 * jitter - 1.0)));
  const double end = network_.blackoutAt + network_.blackoutFor;
  if (arrives > network_.blackoutAt && now < end) {
    if (!network_.burst) return;
    arrives = std::max(arrives, end);
  }
  if (!network_.shuffled) arrives = last_ = std::max(last_, arrives);
  flying_.push_back({arrives, packet});
}

void DelayedLine::send(double now, const haptics::LinkPacket& packet) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const double lost = uniform(random_), jitter = uniform(random_), twice = uniform(random_),
               again = uniform(random_);
  if (lost < network_.loss) return;
  fly(now, jitter, packet);
  if (twice < network_.duplicate) {
    Flying copy = flying_.back();
    copy.arrives += 0.05 * again;
    flying_.push_back(copy);
  }
}

void DelayedLine::deliver(double now, const std::function<void(const haptics::LinkPacket&)>& take) {
  for (std::size_t i = 0; i < flying_.size();) {
    if (flying_[i].arrives > now + 1e-9) {
      ++i;
      continue;
    }
    take(flying_[i].packet);
    flying_.erase(flying_.begin() + static_cast<std::ptrdiff_t>(i));
  }
}

Pose LinkBench::Site::centre() const {
  return {transformPoint(body.worldFromBody, body.centreOfMass), body.worldFromBody.orientation};
}

LinkBench::LinkBench(const BenchSetup& setup) : setup_(setup), part_(blockOf(setup.mass, setup.size)) {
  const Pose start{-kCentreOfMass, {1.0, 0.0, 0.0, 0.0}};
  setup_.link.packetPeriod = setup.network.packetPeriod;
  for (const BenchSite& given : setup.sites) {
    Site site(given, start, {kCentreOfMass + given.grip, {1.0, 0.0, 0.0, 0.0}});
    site.body.centreOfMass = kCentreOfMass;
    site.body.worldFromBody = start;
    sites_.push_back(site);
  }
  const double delay = setup.network.delayAt ? setup.network.delayAt(0.0) : setup.network.delay;
  const int lines = static_cast<int>(sites_.size()) - 1;
  if (lines > 1) {
    const double late = 1.15 * delay + 0.008;  // about what the ends will find
    setup_.link.impedance = haptics::lineImpedance(setup_.link.impedance, late, lines);
    setup_.link.softImpedance = haptics::lineImpedance(setup_.link.softImpedance, late, lines);
  }
  for (std::size_t i = 1; i < sites_.size(); ++i) {
    for (unsigned side = 0; side < 2; ++side) {
      End end(setup_.link, setup.network, 97u * setup.seed + 2u * static_cast<unsigned>(i) + side);
      end.site = side == 0 ? 0 : i;
      end.link.begin(1, delay);
      ends_.push_back(end);
    }
  }
  setMasses();
}

void LinkBench::setMasses() {
  for (std::size_t i = 0; i < sites_.size(); ++i) {
    double line = 0.0;
    bool apart = ends_.empty();
    for (const End& end : ends_) {
      if (end.site != i) continue;
      line += 0.5 * end.link.lineMass();
      apart = apart || end.link.regime() == haptics::LinkRegime::apart;
    }
    const int share = apart ? 1 : static_cast<int>(sites_.size());
    if (setup_.tie == Tie::plain) line = 0.0;
    const assets::MassProperties target = haptics::replicaMass(part_, share, line, setup_.link.lever);
    if (ticks_ == 0)
      haptics::changeMass(sites_[i].body, target, 1e9);
    else
      sites_[i].mass.advance(sites_[i].body, target, kTick);
  }
}

void LinkBench::hear(End& end, const haptics::LinkPacket& packet) {
  if (!end.heard || packet.time > end.newest.time) {
    end.previous = end.newest;
    end.newest = packet;
    end.heard = true;
  }
  end.link.receive(packet);
}

/// The control that must fail: where nothing newer is there, the last wave and its energy go on.
void LinkBench::forge(End& end) {
  if (end.previous.sequence == 0 || time() - end.newest.time < setup_.network.delay) return;
  haptics::LinkPacket& last = end.newest;
  const double span = last.time - end.previous.time;
  haptics::LinkPacket next = last;
  next.time += setup_.network.packetPeriod;
  next.sequence += 1;
  const double share = setup_.network.packetPeriod / span;
  next.wave += share * (last.wave - end.previous.wave);
  next.energy += share * std::max(0.0, last.energy - end.previous.energy);
  hear(end, next);
}

haptics::LinkPull LinkBench::pull(End& end) {
  Site& site = sites_[end.site];
  const Twist twist{velocityAt(site.body.worldFromBody, site.body.twist, site.centre().position),
                    site.body.twist.angular};
  if (setup_.tie != Tie::plain) return end.link.pull(time(), site.centre(), twist);
  if (!end.heard) return {};
  const double k = setup_.plainStiffness, b = setup_.plainDamping, lever = setup_.link.lever;
  const SixAxes force = k * haptics::wayBetween(site.centre(), end.newest.worldFromDrawn, lever) +
                        b * (haptics::axesOf(end.newest.twist, lever) - haptics::axesOf(twist, lever));
  return {haptics::wrenchOf(force, lever), 0.1, 0.1 * lever * lever};
}

/// A penalty at the four corners that look at the wall.
Wrench LinkBench::wallForce(Site& site) const {
  site.push = 0.0;
  Wrench sum;
  if (!setup_.wall) return sum;
  const Pose centre = site.centre();
  for (int corner = 0; corner < 4; ++corner) {
    const glm::dvec3 at =
        0.5 * setup_.size * glm::dvec3{1.0, corner & 1 ? 1.0 : -1.0, corner & 2 ? 1.0 : -1.0};
    const glm::dvec3 point = transformPoint(centre, at);
    const double depth = point.x - *setup_.wall;
    if (depth <= 0.0) continue;
    const double speed = velocityAt(site.body.worldFromBody, site.body.twist, point).x;
    const double push = std::max(0.0, 0.25 * (kWallStiffness * depth + kWallDamping * speed));
    const glm::dvec3 force{-push, 0.0, 0.0};
    sum.force += force;
    sum.torque += glm::cross(point - centre.position, force);
    site.push += push;
  }
  return sum;
}

void LinkBench::move(std::size_t index) {
  Site& site = sites_[index];
  Wrench load = wallForce(site);
  double damping = 0.0, rotDamping = 0.0;
  for (End& end : ends_) {
    if (end.site != index) continue;
    end.pull = pull(end);
    load.force += end.pull.held.force;
    load.torque += end.pull.held.torque;
    damping += end.pull.damping;
    rotDamping += end.pull.rotDamping;
  }
  const Pose bodyFromCentre{site.body.centreOfMass, {1.0, 0.0, 0.0, 0.0}};
  const std::array<haptics::Coupling, 2> couplings{
      haptics::Coupling{
          bodyFromCentre, site.body.worldFromBody * bodyFromCentre, {}, {0.0, damping, 0.0, rotDamping}},
      haptics::Coupling{site.bodyFromGrip, site.arm.reading(), site.arm.readingVelocity(), kGrasp}};
  haptics::CoupledStep step = haptics::coupleBody(site.body, couplings, load, {}, kTick);
  const haptics::CouplingForce& grip = step.couplings[1];
  const Wrench wanted = grip.onHand(step.freeVelocity, step.freeSpin);
  site.onHand = withinLimits(wanted);
  if (site.onHand.force != wanted.force || site.onHand.torque != wanted.torque) {
    // What the device cannot give the part must not get either.
    load.force -= site.onHand.force;
    load.torque -= site.onHand.torque + glm::cross(grip.arm, site.onHand.force);
    step = haptics::coupleBody(site.body, {couplings.data(), 1}, load, {}, kTick);
  }
  haptics::moveBody(site.body, step.freeVelocity, step.freeSpin, kTick);
  for (End& end : ends_)
    if (end.site == index) end.link.settle(site.centre(), {step.freeVelocity, step.freeSpin});
}

void LinkBench::step(const Intent& intent) {
  const double now = time();
  for (std::size_t i = 0; i < ends_.size(); ++i) {
    End& end = ends_[i];
    ends_[i ^ 1u].out.deliver(now, [&](const haptics::LinkPacket& packet) { hear(end, packet); });
    if (setup_.tie == Tie::holdLast) forge(end);
  }
  if (setup_.tie != Tie::plain) setMasses();
  for (std::size_t i = 0; i < sites_.size(); ++i) move(i);
  const long every = std::lround(setup_.network.packetPeriod / kTick);
  for (End& end : ends_) {
    if (ticks_ % every != 0) continue;
    haptics::LinkPacket packet = end.link.packet(now);
    packet.sequence *= kSequenceStep;
    end.out.send(now, packet);
  }
  account();
  for (std::size_t i = 0; i < sites_.size(); ++i) {
    constexpr double e = 1e-4;
    const int who = static_cast<int>(i);
    const SixAxes before = intent(now - e, who), at = intent(now, who), after = intent(now + e, who);
    sites_[i].arm.step(at, (0.5 / e) * (after - before), (1.0 / (e * e)) * (after - at - (at - before)),
                       sites_[i].onHand);
  }
  ++ticks_;
}

void LinkBench::account() {
  double given = 0.0;
  for (Site& site : sites_) {
    given += site.arm.given();
    Wrench& oldest = site.before[static_cast<std::size_t>(ticks_) % site.before.size()];
    const bool full = ticks_ >= static_cast<long>(site.before.size());
    site.change = full ? glm::length(site.onHand.force - oldest.force) : 0.0;
    site.turnChange = full ? glm::length(site.onHand.torque - oldest.torque) : 0.0;
    oldest = site.onHand;
  }
  mostCreated = std::max(mostCreated, given);
  for (std::size_t i = 0; i + 1 < ends_.size(); i += 2) {
    double sum = 0.0;
    for (std::size_t side = 0; side < 2; ++side) {
      const haptics::LinkAccount& a = ends_[i + side].link.account();
      sum += a.work + a.stored + a.reserve;
    }
    mostInLinks = std::max(mostInLinks, sum);
  }
}

bool LinkBench::runTo(double until, const Intent& intent) {
  while (time() < until) {
    step(intent);
    if (astray()) return false;
  }
  return true;
}

double LinkBench::lent() const {
  double sum = 0.0;
  for (const End& end : ends_) sum += end.link.account().lent;
  return sum;
}

double LinkBench::gap(std::size_t i, std::size_t j) const {
  return glm::length(sites_[i].centre().position - sites_[j].centre().position);
}

double LinkBench::turnGap(std::size_t i, std::size_t j) const {
  return glm::length(rotationVector(sites_[i].body.worldFromBody.orientation *
                                    glm::conjugate(sites_[j].body.worldFromBody.orientation)));
}

bool LinkBench::astray() const {
  for (const Site& site : sites_)
    if (!(glm::length(site.centre().position) < 0.6)) return true;
  return false;
}

}  // namespace tandem::test
