// Two parts of different owners, each held at its own site, pressed together. Contact is local at both sites:
// each holds a replica of the other's part, which a link ties to it before the two touch.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>

#include "haptics/base/minimum_jerk.h"
#include "haptics/link/link_engagement.h"
#include "haptics/link/outage_spring.h"
#include "tests/haptics/link/link_checks.h"
#include "tests/support/full_size.h"

namespace tandem::test {
namespace {

using haptics::LinkEngagement;
using haptics::minimumJerk;
using haptics::SixAxes;

constexpr double kGap = 0.02;                           // m, between the parts at the start
constexpr glm::dvec3 kSize{0.04, 0.06, 0.05};           // m
constexpr double kStiffness = 5000.0, kDamping = 20.0;  // of a contact
constexpr haptics::CouplingGains kGrasp{1000.0, 2.0, 2.5, 5e-3};

/// What a replica of the other's part is: tied to it; that, and led by a plain spring to where the other one
/// has it until the link carries it; or put there.
enum class CoHolder { linked, sprung, kinematic };
constexpr double kCutAt = 4.4, kSettled = 4.2;  // s: of an outage; from when on the parts stand

assets::MassProperties block() {
  const glm::dvec3 s = kSize * kSize / 12.0;
  return {1.0, glm::dvec3(0.0), glm::dmat3(s.y + s.z, 0, 0, 0, s.x + s.z, 0, 0, 0, s.x + s.y)};
}

/// A replica of one part at one site.
struct Replica {
  Replica(const haptics::LinkParameters& p, const Network& n, double x, unsigned seed)
      : link(p), out(n, seed) {
    body.worldFromBody.position.x = x;
    haptics::changeMass(body, block(), 1e9);
    link.begin(1, n.delay);
    link.setOn(false);
  }
  Twist twist() const { return body.twist; }
  haptics::RigidBody body;
  haptics::MassRamp mass;
  haptics::CoordinationLink link;
  LinkLine out;
  LinkEngagement engagement;
  haptics::OutageSpring outageSpring;
  Wrench load;         // of this tick, about the centre of mass
  double acted = 0.0;  // N, of the link in the last tick
};

/// Part p is at home at site p; replica[s][p].
class Collision {
 public:
  Collision(const Network& network, CoHolder coHolder, double outage, unsigned seed)
      : coHolder_(coHolder), network_(network), outage_(outage) {
    haptics::LinkParameters p;
    p.lever = 0.03;
    p.fadeTime = LinkEngagement::kFadeTime;
    p.longestDelay = 0.35;
    p.peerSlew = 0.0;
    if (network.delay > 0.15) p.softImpedance = 10.0;  // a heavy link, but only while the parts are near
    for (unsigned s = 0; s < 2; ++s)
      for (unsigned part = 0; part < 2; ++part)
        replicas_[s].emplace_back(p, network, part == 0 ? -centre() : centre(), 31 * seed + 2 * s + part);
    for (int s = 0; s < 2; ++s) arms_.emplace_back(firmArm(), replicas_[s][s].body.worldFromBody);
  }
  static double centre() { return 0.5 * (kGap + kSize.x); }

  void step(const std::function<double(double, int)>& way) {
    exchange();
    for (int s = 0; s < 2; ++s) {
      for (Replica& r : replicas_[s]) r.load = {};
      touch(s);
      moveOwn(s);
      moveCoHolder(s);
    }
    for (int s = 0; s < 2 && ticks_ % 4 == 0; ++s)
      if (s == 1 || now() < kCutAt || now() >= kCutAt + outage_)
        for (Replica& r : replicas_[s]) r.out.send(now(), r.link.packet(now()));
    moveArms(way);
    ++ticks_;
  }

  double now() const { return kTick * static_cast<double>(ticks_); }
  double overlap() const {  // of the hands, beyond where the parts would touch
    return arms_[0].device().position.x - arms_[1].device().position.x + kSize.x;
  }
  Tally tally() const {
    Tally t;
    t.created = created_;
    t.inLinks = inLinks_;
    for (const auto& site : replicas_)
      for (const Replica& r : site)
        t.astray = t.astray || !(glm::length(r.body.worldFromBody.position) < 0.6);
    return t;
  }
  std::array<Wrench, 2> onHand;
  std::array<double, 2> push{};  // N, of the contact at each site
  double change = 0.0;           // N in 20 ms

