// A hand takes a part while the hand of another site moves it: how far the two replicas are apart from then
// on, and what both hands feel. Families drawn by seeds; TANDEM_FULL_SIZE runs more of them and prints the
// figures.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <random>
#include <vector>

#include "tests/simulation/bounds.h"
#include "tests/simulation/shared_sessions.h"
#include "tests/support/full_size.h"

namespace tandem::test {
namespace {

constexpr PartId kTaken = 0;
constexpr double kSettled = 1.0;     // s after the grasp
constexpr double kTouchFades = 0.1;  // s

constexpr haptics::LinkParameters kLink;
// N rms: below, what accelerates the replica is a large share of the hand's force, and the link has not that.
constexpr double kLoaded = 0.8;

struct Case {
  double delay = 25.0;       // ms, one way
  double amplitude = 0.025;  // m
  double hz = 0.5;
  glm::dvec3 axis{1.0, 0.0, 0.0};  // of the motion
  bool turns = false;              // the owner turns the part instead
  double at = 6.0;                 // s: when the second hand takes it
  haptics::ArmParameters guest = relaxedArm();
  double massFactor = 1.0;
  double end = 0.0;  // s; 0: 4.5 s after that
  std::uint64_t seed = 1;
};

struct Figures {
  double begun = -1.0;       // s: the first tick in which both simulate the part
  double held = -1.0;        // s: the first tick in which the second hand holds it
  double farthest = 0.0;     // m, from then on
  double rms = 0.0;          // m, from kSettled on
  double rmsUnloaded = 0.0;  // m, the same, less what the force of the second hand stretches the link
  double load = 0.0;         // N, rms of that force
  double yields = 0.0;       // m/N, how far the link yields to it
  double mayYield = 0.0;     // m/N, what it must at this delay: D_p / b + 2 / K
  double step = 0.0;         // N in 20 ms, either hand, until kSettled
  double stepOfDrag = 0.0;   // N in 20 ms, either hand, in the same drag later on
  double created = 0.0;      // J
};

/// The distance of two replicas as a line over the force between the hands, by axis: a link is a spring whose
/// stiffness depends on the delay, and what it yields under force is no error.
class Stretch {
 public:
  void add(const glm::dvec3& apart, const glm::dvec3& force) {
    apart_.push_back(apart);
    force_.push_back(force);
  }
  double rms() const { return rms(0.0); }
  /// What no stretch of the link explains.
  double rmsUnloaded() const { return rms(yields()); }
  /// The slope of that line, m/N.
  double yields() const {
    double product = 0.0, square = 1e-12;
    const glm::dvec3 meanApart = mean(apart_), meanForce = mean(force_);
    for (std::size_t i = 0; i < apart_.size(); ++i) {
      product += glm::dot(apart_[i] - meanApart, force_[i] - meanForce);
      square += glm::dot(force_[i] - meanForce, force_[i] - meanForce);
    }
    return std::max(0.0, -product / square);
  }
  /// N, rms.
  double load() const {
    double squares = 0.0;
    for (const glm::dvec3& force : force_) squares += glm::dot(force, force);
    return std::sqrt(squares / std::max(1.0, static_cast<double>(force_.size())));
  }

 private:
  static glm::dvec3 mean(const std::vector<glm::dvec3>& of) {
    glm::dvec3 sum(0.0);
    for (const glm::dvec3& one : of) sum += one;
    return sum / std::max(1.0, static_cast<double>(of.size()));
  }
  double rms(double yields) const {
    double squares = 0.0;
    for (std::size_t i = 0; i < apart_.size(); ++i) {
      const glm::dvec3 left = apart_[i] + yields * force_[i];
      squares += glm::dot(left, left);
    }
    return std::sqrt(squares / std::max(1.0, static_cast<double>(apart_.size())));
  }

