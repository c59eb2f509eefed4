#pragma once

// All data that the threads of a site exchange: haptic thread (HandLoop), network thread (ServerConnection),
// main thread (window or terminal). Latest values go through triple buffers, events through single-producer
// rings; no thread waits for another.
//
//   ServerConnection --events, time base--> HandLoop --output, intents--> ServerConnection
//   main ----settings, wish-------> HandLoop --view, poses------> main

#include <array>
#include <cstdint>

#include "haptics/base/spsc_ring.h"
#include "haptics/base/triple_buffer.h"
#include "haptics/link/link_terms.h"
#include "haptics/tick.h"
#include "sync/wire/ownership_messages.h"
#include "sync/wire/state_update.h"
#include "sync/wire/time.h"

namespace tandem::client {

/// Network to hand: changes by other sites, already checked against ownership.
struct NetworkEvent {
  enum class Kind : std::uint8_t {
    state,       // `state` of a part that another site owns, holding at session time `time`
    ownership,   // `record` is the part's newest one
    denied,      // the grab of `record.part` was refused
    lost,        // the connection is lost: open grabs get no answer
    link,        // a coordination link is to begin by the terms `link`
    unlink,      // the link `link.id` has ended
    simulators,  // `simulators` sites simulate the part of `link`
    place,       // the person wants `record.part`, free since the epoch of the record, at the record's pose
  };
  Kind kind = Kind::state;
  sync::Micros time = 0;
  sync::PartState state;
  sync::PartRecord record;
  haptics::LinkTerms link;
  bool ownedByPeer = false;  // link: this site is a co-holder of the peer's part
  int simulators = 1;
};

/// Hand to network: requests of the person.
struct HandIntent {
  enum class Kind : std::uint8_t {
    grab,     // to own the part, or to hold it together with its owner
    release,  // the part rests, or is left to its co-holders
    leave,    // to stop being a co-holder of the part
  };
  Kind kind = Kind::grab;
  PartId part = kNoPart;
  Epoch epoch = 0;     // release: of the ownership that ends
  Pose worldFromPart;  // release: where the part rests
  std::uint32_t lost =
      0;  // connections that the hand knew to be lost: an intent from before the last loss is void
};

/// Session time for the haptic thread: session = local + offset; parts are shown `playOutDelay` late.
struct TimeBase {
  sync::Micros offset = 0;
  sync::Micros playOutDelay = 0;
  SiteId self = kNoSite;
};

/// A hand's reading in a tick, and what its device got in all ticks so far.
struct HandRecord {
  haptics::DeviceSample device;
  std::uint32_t flagsSeen = 0;  // of the first hand: with those of the tick
  double maxForce = 0.0;        // N
  // Of the second hand, as TickOutput has them of the first:
  bool present = false;
  Pose worldFromProxy;
  std::array<haptics::Contact, haptics::kMaxContacts> contacts;
  int contactCount = 0;  // none are shown while it holds a part
};

/// The state of a person's hands after a tick, at local time `time`.
struct HandOutput {
  sync::Micros time = 0;
  std::array<HandRecord, haptics::kHands> hands;
  haptics::TickOutput tick;
  std::array<Epoch, haptics::kMaxOwnedParts> ownedEpoch{};  // beside tick.owned; 0: not to be published
  bool grabPending = false;
  std::uint32_t stalls = 0;     // pauses of the loop of over HandLoop::kStall
  bool poppedThrough = false;   // the proxy popped through a surface within the last second
  const char* fault = nullptr;  // why force is off: the broken condition, while kFlagFault is set
};

/// A control's part and its target value, m or rad; a new `count` is a new wish.
struct ControlWish {
  PartId part = kNoPart;
  double value = 0.0;
  std::uint32_t count = 0;
};

/// Settings of the person. `wish` is the part to grasp whatever the stylus touches; kNoPart: the touched one.
struct HandSettingsInput {
  std::array<haptics::TickParameters, haptics::kHands> parameters;  // of each hand
  PartId wish = kNoPart;
  bool graspButton = false;       // of the window or a script, besides the device's own button 0
  std::uint32_t faultResets = 0;  // counts up
  std::uint32_t reseats = 0;      // counts up: move the proxy back onto the device, without force meanwhile
  ControlWish control;
  std::array<haptics::Section, haptics::kMaxSections> sections;  // what they cut away is not felt
  std::size_t sectionCount = 0;
  bool believesPeers = false;  // what peers say in link packets is not limited: to check that tests notice
  bool lifted = false;         // parts are shown elsewhere than they are: no hand feels or takes one
};

/// One part's pose for the window and for traces.
struct ShownPose {
  PartId part = kNoPart;
  bool owned = false;     // simulated here; else played out, `time` lying the play-out delay before now
  sync::Micros time = 0;  // of the session
  Pose worldFromPart;     // the pose of the part at that time, as the hand has it
  Pose worldFromDrawn;    // the display pose now: extrapolated for parts that others move
};

inline constexpr std::size_t kEventRing = 1024;
inline constexpr std::size_t kIntentRing = 64;
inline constexpr std::size_t kShownRing = 16384;
inline constexpr std::size_t kForceRing = 4096;
inline constexpr std::size_t kLinkRing = 256;
inline constexpr std::size_t kDoubtRing = 64;

struct Exchange {
  haptics::SpscRing<NetworkEvent, kEventRing> events;  // network -> hand
  haptics::TripleBuffer<TimeBase> timeBase;            // network -> hand
  haptics::SpscRing<HandIntent, kIntentRing> intents;  // hand -> network
  haptics::TripleBuffer<HandOutput> output;            // hand -> network
  haptics::SpscRing<haptics::AddressedPacket, kLinkRing> linksIn,
      linksOut;                                  // packets of coordination links: network -> hand, and back
  haptics::SpscRing<SiteId, kDoubtRing> doubts;  // hand -> network: peers whose link packets lie
  haptics::TripleBuffer<HandSettingsInput> settings;  // main -> hand
  haptics::TripleBuffer<HandOutput> view;             // hand -> main
  haptics::SpscRing<ShownPose, kShownRing> shown;     // hand -> main: poses that changed
  haptics::SpscRing<float, kForceRing> forces;        // hand -> main: |force| each tick, N, for the plot
};

}  // namespace tandem::client
