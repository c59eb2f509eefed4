#pragma once

// Who owns a part and who simulates it beside its owner: what a site requests, and what the server answers
// and publishes. The rules are in sync/replica/README.md.

#include <cstdint>
#include <vector>

#include "assets/base/ids.h"
#include "assets/base/pose.h"

namespace tandem::sync {

/// Chosen by the site, different for each of its requests. A site that starts again starts from another
/// number, drawn at random, because the server remembers earlier answers (S7).
using RequestId = std::uint32_t;

/// Who owns a part, and where it is if it does not move.
struct PartRecord {
  PartId part = kNoPart;
  SiteId owner = kNoSite;
  Epoch epoch = 0;
  Pose worldFromPart;
};

/// The co-holders of a part: the sites that simulate it beside its owner, because their hands or parts of
/// theirs touch it. A record is newer where (epoch, version) is larger. The owner and its co-holders are n
/// sites, each with a replica of 1/n of the part's mass.
struct CoHolderRecord {
  PartId part = kNoPart;
  Epoch epoch = 0;
  std::uint32_t version = 0;
  std::vector<SiteId> sites;  // the longest co-holder first; the owner is not among them
  friend bool operator==(const CoHolderRecord&, const CoHolderRecord&) = default;
};

// ---- site to server ----

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
/// The site becomes a co-holder of a part that another site owns. Answered by an EngageReply.
struct Engage {
  RequestId request = 0;
  PartId part = kNoPart;
};
/// The site is a co-holder of the part no longer. Answered by an EngageReply.
struct Disengage {
  RequestId request = 0;
  PartId part = kNoPart;
};

// ---- server to site ----

enum class Denial : std::uint8_t {
  none,  // granted
  ownedByOther,
  roleForbids,
  notMovable,
  unknownPart,
  recovering,  // a restarted server waits for earlier owners to come back (S8)
  stale,       // a Reclaim or Release of an epoch that is over
  notOwned,    // an Engage for a part that no other site owns: it is to be grabbed
  crowded,     // an Engage for a part that has kMaxCoHolders already
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
/// Published to every site in the same order for each part: a new epoch, or the end of an ownership (owner =
/// kNoSite). The pose is the last state of the epoch before: no site displays an older state after this (S6).
struct OwnershipChanged {
  PartRecord part;
};

/// The answer to Engage or Disengage.
struct EngageReply {
  RequestId request = 0;
  Denial denial = Denial::none;
  CoHolderRecord coHolders;  // as they are now
};
/// Published to every site in the same order for each part, behind the OwnershipChanged that goes with it.
struct MembersChanged {
  CoHolderRecord coHolders;
};

}  // namespace tandem::sync
