#pragma once

// Identity and terms of a coordination link, as one value: the network side of a site makes it, orders it of
// the hand, and both ends of the link run by it.

#include <cstdint>

#include "assets/base/ids.h"
#include "haptics/base/link_packet.h"
#include "haptics/link/link_distance.h"

namespace tandem::haptics {

struct LinkParameters {
  double period = 1e-3;         // s, of the tick
  double packetPeriod = 4e-3;   // s, between the peer's packets
  double lever = 0.05;          // m, of the part, the same at both ends; converts angles to lengths
  double impedance = 27.0;      // N·s/m: b, in regime stiff
  double softImpedance = 14.0;  // N·s/m: b, in regime soft
  double spring = 10000.0;      // N/m: K
  double drag = 0.1;            // N·s/m, on the replica at all times
  double fillingDrag = 0.6;     // N·s/m, additional drag while the reserve is empty
  double fadeTime = 0.5;        // s, until the link has its full force
  double longestDelay = haptics::longestDelay(true);  // s: the link is off beyond it
  double peerSlew = 10.0;                             // N/s: how fast a peer may change the force; 0: any
  double playOutMargin = 0.0;                         // s, added to the delay that PlayOutDelay estimates
};

/// Which link: two sites have at most one for a part.
struct LinkId {
  PartId part = kNoPart;
  SiteId peer = kNoSite;  // the site at the other end
  friend bool operator==(const LinkId&, const LinkId&) = default;
};

/// What both ends agree on before they link their replicas.
struct LinkTerms {
  LinkId id;
  LinkParameters parameters;  // the same at both ends; `period` is the tick's
  double delay = 0.0;         // s, the known network delay
  // Any number that this link has at both ends and that no earlier link between them had.
  std::uint32_t epoch = 0;
  /// Continues the same link under a new epoch without a felt change. Both ends must agree; a peer that lost
  /// its end may not.
  bool carriesOn = false;
  /// s, of the first fade-in of a new link whose replica no hand presses on yet; 0: parameters.fadeTime.
  double firstFadeTime = 0.0;
  /// The outage spring (outage_spring.h) leads the replica while the link does not carry it; for the replica
  /// of a co-holder whose hand has not held the part.
  bool outageSpring = false;
};

/// A packet with the link that it belongs to.
struct AddressedPacket {
  LinkId link;
  LinkPacket packet;
};

}  // namespace tandem::haptics