 private:
  void exchange() {
    for (int s = 0; s < 2; ++s)
      for (int p = 0; p < 2; ++p)
        replicas_[1 - s][p].out.deliver(
            now(), [&](const haptics::LinkPacket& k) { replicas_[s][p].link.receive(k); });
  }

  /// The corners of part 0 that look at part 1 against its face.
  void touch(int s) {
    haptics::RigidBody &a = replicas_[s][0].body, &b = replicas_[s][1].body;
    const glm::dvec3 normal = b.worldFromBody.orientation * glm::dvec3{-1.0, 0.0, 0.0};
    const glm::dvec3 face = transformPoint(b.worldFromBody, {-0.5 * kSize.x, 0.0, 0.0});
    push[s] = 0.0;
    for (int corner = 0; corner < 4; ++corner) {
      const glm::dvec3 at = 0.5 * kSize * glm::dvec3{1.0, corner & 1 ? 1.0 : -1.0, corner & 2 ? 1.0 : -1.0};
      const glm::dvec3 point = transformPoint(a.worldFromBody, at);
      const double depth = glm::dot(face - point, normal);
      if (depth <= 0.0) continue;
      const glm::dvec3 slip =
          velocityAt(a.worldFromBody, a.twist, point) - velocityAt(b.worldFromBody, b.twist, point);
      const double size = std::max(0.0, 0.25 * (kStiffness * depth - kDamping * glm::dot(slip, normal)));
      press(replicas_[s][0], point, size * normal);
      press(replicas_[s][1], point, -size * normal);
      push[s] += size;
    }
  }
  static void press(Replica& r, const glm::dvec3& point, const glm::dvec3& force) {
    r.load.force += force;
    r.load.torque += glm::cross(point - r.body.worldFromBody.position, force);
  }

  /// The owner obeys: on as long as the coHolder asks.
  void moveOwn(int s) {
    Replica& own = replicas_[s][s];
    const haptics::LinkPacket* peer = own.link.newest();
    const bool asked = peer != nullptr && peer->asks && coHolder_ != CoHolder::kinematic;
    if (own.link.on() != asked) own.link.setOn(asked);
    if (asked) tied_[s] = true;
    if (!asked && own.acted < 0.01) tied_[s] = false;
    setMass(own, asked);
    const haptics::Coupling grasp{{}, arms_[s].reading(), arms_[s].readingVelocity(), kGrasp};
    onHand[s] = advance(own, &grasp, tied_[s]);
    if (!tied_[s]) own.link.follow(now(), own.body.worldFromBody, own.twist(), false);
  }

  void moveCoHolder(int s) {
    Replica &coHolder = replicas_[s][1 - s], &own = replicas_[s][s];
    const haptics::LinkPacket* owner = coHolder.link.newest();
    if (owner == nullptr) return coHolder.link.follow(now(), coHolder.body.worldFromBody, {}, false);
    const double age = std::min(0.3, now() - owner->time), way = s == 0 ? 1.0 : -1.0;
    const Pose target = integrate(owner->worldFromDrawn, owner->twist, age);
    const double gap =
        way * (coHolder.body.worldFromBody.position.x - own.body.worldFromBody.position.x) - kSize.x;
    const double closing = way * (own.body.twist.linear.x - owner->twist.linear.x);
    const auto role =
        coHolder.engagement.advance(gap, closing, coHolder.link.delay(),
                                    owner->on && coHolder_ != CoHolder::kinematic, coHolder.acted, kTick);
    if (role == LinkEngagement::Role::follower) {
      coHolder.link.setOn(false);
      coHolder.outageSpring = {};
      coHolder.acted = 0.0;
      const Twist twist = haptics::followTwist(coHolder.body.worldFromBody, target, owner->twist);
      haptics::moveBody(coHolder.body, twist.linear, twist.angular, kTick);
      return coHolder.link.follow(now(), coHolder.body.worldFromBody, twist, coHolder.engagement.asks());
    }
    coHolder.link.setOn(coHolder.engagement.asks());
    setMass(coHolder, true);
    const double lead = 1.0 - coHolder.link.fade();
    haptics::Coupling coupling{
        {}, target, owner->twist, {400.0 * lead, 28.0 * lead, 0.4 * lead, 0.03 * lead}};
    if (coHolder_ == CoHolder::linked) {
      coHolder.outageSpring.advance(coHolder.body.worldFromBody, coHolder.twist(),
                                    haptics::OutageSpring::targetOf(coHolder.link, now(), false), 0.03,
                                    kTick);
      coupling = coHolder.outageSpring.coupling(coHolder.body);
    }
    advance(coHolder, &coupling, true);
  }

