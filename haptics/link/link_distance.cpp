#include "haptics/link/link_distance.h"

#include <algorithm>

#include "assets/base/assert.h"
#include "haptics/link/link_terms.h"
#include "haptics/link/play_out_delay.h"

namespace tandem::haptics {
namespace {

constexpr double kSoft = 0.059, kStiffAgain = 0.049;  // s
constexpr double kAgain = 0.93;         // of the longest delay, below which the link begins again
constexpr double kSurelySoft = 0.064;   // s: beyond the jitter of a stiff path
constexpr double kSoftPlayOut = 0.06;   // s, of play-out: the least in regime soft
constexpr double kFarImpedance = 10.0;  // N·s/m, where only parts that touch are linked
constexpr double kMaxFarLinkMass =
    3.4;  // kg, as kMaxLinkMass: such links last while parts are near each other

}  // namespace

LinkRegime regimeAt(double delay, double longest) {
  if (delay > longest) return LinkRegime::apart;
  return delay > kSoft ? LinkRegime::soft : LinkRegime::stiff;
}

LinkRegime regimeAt(const PacketAge& age, LinkRegime present, double longest) {
  if (age.newest > longest || age.mean > longest) return LinkRegime::apart;
  if (present == LinkRegime::apart && age.mean > kAgain * longest) return LinkRegime::apart;
  if (present == LinkRegime::stiff)
    return age.mean > kSurelySoft || age.longTerm > kSoft ? LinkRegime::soft : LinkRegime::stiff;
  return age.mean < kStiffAgain ? LinkRegime::stiff : LinkRegime::soft;
}

double linkImpedance(double greatest, double playOutDelay, int links) {
  ASSERT(links > 0);
  return std::min(greatest, kMaxLinkMass / (playOutDelay * links));
}

LinkImpedances impedancesAt(double age, double packetPeriod, int links) {
  const LinkParameters standard;
  PlayOutDelay playOut;
  playOut.restart(age, packetPeriod, standard.period);
  const double late = playOut.seconds();
  const double soft = age > longestDelay(true)
                          ? std::min(kFarImpedance, kMaxFarLinkMass / (late * links))
                          : linkImpedance(standard.softImpedance, std::max(late, kSoftPlayOut), links);
  return {linkImpedance(standard.impedance, late, links), soft};
}

}  // namespace tandem::haptics
