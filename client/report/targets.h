#pragma once

// The targets that the project sets for its own speed and exactness, for the report's page and the bench.

namespace tandem::client::report {

/// The cost of a tick, us; 0 = no target.
struct TargetCost {
  double p50 = 0.0, p99 = 0.0;
};

inline constexpr TargetCost kGearTarget{2.0, 6.0};          // a point on a million triangles
inline constexpr TargetCost kGearBallTarget{8.0, 25.0};     // a ball of 1 mm on the same mesh
inline constexpr TargetCost kFineSphereTarget{0.0, 30.0};   // balls up to 3 mm over edges of 40 um
inline constexpr TargetCost kScanTarget{15.0, 40.0};        // a point on a rough scan of a million triangles
inline constexpr TargetCost kScanBallTarget{30.0, 60.0};    // a ball of 1 mm on it
inline constexpr TargetCost kTenMillionTarget{0.0, 20.0};   // a point on ten million triangles
inline constexpr TargetCost kStillPartsTarget{0.0, 5.0};    // ten thousand parts
inline constexpr TargetCost kMovingPartsTarget{0.0, 20.0};  // ten thousand parts, all moving
inline constexpr TargetCost kHeldPartTarget{250.0, 500.0};  // a held part among its neighbours
inline constexpr double kHeldPartLongest_ms = 1.0;          // its longest tick
inline constexpr double kForceStepTarget = 0.05;            // N a tick at 1 N/mm, beyond the exact change
inline constexpr double kForceStepLargest = 0.25;           // N a tick, in all, below 100 mm/s
inline constexpr double kBuildTarget_ms = 150.0;            // of a tree of a million triangles
inline constexpr double kRefitTarget_ms = 2.0;              // of a tree of a hundred thousand triangles

/// The coordination link at a delay, one way; 0 = no target.
struct LinkTarget {
  double delay_ms = 0.0;
  double wall = 0.0, handToHand = 0.0;  // N/m, at least
  double apart_mm = 0.0, load = 0.0;    // at most; the load over that without a network
};
inline constexpr LinkTarget kLinkTargets[] = {{10.0, 830.0, 270.0, 1.2, 1.1},
                                              {25.0, 830.0, 217.0, 2.0, 1.2},
                                              {50.0, 830.0, 164.0, 3.7, 1.4},
                                              {100.0, 830.0, 66.0, 10.0, 1.5},
                                              {250.0, 830.0, 0.0, 0.0, 1.0}};
inline constexpr double kLinkBytesTarget_k = 24.0;  // kB/s, each way

}  // namespace tandem::client::report
