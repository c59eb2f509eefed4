#pragma once

// Sites whose whole ticks simulate one part of a scene with contact, linked across a modelled network: the
// arms of the link bench, virtual time.

#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "haptics/link/replica_links.h"
#include "haptics/tick.h"
#include "tests/haptics/link/link_checks.h"

namespace tandem::test {

struct LinkedSetup {
  assets::Scene scene;  // part 0 is held
  std::vector<BenchSite> sites;
  Network network;
  unsigned seed = 1;
  haptics::LinkParameters link;
};

class LinkedSites {
 public:
  using Intent = LinkBench::Intent;

  /// Every site holds part 0, nothing is linked yet.
  explicit LinkedSites(const LinkedSetup& setup);
  LinkedSites(const LinkedSites&) = delete;

  /// Links site 0 to all others, and shares the mass among them.
  void linkAll();
  /// Begins one end of a link.
  void link(std::size_t site, std::size_t peer, std::uint32_t epoch, bool carriesOn = false);
  void share(std::size_t site, int simulators) { sites_[site]->state.setSimulators(0, simulators); }
  /// Carried out in the next tick of a site.
  void command(std::size_t site, const haptics::PartCommand& command);
  /// A site that says nothing any more.
  void silence(std::size_t site) { sites_[site]->silent = true; }

  void step(const Intent& intent);
  void runTo(double time, const Intent& intent);

  struct Site {
    Site(const haptics::ContactScene& contact, const BenchSite& given, const Pose& grip)
        : state(contact), arm(given.arm, grip) {}
    haptics::TickState state;
    SixAxisArm arm;
    std::vector<haptics::PartCommand> commands;
    haptics::TickOutput out;
    std::array<Wrench, 20> before{};  // of the last 20 ticks
    double change = 0.0;              // N, of the force on the hand in 20 ms
    bool silent = false;

    const haptics::OwnedPart& part() const { return out.owned[0]; }
    const Wrench& onHand() const { return out.hands[0].toHand; }
    const haptics::RigidBody& body();
  };
  /// What becomes of the packets that a site sends; false: it sends none.
  std::function<bool(std::size_t site, haptics::LinkPacket&)> tamper;

  Site& site(std::size_t i) { return *sites_[i]; }
  const haptics::ContactScene& contact() const { return contact_; }
  double time() const { return kTick * static_cast<double>(ticks_); }

  double maxCreated = 0.0;        // J, at all device ports together
  std::uint32_t flags = 0;        // of all ticks
  std::uint64_t allocations = 0;  // in ticks and in what is called between them
  haptics::TickParameters parameters;

 private:
  LinkLine& line(std::size_t from, std::size_t to) { return lines_[from * sites_.size() + to]; }
  void tick(Site& site);
  void exchange(std::size_t site);
  void moveArm(std::size_t site, const Intent& intent);

  LinkedSetup setup_;
  haptics::ContactScene contact_;
  std::vector<std::unique_ptr<Site>> sites_;
  std::vector<LinkLine> lines_;
  long ticks_ = 0;
};

/// The block of the link bench, its centre of mass in the origin. A fixed block stands `wall` m before it
/// along x.
assets::Scene benchScene(double wall = 0.5);

}  // namespace tandem::test
