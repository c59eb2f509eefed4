#pragma once

// Two people on one part across the network: one architecture that couples their sites, and its figures.

#include <string>

#include "client/report/link_rivals.h"
#include "haptics/link_bench/link_runs.h"

namespace tandem::client::report {

enum class Architecture { link, plain, tank, server, oneRoom };

/// One architecture with its parameters.
struct LinkSetting {
  std::string id, name;
  Architecture architecture = Architecture::link;
  double packetHz = 250.0;
  double margin = 0.0;     // s, by which a link plays out later than it finds enough
  double impedance = 0.0;  // N·s/m, of a link, b
  bool inUse = false;      // a link as sessions have it, whatever its impedance above
  SpringGains gains;       // of the others
  bool letsGo = false;     // hands that let go in tension are tried too
};

/// The figures of a setting, the worst of all seeds. Only `cost` depends on the machine.
struct LinkMeasurement {
  LinkSetting setting;
  double apart = 0.0, maxApart = 0.0;  // m, rms and largest, between the part at the two sites in the drag
  double offGrip = 0.0;                // m rms: the leader's hand from its grip on the displayed part
  double load = 0.0;                   // the leader's force in the drag, of that without a network
  double change = 0.0;                 // N: largest change of force in 20 ms on any hand in the drag
  double handToHand = 0.0;             // N/m
  double wall = 0.0;                   // N/m, as the co-holder feels it; NaN where it was not reached
  double playOut = 0.0;                // s, the play-out delay of the peer at the end of the drag; links only
  double bytes = 0.0;                  // a second, each way
  double created = 0.0;                // J, at the device ports, in any run
  double rest = 0.0;      // m, peak to peak, when hands have let go; NaN where that was not tried
  double cost = 0.0;      // of a tick of one end, in yardsticks; NaN where it was not timed
  bool diverged = false;  // a part went 0.6 m astray, or 1 J was created: no figures
  double off = 0.0;  // 0..1 of the drag's ticks in which the link was off and each site had the whole part
  bool stable() const { return !diverged && created <= bench::kEnergyBound && !(rest > kMaxRest); }

  static constexpr double kMaxRest = 1e-3;  // m
};

/// The network of every experiment: `delay` s one way, 20 % jitter, 2 % loss.
bench::Network networkOf(double delay, const LinkSetting& setting);

/// Runs the shared drag, the pull and the press, and letting go where the setting asks for it, with each seed
/// from 1 on. `aloneLoad` N rms: of the leader without a network, or 0.
LinkMeasurement measureLink(const LinkSetting& setting, double delay, int seeds, double aloneLoad);

/// N rms on the leader of the shared drag without a network.
double loadWithoutNetwork();

/// Times a tick of one end, in multiples of the implicit step of a held part in the same run (coupleBody with
/// one grip): receive, pull, account and packet, as they come in the drag; of the server its own step.
double tickCost(const LinkSetting& setting, double delay);

}  // namespace tandem::client::report
