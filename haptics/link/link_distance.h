#pragma once

// Distance policy: what a coordination link may do at a network delay. All thresholds of delay stand here: up
// to which delay a link couples at all, where it softens, and which impedance it then has. RegimeByAge, the
// ends of links, the hand and the network side call these functions and hold no thresholds of their own.

#include "haptics/base/link_packet.h"

namespace tandem::haptics {

/// Longest delay, s, at which a link couples two replicas. `held`: a hand at this end holds the part, or has
/// held it since the link began, so force goes from hand to hand. Otherwise parts of this site touch the
/// replica, which bears a longer delay. An end may also be set to less; the lower value of both ends counts,
/// because the worse regime does.
constexpr double longestDelay(bool held) { return held ? 0.15 : 0.35; }

/// Age of the newest packet, s: as it is, low-passed, and over the long term.
struct PacketAge {
  double newest = 0.0;
  double mean = 0.0;
  double longTerm = 0.0;  // jitter does not raise it
};

/// The regime with which a link begins at a network delay of `delay` s.
LinkRegime regimeAt(double delay, double longestDelay);
/// The regime that these ages ask for, while the link is in `present`: with hysteresis, so that jitter does
/// not change it.
LinkRegime regimeAt(const PacketAge& age, LinkRegime present, double longestDelay);

/// Upper bound of the summed mass b D_p of all links from one site, kg; the hand that leads the part carries
/// it.
inline constexpr double kMaxLinkMass = 1.7;

/// Impedance of each of `links` links from one site, N·s/m: `greatest` where the links stay light enough.
/// Both ends of a link need the same value, so one end decides.
double linkImpedance(double greatest, double playOutDelay, int links);

/// Impedance b of a link in the regimes stiff and soft, N·s/m.
struct LinkImpedances {
  double stiff = 0.0, soft = 0.0;
};
/// Impedances of each of `links` links from one site to a peer whose packets, one in `packetPeriod` s, are
/// `age` s old on average. Beyond the longest delay of hands, only parts that touch are linked, and softly.
LinkImpedances impedancesAt(double age, double packetPeriod, int links);

}  // namespace tandem::haptics