  void setMass(Replica& r, bool shared) {
    const double added = shared ? 0.5 * r.link.addedMass() : 0.0;
    const assets::MassProperties target = haptics::replicaMass(block(), shared ? 2 : 1, added, 0.03);
    if (&r != &replicas_[0][0] && &r != &replicas_[1][1] && r.link.fade() == 0.0)
      haptics::changeMass(r.body, target, 1e9);  // a coHolder begins with its share
    else
      r.mass.advance(r.body, target, kTick);
  }

  /// A step under its load, a coupling and, if it is tied, its link. Returns what the coupling puts on a
  /// hand.
  Wrench advance(Replica& r, const haptics::Coupling* coupling, bool tied) {
    haptics::LinkPull pull;
    if (tied) pull = r.link.pull(now(), r.body.worldFromBody, r.twist());
    r.load.force += pull.held.force;
    r.load.torque += pull.held.torque;
    const std::array<haptics::Coupling, 2> couplings{
        haptics::Coupling{{}, r.body.worldFromBody, {}, {0.0, pull.damping, 0.0, pull.rotDamping}},
        *coupling};
    const haptics::CoupledStep step = haptics::coupleBody(r.body, couplings, r.load, {}, kTick);
    haptics::moveBody(r.body, step.freeVelocity, step.freeSpin, kTick);
    if (tied) r.acted = glm::length(r.link.account(r.body.worldFromBody, r.twist()).force);
    return step.couplings[1].onHand(step.freeVelocity, step.freeSpin);
  }

  void moveArms(const std::function<double(double, int)>& way) {
    double given = 0.0;
    change = 0.0;
    for (int s = 0; s < 2; ++s) {
      const double e = 1e-4, before = way(now() - e, s), at = way(now(), s), after = way(now() + e, s);
      const auto alongX = [](double x) { return SixAxes{{x, 0.0, 0.0}, {}}; };
      arms_[s].step(alongX(at), alongX((after - before) / (2.0 * e)),
                    alongX((after - 2.0 * at + before) / (e * e)), onHand[s]);
      given += arms_[s].given();
      Wrench& oldest = before_[s][static_cast<std::size_t>(ticks_) % 20];
      if (ticks_ >= 20) change = std::max(change, glm::length(onHand[s].force - oldest.force));
      oldest = onHand[s];
    }
    created_ = std::max(created_, given);
    for (int p = 0; p < 2; ++p) {
      double sum = 0.0;
      for (int s = 0; s < 2; ++s) {
        const haptics::LinkAccount& a = replicas_[s][p].link.account();
        sum += a.work + a.stored + a.reserve;
      }
      inLinks_ = std::max(inLinks_, sum);
    }
  }

