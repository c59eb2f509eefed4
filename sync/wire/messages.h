#pragma once

// What server and sites say to each other, as plain structs. sync/wire/wire.h turns them into bytes and back;
// sync/WIRE.md documents those bytes.
//
// 1. Control messages travel in order and without loss; state datagrams may be lost, doubled or reordered.
// 2. A decoded message is already checked: enums in range, numbers finite, quaternions unit, strings within
//    limits. It has not been checked against the session (part ids, roles, epochs): that is the receiver's
//    duty.

#include <array>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "assets/base/ids.h"
#include "assets/base/pose.h"
#include "sync/wire/time.h"

namespace tandem::sync {

inline constexpr std::uint16_t kProtocolVersion = 4;  // of a connection
inline constexpr std::uint8_t kStateVersion = 2;      // of a datagram by itself, on a wire or in a recording
inline constexpr std::size_t kMaxNameLength = 64;     // bytes, UTF-8
inline constexpr std::size_t kMaxTextLength = 512;    // bytes, UTF-8: reasons
inline constexpr std::size_t kMaxCredentialLength = 512;  // bytes, ASCII
inline constexpr std::size_t kMaxStateBytes = 1200;       // a whole datagram
inline constexpr std::size_t kMaxChunkBytes = 64 * 1024;
inline constexpr std::size_t kMaxControlBytes =
    (1 << 20) + (1 << 16);  // a Welcome with kMaxParts records fits
inline constexpr std::size_t kMaxSites = 64;
inline constexpr std::size_t kMaxStateParts = 255;           // in one StateUpdate; fewer fit as a rule
inline constexpr Micros kMaxMicros = (Micros{1} << 55) - 1;  // +- 1141 years: sums of a few never overflow

enum class Role : std::uint8_t { observer = 0, participant = 1, instructor = 2 };
const char* toString(Role role);

/// Chosen by the site, different for each of its requests. A site that starts again starts from another
/// number, drawn at random, because the server remembers earlier answers (S7).
using RequestId = std::uint32_t;

/// A site as the others see it.
struct SiteInfo {
  SiteId site = kNoSite;
  Role role = Role::observer;
  std::string name;
  std::array<std::uint8_t, 3> colour{200, 200, 200};  // sRGB
  bool connected = true;
  friend bool operator==(const SiteInfo&, const SiteInfo&) = default;
};

/// Who owns a part, and where it is if it does not move.
struct PartRecord {
  PartId part = kNoPart;
  SiteId owner = kNoSite;
  Epoch epoch = 0;
  Pose worldFromPart;
};

/// The sites that simulate a part beside its owner, because their hands or parts of theirs touch it. Newer
/// where (epoch, version) is larger. With its owner they are n sites, each with a replica of 1/n of its mass.
struct MemberRecord {
  PartId part = kNoPart;
  Epoch epoch = 0;
  std::uint32_t version = 0;
  std::vector<SiteId> sites;  // who has been engaged for longest first; the owner is not among them
  friend bool operator==(const MemberRecord&, const MemberRecord&) = default;
};

// ---- control, site to server ----

/// First message of a connection. `credential` is the token of a join link, or the resume ticket of an
/// earlier Welcome.
struct Hello {
  std::uint16_t protocolVersion = kProtocolVersion;
  bool resume = false;
  std::string credential;
  std::string name;
  std::array<std::uint8_t, 3> colour{200, 200, 200};
};
/// Asks for bytes of the scene package from `offset` on; the server sends SceneChunks until the end or a new
/// request.
struct SceneRequest {
  std::uint64_t offset = 0;
};
/// The scene is loaded: the site wants state from now on.
struct Ready {};
struct Grab {
  RequestId request = 0;
  PartId part = kNoPart;
};
/// The site ends its ownership; the part rests at this pose.
struct Release {
  RequestId request = 0;
  PartId part = kNoPart;
  Epoch epoch = 0;
  Pose worldFromPart;
};
/// After a resume: the site still holds this part, granted to it in this epoch. Answered by a GrabReply.
struct Reclaim {
  RequestId request = 0;
  PartId part = kNoPart;
  Epoch epoch = 0;
  Pose worldFromPart;
};
/// An instructor takes a part away from its owner. Answered by a CommandReply.
struct Revoke {
  RequestId request = 0;
  PartId part = kNoPart;
};
/// An instructor puts every part that nobody owns back to its pose in the scene. Answered by a CommandReply.
struct ResetParts {
  RequestId request = 0;
};
/// The site leaves for good; its parts are free at once.
struct Goodbye {};
/// The site simulates a part beside the site that owns it. Answered by an EngageReply.
struct Engage {
  RequestId request = 0;
  PartId part = kNoPart;
};
/// The site no longer simulates the part. Answered by an EngageReply.
struct Disengage {
  RequestId request = 0;
  PartId part = kNoPart;
};

// ---- control, server to site ----

/// The answer to a good Hello.
struct Welcome {
  SiteId site = kNoSite;
  Role role = Role::observer;
  std::string resumeTicket;                  // credential for a later Hello with resume = true
  std::array<std::uint8_t, 32> sceneHash{};  // assets::ContentHash of the scene package
  std::uint64_t sceneBytes = 0;
  Micros sessionTime = 0;         // when this was sent
  Micros lease = 0;               // length of a lease
  std::vector<SiteInfo> sites;    // everybody, this site included
  std::vector<PartRecord> parts;  // those that were ever granted or moved
};
enum class Refusal : std::uint8_t {
  protocolVersion,
  badCredential,
  expired,
  alreadyUsed,
  sessionFull,
  unexpectedMessage,
  malformed
};
const char* toString(Refusal refusal);
/// The last message before the server closes a connection.
struct Refused {
  Refusal refusal = Refusal::malformed;
  std::string reason;  // one line for a person
};
struct SceneChunk {
  std::uint64_t offset = 0;
  std::vector<std::uint8_t> bytes;  // 1..kMaxChunkBytes
};
/// A site joined, or its record changed (connected, name, role).
struct SiteChanged {
  SiteInfo site;
};
struct SiteLeft {
  SiteId site = kNoSite;
};
enum class Denial : std::uint8_t {
  none,  // granted
  ownedByOther,
  roleForbids,
  notMovable,
  unknownPart,
  recovering,  // a restarted server waits for earlier owners to come back (S8)
  stale,       // a Reclaim or Release of an epoch that is over
  notOwned,    // an Engage in a part that nobody or the site itself owns: it is to be grabbed
};
const char* toString(Denial denial);
/// The answer to Grab or Reclaim, repeated unchanged if the request is repeated (S7).
struct GrabReply {
  RequestId request = 0;
  Denial denial = Denial::none;
  PartRecord part;  // as it is now: the owner is the asking site if granted
};
struct ReleaseReply {
  RequestId request = 0;
  Denial denial = Denial::none;  // none: the pose is kept for good
  PartRecord part;
};
struct CommandReply {
  RequestId request = 0;
  bool done = false;
  std::string reason;
};
/// Published to every site in the same order for each part: a new epoch, or the end of an ownership (owner =
/// kNoSite). The pose is the last state of what was before: nobody shows an older state after this (S6).
struct OwnershipChanged {
  PartRecord part;
};

/// The answer to Engage or Disengage.
struct EngageReply {
  RequestId request = 0;
  Denial denial = Denial::none;
  MemberRecord members;  // as they are now
};
/// Published to every site in the same order for each part, behind the OwnershipChanged that goes with it.
struct MembersChanged {
  MemberRecord members;
};

using ControlMessage =
    std::variant<Hello, SceneRequest, Ready, Grab, Release, Reclaim, Revoke, ResetParts, Goodbye, Welcome,
                 Refused, SceneChunk, SiteChanged, SiteLeft, GrabReply, ReleaseReply, CommandReply,
                 OwnershipChanged, Engage, Disengage, EngageReply, MembersChanged>;

// ---- state datagrams ----

/// One part's state at one instant, by its owner.
struct PartState {
  PartId part = kNoPart;
  Epoch epoch = 0;
  std::uint32_t sequence = 0;  // grows within (part, epoch)
  Pose worldFromPart;
  Twist twist;
};

/// Where a site's hand and eyes are, for the others to see.
struct Presence {
  SiteId site = kNoSite;  // filled in by the server on the way out
  Pose worldFromTool;     // proxy of the stylus
  Pose worldFromCamera;
  glm::dvec3 force{0.0, 0.0, 0.0};  // N on the hand
  PartId touched = kNoPart;
};

/// The states of one site at one instant. Site to server, and relayed by the server to each other site.
struct StateUpdate {
  SiteId site = kNoSite;       // whose states; filled in by the server
  std::uint32_t sequence = 0;  // of the datagrams from this sender to this receiver: gaps are losses
  Micros time = 0;             // session time at which these states held, by the owning site's estimate
  Presence presence;
  bool newPresence = true;       // false: not in this datagram; `presence` is the newest known
  bool presenceKnown = true;     // false: none has arrived yet
  std::vector<PartState> parts;  // what fits into kMaxStateBytes; a part in it appears once
};

/// Site to server, a few times a second: clock, round trip, lease renewal.
struct Ping {
  std::uint32_t sequence = 0;
  Micros siteTime = 0;  // local time when sent
};
struct Pong {
  std::uint32_t sequence = 0;
  Micros siteTime = 0;    // copied from the Ping
  Micros serverTime = 0;  // session time when the Pong was sent
  std::uint32_t received =
      0;  // state datagrams received from this site so far: the site computes its uplink loss
};

/// The terms of a coordination link, which its owner sets: multiples of the quanta below.
struct LineTerms {
  double impedance = 27.0, softImpedance = 14.0;  // N s/m, of the regimes stiff and soft
  double packetPeriod = 4e-3;                     // s, between packets of either end
  friend bool operator==(const LineTerms&, const LineTerms&) = default;
};
inline constexpr double kImpedanceQuantum = 0.125;       // N s/m
inline constexpr double kPacketPeriodQuantum = 0.25e-3;  // s

/// One end of a coordination link to the other, by way of the server. Integrals and clocks are sent by their
/// low bits; LinkReceiver (link_stream.h) completes them.
struct LinkUpdate {
  SiteId peer = kNoSite;  // to the server: the addressee; from the server: the sender
  PartId part = kNoPart;
  std::uint32_t epoch = 0;  // of the link, chosen by the owner; larger than any of it before
  std::uint16_t sequence = 0;
  std::uint32_t time = 0;               // us of session time, 24 bits
  std::array<std::uint32_t, 6> wave{};  // steps of kWaveQuantum, 24 bits each
  std::uint32_t energy = 0;             // steps of kEnergyQuantum
  std::uint8_t fade = 0;                // 255ths
  bool on = false, asks = false;
  std::uint8_t regime = 0;  // 0 stiff, 1 soft, 2 apart
  bool posed = false;       // whether the fields that follow are present
  Pose worldFromDrawn;
  Twist twist;
  LineTerms terms;
};
inline constexpr double kWaveQuantum = 1e-5;    // sqrt(W) s
inline constexpr double kEnergyQuantum = 1e-7;  // J

/// Which of the StateUpdates that were marked to be kept the receiver has (state_stream.h).
struct StateAck {
  static constexpr std::size_t kMost = 16;
  std::uint8_t count = 0;
  std::array<std::uint32_t, kMost> sequences{};  // the first `count`
};

using StateMessage = std::variant<StateUpdate, Ping, Pong, LinkUpdate, StateAck>;

}  // namespace tandem::sync
