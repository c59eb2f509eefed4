#pragma once

// People at their sites who hold one part, on virtual time: six-axis arms, the commands of their devices, and
// their energy accounts. A derived class defines the connection between the devices.

#include <array>
#include <functional>
#include <vector>

#include "haptics/link_bench/held_block.h"
#include "haptics/link_bench/six_axis_arm.h"

namespace tandem::bench {

struct BenchSite {
  haptics::ArmParameters arm;
  glm::dvec3 grip{0.0, 0.0, 0.0};  // m, from the centre of mass, body axes
};

class HandBench {
 public:
  /// Intended displacement of the hand of a site from its start at a time; angles are times
  /// SixAxisArm::kLever.
  using Intent = std::function<haptics::SixAxes(double, int)>;

  virtual ~HandBench() = default;
  HandBench(const HandBench&) = delete;
  HandBench& operator=(const HandBench&) = delete;

  void step(const Intent& intent);
  /// Runs until `time`; false when a part has diverged.
  bool runTo(double time, const Intent& intent);

  struct Site {
    Site(const BenchSite& given, const haptics::RigidBody& start);
    Pose bodyFromGrip;
    SixAxisArm arm;
    haptics::RigidBody body;                // the part as this site has it
    Wrench onHand;                          // sent to the device, limited
    std::array<Wrench, 20> before{};        // of the last 20 ticks
    double change = 0.0, turnChange = 0.0;  // N, N·m: of the force on the hand in 20 ms
    double push = 0.0;                      // N, of the wall
    Pose centre() const { return centreOf(body); }
    haptics::Coupling grip(const haptics::CouplingGains& gains) const;
    /// Distance of the device from the grip on the locally seen part, m.
    double offGrip() const;
  };
  Site& site(std::size_t i) { return sites_[i]; }
  const Site& site(std::size_t i) const { return sites_[i]; }
  std::size_t siteCount() const { return sites_.size(); }
  double time() const { return kTick * static_cast<double>(ticks_); }
  /// Distance between the centres of the part at two sites, m, and the angle between them, rad.
  double gap(std::size_t i, std::size_t j) const;
  double turnGap(std::size_t i, std::size_t j) const;
  bool astray() const;

  double maxCreated = 0.0;  // J, created at all device ports together
  double maxInLinks = 0.0;  // J, the most that any link has given and may still give beyond its input

 protected:
  HandBench(const std::vector<BenchSite>& sites, const Block& block);
  /// A tick at all sites: from the readings of the arms to `body`, `onHand` and `push`.
  virtual void tick() = 0;
  bool begins() const { return ticks_ == 0; }

  std::vector<Site> sites_;

 private:
  void account();
  void moveArm(std::size_t index, const Intent& intent);
  long ticks_ = 0;
};

}  // namespace tandem::bench
