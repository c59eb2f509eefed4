// The distance policy of coordination links: regimes and impedances by delay alone, without a link.

#include "haptics/link/link_distance.h"

#include <gtest/gtest.h>

#include "haptics/link/link_terms.h"

namespace tandem::test {
namespace {

using haptics::impedancesAt;
using haptics::linkImpedance;
using haptics::LinkRegime;
using haptics::longestDelay;
using haptics::PacketAge;
using haptics::regimeAt;

constexpr double kPacketPeriod = 4e-3;  // s

PacketAge steady(double age) { return {age, age, age}; }

TEST(LinkDistance, HandsOnOnePartBearLessDelayThanPartsThatTouch) {
  EXPECT_LT(longestDelay(true), longestDelay(false));
  EXPECT_EQ(haptics::LinkParameters{}.longestDelay, longestDelay(true));
}

TEST(LinkDistance, ALinkBeginsStiffThenSoftThenApart) {
  for (const bool held : {true, false}) {
    const double longest = longestDelay(held);
    EXPECT_EQ(regimeAt(0.01, longest), LinkRegime::stiff);
    EXPECT_EQ(regimeAt(0.1, longest), LinkRegime::soft);
    EXPECT_EQ(regimeAt(longest, longest), LinkRegime::soft);
    EXPECT_EQ(regimeAt(longest + 1e-3, longest), LinkRegime::apart);
  }
  EXPECT_EQ(regimeAt(0.25, longestDelay(true)), LinkRegime::apart);
  EXPECT_EQ(regimeAt(0.25, longestDelay(false)), LinkRegime::soft);
}

TEST(LinkDistance, AChangeOfRegimeHasHysteresis) {
  const double longest = longestDelay(true);
  EXPECT_EQ(regimeAt(steady(0.055), LinkRegime::stiff, longest), LinkRegime::stiff);
  EXPECT_EQ(regimeAt(steady(0.055), LinkRegime::soft, longest), LinkRegime::soft);
  EXPECT_EQ(regimeAt(steady(0.045), LinkRegime::soft, longest), LinkRegime::stiff);
  EXPECT_EQ(regimeAt(steady(0.98 * longest), LinkRegime::soft, longest), LinkRegime::soft);
  EXPECT_EQ(regimeAt(steady(0.98 * longest), LinkRegime::apart, longest), LinkRegime::apart);
  EXPECT_EQ(regimeAt(steady(0.9 * longest), LinkRegime::apart, longest), LinkRegime::soft);
}

TEST(LinkDistance, OneLatePacketEndsALinkButDoesNotSoftenIt) {
  const double longest = longestDelay(true);
  EXPECT_EQ(regimeAt({0.1, 0.05, 0.05}, LinkRegime::stiff, longest), LinkRegime::stiff);
  EXPECT_EQ(regimeAt({longest + 1e-3, 0.05, 0.05}, LinkRegime::stiff, longest), LinkRegime::apart);
}

TEST(LinkDistance, LinksOfOneSiteStayWithinTheMassThatTheLeaderBears) {
  EXPECT_EQ(linkImpedance(27.0, 0.02, 1), 27.0);
  for (const int links : {1, 2, 7})
    for (const double delay : {0.02, 0.1, 0.3})
      EXPECT_LE(links * delay * linkImpedance(27.0, delay, links), haptics::kMaxLinkMass * (1.0 + 1e-12));
}

TEST(LinkDistance, ImpedanceFallsWithDelayAndWithTheNumberOfLinks) {
  const haptics::LinkParameters standard;
  EXPECT_EQ(impedancesAt(0.01, kPacketPeriod, 1).stiff, standard.impedance);
  EXPECT_EQ(impedancesAt(0.01, kPacketPeriod, 1).soft, standard.softImpedance);
  double before = standard.impedance;
  for (const double age : {0.05, 0.1, 0.14}) {
    const double stiff = impedancesAt(age, kPacketPeriod, 3).stiff;
    EXPECT_LT(stiff, before) << age;
    EXPECT_LT(impedancesAt(age, kPacketPeriod, 7).stiff, stiff) << age;
    before = stiff;
  }
  // Beyond the delay of hands only parts that touch are linked: softly, though the link may weigh more.
  EXPECT_EQ(impedancesAt(0.16, kPacketPeriod, 1).soft, 10.0);
  EXPECT_GT(impedancesAt(0.16, kPacketPeriod, 2).soft, impedancesAt(0.14, kPacketPeriod, 2).soft);
}

}  // namespace
}  // namespace tandem::test
