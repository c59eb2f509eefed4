#pragma once

// Sites that hold one part across a modelled network: a grasp and a replica each, with site 0 linked to all
// others.

#include <memory>
#include <vector>

#include "haptics/link/replica_mass.h"
#include "haptics/link_bench/delayed_line.h"
#include "haptics/link_bench/hand_bench.h"
#include "haptics/link_bench/link_end.h"

namespace tandem::bench {

/// Parameters of a link whose ends believe each other: nobody lies in a bench.
inline haptics::LinkParameters believing() {
  haptics::LinkParameters link;
  link.peerSlew = 0.0;
  return link;
}

struct BenchSetup {
  std::vector<BenchSite> sites;
  Network network;
  unsigned seed = 1;
  Block block;
  haptics::LinkParameters link = believing();  // its packetPeriod is the network's
  LinkEndMaker makeEnd;                        // empty: CoordinationLinkEnd
};

class LinkBench : public HandBench {
 public:
  explicit LinkBench(const BenchSetup& setup);
  /// Side 0 is site 0's end of the link to site 1 + `link`.
  const LinkEnd& end(std::size_t link, std::size_t side) const { return *ends_[2 * link + side].link; }

 private:
  struct End {
    std::size_t site;
    std::unique_ptr<LinkEnd> link;
    LinkLine out;
    PacketClock clock;
  };
  void tick() override;
  void makeEnds();
  void setMasses();
  void move(std::size_t index);
  void accountLinks();

  BenchSetup setup_;
  std::vector<haptics::MassRamp> masses_;  // of each site
  std::vector<End> ends_;
};

}  // namespace tandem::bench
