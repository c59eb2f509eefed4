#pragma once

// Sessions of the protocol drawn from a seed: who takes which part when, and what goes wrong. Each seed
// switches each class of faults on or off ("swarm testing", Groce et al., ISSTA 2012): a session with all of
// them hides what a session with few shows.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "client/simulation/protocol_simulation.h"
#include "client/simulation/scenario.h"

namespace tandem::test {

enum class FaultClass : std::uint8_t {
  serverKilled,
  serverPaused,
  siteKilled,
  sitePaused,
  leaves,
  revokes,
  resets,
  diskFails,
  diskSlow,
  tornWrites,
  bitRot,
  lyingDisk,
  drift,
  driftBeyondBound,
  wallClock,
  observers,
  lateJoiners,
  oneWayCuts,
  blackouts,
  delayPerSite,
  delaySteps,
  bursts,
  slowUplinks,
  losses,
  duplicates,
  reordering,
  malformed,
  replayed,
  escalated,
  floods,
  forged,
};
inline constexpr std::size_t kFaultClasses = 31;
const char* toString(FaultClass faults);

using FaultMask = std::uint32_t;
constexpr FaultMask only(FaultClass faults) { return FaultMask{1} << static_cast<unsigned>(faults); }
inline constexpr FaultMask kAnyFaults = (FaultMask{1} << kFaultClasses) - 1;

/// A session of a minute, the last third of it calm. Of the classes that the seed switches on, those of the
/// mask happen; `every`: all of the mask do.
client::Scenario drawProtocolSession(std::uint64_t seed, FaultMask mask = kAnyFaults, bool every = false);

/// A scenario that breaks the same rule first with this seed, and of which no fault and no step of a script
/// can be left out. Sites that no fault names are left out likewise.
client::Scenario minimised(client::ProtocolSimulation& simulation, const client::Scenario& scenario,
                           std::uint64_t seed);

/// The scene of all of these sessions.
const assets::Scene& protocolScene();

}  // namespace tandem::test
