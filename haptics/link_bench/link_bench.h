#pragma once

// Sites that hold one part across a modelled network: a grasp and a replica each, with site 0 tied to all
// others.

#include <memory>
#include <vector>

#include "haptics/link/replica_mass.h"
#include "haptics/link_bench/delayed_line.h"
#include "haptics/link_bench/hand_bench.h"
#include "haptics/link_bench/tie_end.h"

namespace tandem::bench {

struct BenchSetup {
  std::vector<BenchSite> sites;
  Network network;
  unsigned seed = 1;
  Block block;
  haptics::LinkParameters link;  // its packetPeriod is the network's
  TieMaker tie;                  // empty: LinkEnd
};

class LinkBench : public HandBench {
 public:
  explicit LinkBench(const BenchSetup& setup);
  /// Side 0 is site 0's end of the tie to site 1 + `tie`.
  const TieEnd& end(std::size_t tie, std::size_t side) const { return *ends_[2 * tie + side].tie; }

 private:
  struct End {
    std::size_t site;
    std::unique_ptr<TieEnd> tie;
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
