#pragma once

// Input and output of a haptic tick: settings, the readings of the hands, parts that others move, commands,
// and the wrench on each hand. Plain data, SI units, world frame. Every stage of the tick may include this;
// tick.h is its entry.

#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "assets/base/ids.h"
#include "assets/base/pose.h"
#include "haptics/base/contact_effort.h"
#include "haptics/base/device.h"
#include "haptics/base/link_packet.h"
#include "haptics/base/section.h"

namespace tandem::haptics {

inline constexpr int kMaxContacts = 3;    // simultaneous constraints of the proxy
inline constexpr int kMaxOwnedParts = 8;  // that one tick simulates at once: held, or settling after release
inline constexpr int kMaxPartCommands = 8;
inline constexpr int kMaxPushed = 4;
inline constexpr int kHands = 2;  // of one person, each on a device of its own

/// Settings of one hand. Changing them between ticks is allowed; the force is still slew-limited.
struct TickParameters {
  double dt = 1e-3;                   // s
  double toolRadius = 0.0;            // m; 0 = point tool
  double stiffness = 800.0;           // N/m, proxy coupling where the material states none
  double damping = 1.0;               // N·s/m
  double graspStiffness = 800.0;      // N/m, virtual coupling to the held part
  double graspDamping = 4.0;          // N·s/m
  double graspRotStiffness = 4.0;     // N·m/rad
  double graspRotDamping = 0.02;      // N·m·s/rad
  double forceLimit = 3.3;            // N
  double torqueLimit = 0.2;           // N·m
  double fieldDampingLimit = 10.0;    // N·s/m, of all damping force fields together
  double slewLimit = 400.0;           // N/s: how fast a change grows that the hand did not make
  double torqueSlewLimit = 24.0;      // N·m/s: the same for the torque
  double foreignSlewLimit = 0.0;      // N/s: how fast parts that others move may change the force; 0 = any
  double deviceSlewLimit = 0.0;       // N/s: what the device can follow, whatever the cause; 0 = any
  double slipChange = 0.045;          // N a tick, of spring and damper each, as a held part slips; 0 = any
  double stiffnessLimit = 0.0;        // N/m, of any contact, whatever its material states; 0 = any
  double dampingLimit = 0.0;          // N·s/m, of a surface, as damping or viscosity; 0 = any
  double maxDeviceSpeed = 0.0;        // m/s: a reading that would need more is a jump; 0 = any
  double staleAfter = 0.05;           // s that a reading's time stamp may stand still; 0 = for ever
  bool passivity = false;             // passivity_controller.h
  double deviceDamping = 0.0;         // N·s/m of the device that it may count on
  double fadeTime = 0.3;              // s, over which the force of a coupling that ends fades away
  double gain = 1.0;                  // 0..1, of the wrench sent
  bool zeroForce = false;             // the user's emergency key
  glm::dvec3 gravity{0.0, 0.0, 0.0};  // m/s^2, felt as the weight of the held part
  ContactEffort effort;               // of parts that move here
};

/// A part that others move: its pose and velocity for this tick.
struct PartMotion {
  PartId part = kNoPart;
  Pose worldFromPart;
  Twist twist;
  bool byThisPerson = false;  // by the other hand: no limit holds for it
};

/// What the owner's side decides about parts; carried out in order at the start of a tick.
struct PartCommand {
  enum class Kind : std::uint8_t {
    own,  // this tick simulates the part from now on, from `pose`; held_part.h: which ones move by themselves
    grasp,    // couple the device to an owned part, at the relative pose they have now: no force at first
    letGo,    // end the coupling; the force fades; the part settles and stays where it is left
    disown,   // others move the part from now on; a coupling to it ends as in letGo
    setPose,  // put a part that is not owned somewhere (state restored, reset)
  };
  Kind kind = Kind::own;
  PartId part = kNoPart;
  Pose pose;
  std::uint8_t hand = 0;  // of grasp and letGo: which of TickInput::hands
  Twist twist{};          // of own: with which the part moves
};

/// What one hand of a person brings to a tick. The first hand's bare tool is part of the tick; what the bare
/// tool of the second hand feels comes from a TickState of its own.
struct HandInput {
  DeviceSample device;
  // Settings of the second hand, with the same dt. Null stands for those given to tick(), which are the first
  // hand's.
  const TickParameters* parameters = nullptr;
  // Wrench of the second hand's bare tool. It counts while the hand holds nothing, and fades when the hand
  // takes a part.
  Wrench tool{};
};

struct TickInput {
  std::array<HandInput, kHands> hands;
  std::span<const PartMotion> moved;      // at most one entry a part
  std::span<const PartCommand> commands;  // at most kMaxPartCommands
  std::span<const Section> sections{};    // world; what they cut away is not felt; at most kMaxSections
  // The session's clock in s, for links and for fields that change with time. Where it is not finite, the
  // time of the reading counts.
  double sessionTime = std::numeric_limits<double>::quiet_NaN();
  int handCount = 1;  // 1: the first hand is alone
  // The bare tool touches nothing: the scene is drawn otherwise than it is. What it felt fades; once this
  // ends, the tool is where the device is, and passes through what it is inside of until it has left it.
  bool lifted = false;
};

/// One constraint that the proxy rests on.
struct Contact {
  PartId part = kNoPart;
  glm::dvec3 point{0.0, 0.0, 0.0};   // world
  glm::dvec3 normal{0.0, 0.0, 0.0};  // world, unit, away from the part
  double force = 0.0;                // N along the normal, before limits
};

enum TickFlag : std::uint32_t {
  kFlagInvalidSample = 1u << 0,  // zero force this tick
  kFlagForceLimited = 1u << 1,
  kFlagSlewLimited = 1u << 2,
  kFlagOverflow = 1u << 3,  // something did not fit a fixed capacity and was dropped
  kFlagFault = 1u << 4,     // a broken invariant in the tick: force ramps to zero until resetFault()
  kFlagSqueezed = 1u << 5,  // the proxy could not stay outside everything
  kFlagHeldWithoutContact = 1u << 6,  // the held part has no contact model: it passes through others
  kFlagProxyReset = 1u << 7,          // the proxy was put back onto the device (start, recovery)
  kFlagStaleSample = 1u << 8,         // zero force: the reading's time stamp stands still
  kFlagSampleJump = 1u << 9,          // zero force: no hand moves this fast
  kFlagPassivity = 1u << 10,          // the passivity controller damps
  kFlagPopThrough = 1u << 11,         // a surface gave way: it is passed through until it has been left
  kFlagFieldLimited = 1u << 12,       // a force field met its own maximum where that makes it inexact
  kFlagLessEffort = 1u << 13,         // held parts are given less effort than set, for ticks took too long
  kFlagInside = 1u << 14,  // a part is not felt: the tool is inside it, and passes through until it leaves
};

/// The coordination links of a part to other sites' replicas of it, as one.
inline constexpr double kLinkSilence = 0.3;  // s, after which a peer counts as not heard
struct LinkReport {
  int count = 0;                          // includes links whose force decays; 0: the part is not linked
  int live = 0;                           // of them, not about to end; the states below are theirs, if any
  LinkRegime regime = LinkRegime::stiff;  // the worst of them
  double fade = 0.0;                      // 0..1: the least fade-in of them
  bool fresh = true;                      // false: the play-out of one is starved, and its force decays
  double delay = 0.0;                     // s, the longest of the play-out delays
  bool heard = true;                      // a packet of each has arrived within kLinkSilence
  double share = 1.0;                     // of the part's mass, that the replica here goes to
  Wrench pull;                            // on the replica about its centre of mass, in this tick
  Wrench outagePull;                      // the same, of the outage spring (outage_spring.h)
  double work = 0.0, borrowed = 0.0;      // J, on the replica; spent beyond what had arrived
};

/// A part simulated in this tick.
struct OwnedPart {
  PartId part = kNoPart;
  Pose worldFromPart;
  Twist twist;
  bool held = false;    // by either hand
  bool atRest = false;  // nothing moves it: its owner may release it
  LinkReport links;
};

/// What one hand gets.
struct HandFeedback {
  Wrench toHand;            // at the device's tip, limited: what the device gets
  PartId held = kNoPart;    // the part that it holds
  Pose worldFromGrip;       // where it grips that part; its device if it holds none
  std::uint32_t flags = 0;  // those of its reading and limits
};

struct TickOutput {
  std::array<HandFeedback, kHands> hands;
  Pose worldFromProxy;  // display pose of the first hand's tool: on the surface
  std::array<Contact, kMaxContacts> contacts;
  int contactCount = 0;
  PartId touched = kNoPart;  // the part under the tool: first contact, else the nearest to be grasped
  std::array<OwnedPart, kMaxOwnedParts> owned;
  int ownedCount = 0;
  // Parts that could yield but are not simulated here, while the hand or a simulated part presses on them
  // or is joined to them; once owned they do.
  std::array<PartId, kMaxPushed> pushed;
  int pushedCount = 0;
  double sourcePower = 0.0;  // W, what fields gave the hand since the last tick, of the force sent
  std::uint32_t flags = 0;   // those of the tick and of the first hand

  /// The part as this tick simulated it; null if it did not.
  const OwnedPart* simulated(PartId part) const {
    for (int i = 0; i < ownedCount; ++i)
      if (owned[static_cast<std::size_t>(i)].part == part) return &owned[static_cast<std::size_t>(i)];
    return nullptr;
  }
};

}  // namespace tandem::haptics
