#pragma once

// What the project asks of its own speed, for the report's page and the bench.

namespace tandem::client::report {

/// Of a tick, us; 0 = not asked.
struct AskedCost {
  double p50 = 0.0, p99 = 0.0;
};

inline constexpr AskedCost kAskedOfGear{2.0, 6.0};          // a point, a million triangles
inline constexpr AskedCost kAskedOfGearBall{8.0, 25.0};     // a ball of 1 mm, the same
inline constexpr AskedCost kAskedOfFineSphere{0.0, 30.0};   // balls up to 3 mm over edges of 40 um
inline constexpr AskedCost kAskedOfStillParts{0.0, 5.0};    // ten thousand
inline constexpr AskedCost kAskedOfMovingParts{0.0, 20.0};  // all of ten thousand
inline constexpr AskedCost kAskedOfHeldPart{250.0, 500.0};  // among its neighbours
inline constexpr double kAskedOfHeldPartAtMost_ms = 1.0;    // the longest tick of it
inline constexpr double kAskedForceStep = 0.05;             // N a tick at 1 N/mm, beyond the exact one
inline constexpr double kAskedBuild_ms = 150.0;             // a tree of a million triangles
inline constexpr double kAskedRefit_ms = 2.0;               // a tree of a hundred thousand

/// Of a link at a delay, one way; 0 = not asked.
struct AskedOfLink {
  double delay_ms = 0.0;
  double wall = 0.0, handToHand = 0.0;  // N/m, at least
  double apart_mm = 0.0, load = 0.0;    // at most; the load over that without a network
};
inline constexpr AskedOfLink kAskedOfLink[] = {{10.0, 830.0, 270.0, 1.2, 1.1},
                                               {25.0, 830.0, 217.0, 2.0, 1.2},
                                               {50.0, 830.0, 164.0, 3.7, 1.4},
                                               {100.0, 830.0, 66.0, 10.0, 1.5},
                                               {250.0, 830.0, 0.0, 0.0, 1.0}};
inline constexpr double kAskedLinkBytes_k = 24.0;  // kB/s, each way

}  // namespace tandem::client::report