  std::vector<glm::dvec3> apart_, force_;
};

SharedSession sessionOf(const Case& c) {
  SharedSession session("shared_drag", SharedSession::Contact::models, c.massFactor);
  session.setDelay(c.delay);
  session.options.seed = c.seed;
  session.arm(1) = c.guest;
  nlohmann::json owner = nlohmann::json::array();
  owner.push_back({{"t", 0.5}, {"do", "grasp"}, {"part", "block"}, {"over_s", 0.5}});
  const std::vector<double> axis{c.axis.x, c.axis.y, c.axis.z};
  if (c.turns) {
    for (int i = 0; i < 12; ++i)
      owner.push_back({{"t", 4.0 + i / c.hz / 2.0},
                       {"do", "turn"},
                       {"axis", axis},
                       {"angle", (i % 2 == 0 ? 1.0 : -1.0) * 10.0 * c.amplitude},
                       {"over_s", 0.5 / c.hz}});
  } else {
    owner.push_back({{"t", 4.0},
                     {"do", "sine"},
                     {"axis", axis},
                     {"amplitude", c.amplitude},
                     {"hz", c.hz},
                     {"for_s", 20.0}});
  }
  session.scenario.sites[0].script = owner.dump();
  const nlohmann::json guest =
      nlohmann::json::array({{{"t", c.at - 0.5}, {"do", "grasp"}, {"part", "block"}, {"over_s", 0.5}}});
  session.scenario.sites[1].script = guest.dump();
  session.scenario.duration = c.end > 0.0 ? c.end : c.at + 4.5;
  return session;
}

Figures runCase(const Case& c) {
  SharedSession session = sessionOf(c);
  Figures figures;
  Stretch stretch;
  std::array<std::vector<glm::dvec3>, 2> forces;
  session.options.watch = [&](double t, std::span<const client::SimulatedSiteState> sites) {
    const haptics::OwnedPart *owners = sites[0].tick->simulated(kTaken),
                             *guests = sites[1].tick->simulated(kTaken);
    if (owners == nullptr || guests == nullptr) return;
    if (figures.begun < 0.0) figures.begun = t;
    // A part that moves along the bare tool has pushed it, and that force fades first.
    if (c.axis.z == 0.0 || t > figures.begun + kTouchFades)
      for (std::size_t i = 0; i < 2; ++i) forces[i].push_back(sites[i].force);
    if (figures.held < 0.0 && sites[1].tick->hands[0].held == kTaken) figures.held = t;
    const glm::dvec3 apart = guests->worldFromPart.position - owners->worldFromPart.position;
    figures.farthest = std::max(figures.farthest, glm::length(apart));
    const bool settled = t > figures.begun + kSettled;
    if (settled) stretch.add(apart, sites[1].force);
    if (settled) figures.mayYield = guests->links.delay / kLink.impedance + 2.0 / kLink.spring;
    double& step = settled ? figures.stepOfDrag : figures.step;
    for (const std::vector<glm::dvec3>& force : forces)
      if (!force.empty()) step = std::max(step, changeIn20ms(force, force.size() - 1));
  };
  const client::SimulationResult result = session.run();
  EXPECT_TRUE(result.violations.empty()) << describe(result);
  figures.rms = stretch.rms();
  figures.rmsUnloaded = stretch.rmsUnloaded();
  figures.load = stretch.load();
  figures.yields = stretch.yields();
  figures.created = result.energyOfLinks;
  for (const auto& [name, site] : result.sites)
    figures.created = std::max(figures.created, site.energyCreated);
  return figures;
}

std::string describeCase(const Case& c, const Figures& f) {
  char text[480];
  std::snprintf(
      text, sizeof text,
      "%4.0f ms, %4.1f mm, %4.2f Hz, axis %.1f %.1f %.1f%s, at %.2f s, arm %3.0f N/m, mass x%.1f: "
      "held after %.2f s, farthest %5.2f mm, rms %5.2f, unloaded %5.2f, yields %.2f of %.2f mm/N at %.2f N, "
      "step %.3f N (drag %.3f), %.2g J",
      c.delay, 1e3 * c.amplitude, c.hz, c.axis.x, c.axis.y, c.axis.z, c.turns ? " turning" : "", c.at,
      c.guest.stiffness, c.massFactor, f.held - f.begun, 1e3 * f.farthest, 1e3 * f.rms, 1e3 * f.rmsUnloaded,
      1e3 * f.yields, 1e3 * f.mayYield, f.load, f.step, f.stepOfDrag, f.created);
  return text;
}

/// A case of the family, drawn by its seed.
Case drawn(std::uint64_t seed) {
  std::mt19937_64 random(seed * 0x9e3779b97f4a7c15ull + 11);
  const auto in = [&](double low, double high) {
    return low + (high - low) * std::generate_canonical<double, 32>(random);
  };
  const haptics::ArmParameters arms[] = {relaxedArm(), lightArm(), firmArm()};
  const double masses[] = {0.2, 1.0, 3.0};
  Case c;
  c.seed = seed;
  c.delay = in(5.0, 50.0);
  c.hz = in(0.2, 0.5);
  c.amplitude = in(0.008, 0.025);
  c.at = in(6.0, 8.0);
  c.axis = {0.0, 0.0, 0.0};
  c.axis[static_cast<int>(random() % 3)] = 1.0;
  c.turns = random() % 4 == 0;
  c.guest = arms[random() % 3];
  c.massFactor = masses[random() % 3];
  return c;
}

/// The same, but the second hand takes the part before it is moved. The orientation of a modelled hand yields
/// to nothing, so one that turns a part against another one adds energy by itself.
Case early(Case c) {
  c.end = c.at + 4.5;
  c.at = 2.0;
  return c;
}

TEST(LateGrasps, APartThatAnotherHandMovesIsTakenWhereItIs) {
  const std::uint64_t seeds = atFullSize() ? 200 : 12;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const Case c = drawn(seed);
    const Figures figures = runCase(c);
    SCOPED_TRACE(std::to_string(seed) + ": " + describeCase(c, figures));
    if (atFullSize()) std::printf("%3d %s\n", static_cast<int>(seed), describeCase(c, figures).c_str());
    EXPECT_GT(figures.held, 0.0);
    EXPECT_LE(figures.farthest, 10e-3);
    EXPECT_LE(figures.rmsUnloaded, 1e-3);
    EXPECT_TRUE(figures.load < kLoaded || figures.yields < 1.15 * figures.mayYield);
    EXPECT_LE(figures.step, std::max(0.3, figures.stepOfDrag));
    EXPECT_LE(figures.created, kEnergyBound + (c.turns ? runCase(early(c)).created : 0.0));
  }
}

// The control: out of the reach of links, nothing keeps the replicas together, and the measure shows it.
TEST(LateGrasps, BeyondTheReachOfLinksTheReplicasPart) {
  Case c;
  c.delay = 200.0;
  const Figures figures = runCase(c);
  EXPECT_GT(figures.farthest, 10e-3);
  EXPECT_GT(figures.rmsUnloaded, 1e-3);
}

}  // namespace
}  // namespace tandem::test