  CoHolder coHolder_;
  Network network_;
  double outage_;  // s, of what site 0 sends
  std::array<std::vector<Replica>, 2> replicas_;
  std::vector<SixAxisArm> arms_;
  std::array<bool, 2> tied_{};
  std::array<std::array<Wrench, 20>, 2> before_{};
  double created_ = 0.0, inLinks_ = 0.0;
  long ticks_ = 0;
};

struct CollisionFigures : Tally {
  double stiffness = 0.0;  // N/m between the hands
  double before = 0.0;     // N in 20 ms, before the parts touch
  double held = 0.0;       // N in 20 ms, while they are held together
  double least = 1e300;    // N, on either hand in the last second of that
};

/// Pressed together for a while, in which nothing comes from one of the sites for `outage` s.
CollisionFigures pressTogether(double delay, CoHolder coHolder, double outage, unsigned seed) {
  const double apartAt = outage > 0.0 ? 8.0 : 5.0;
  Network network;
  network.delay = delay;
  Collision bench(network, coHolder, outage, seed);
  const auto way = [apartAt](double t, int who) {
    const double share = minimumJerk((t - 2.0) / 0.6) * (1.0 - minimumJerk((t - apartAt) / 0.8));
    return (who == 0 ? 1.0 : -1.0) * (0.5 * kGap + 0.009) * share;
  };
  CollisionFigures f;
  double force = 0.0, in = 0.0;
  bool touched = false;
  while (bench.now() < apartAt + 4.0 && !bench.tally().astray) {
    bench.step(way);
    const double t = bench.now();
    touched = touched || bench.push[0] > 0.0 || bench.push[1] > 0.0;
    if (t > 1.0 && !touched) f.before = std::max(f.before, bench.change);
    if (t < kSettled || t > apartAt) continue;
    force += glm::length(bench.onHand[1].force);
    in += bench.overlap();
    f.held = std::max(f.held, bench.change);
    if (t < apartAt - 1.0) continue;
    for (const Wrench& wrench : bench.onHand) f.least = std::min(f.least, glm::length(wrench.force));
  }
  static_cast<Tally&>(f) = bench.tally();
  f.stiffness = force / std::max(1e-6, in);
  return f;
}

TEST(LinkCollision, PartsOfTwoOwnersPressOnEachOther) {
  struct Row {
    double delay, stiffness;  // s; N/m at least
  };
  for (const Row& row :
       {Row{0.010, 330.0}, Row{0.025, 280.0}, Row{0.050, 235.0}, Row{0.100, 100.0}, Row{0.250, 44.0}}) {
    for (int seed = 1; seed <= seeds(1); ++seed) {
      const CollisionFigures f = pressTogether(row.delay, CoHolder::linked, 0.0, static_cast<unsigned>(seed));
      if (atFullSize() && seed <= 2)
        std::printf(
            "pressed together %3.0f ms: %3.0f N/m, %.2f N in 20 ms before they touch, %.2f N while held, "
            "%.4f mJ, "
            "link %.4f mJ\n",
            1e3 * row.delay, f.stiffness, f.before, f.held, 1e3 * f.created, 1e3 * f.inLinks);
      expectPassive(f, "pressed together");
      EXPECT_GE(f.stiffness, row.stiffness) << row.delay;
      EXPECT_LT(f.held, 0.3) << row.delay;
    }
  }
}

/// N in 20 ms: what either hand feels of outages while the parts press on each other.
double outagesFelt(double delay, CoHolder coHolder, const char* what) {
  double most = 0.0, created = 0.0;
  for (const double outage : {0.1, 0.3, 1.0}) {
    for (int seed = 1; seed <= seeds(1); ++seed) {
      const CollisionFigures f = pressTogether(delay, coHolder, outage, static_cast<unsigned>(seed));
      EXPECT_LE(f.inLinks, 1e-6) << delay;
      EXPECT_FALSE(f.astray) << delay;
      if (coHolder == CoHolder::linked) {
        EXPECT_LE(f.created, 1.3e-6) << delay;
        EXPECT_GT(f.least, 0.1) << delay << ": they do not press on each other any more";
      }
      most = std::max(most, f.held);
      created = std::max(created, f.created);
    }
  }
  if (atFullSize())
    std::printf("outages while pressed, %s, %3.0f ms: %.2f N in 20 ms, %.4f mJ\n", what, 1e3 * delay, most,
                1e3 * created);
  return most;
}

TEST(LinkCollision, OutagesWhilePressedAreNotFelt) {
  for (const double delay : {0.010, 0.025, 0.050, 0.100, 0.150, 0.250})
    EXPECT_LE(outagesFelt(delay, CoHolder::linked, "outage spring"), 0.3) << delay;
}

TEST(LinkCollision, OutagesWhilePressedAreFeltWhereAPlainSpringLeads) {
  // The control: its end is where the other one is said to be by now, and it lets go as the link comes up.
  for (const double delay : {0.025, 0.250})
    EXPECT_GT(outagesFelt(delay, CoHolder::sprung, "plain spring"), 0.6) << delay;
}

TEST(LinkCollision, KinematicReplicasAtBothSitesMakeEnergy) {
  // The control: nobody's part gives way at the other's site.
  const CollisionFigures f = pressTogether(0.025, CoHolder::kinematic, 0.0, 1);
  if (atFullSize())
    std::printf("kinematic: %.0f N/m, %.2f N while held, %.2f mJ%s\n", f.stiffness, f.held, 1e3 * f.created,
                f.astray ? " ASTRAY" : "");
  EXPECT_TRUE(f.astray || f.created > 5e-3);
}

}  // namespace
}  // namespace tandem::test
