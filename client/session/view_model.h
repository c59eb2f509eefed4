#pragma once

// What a site shows a person, as plain data: filled by join and replay, drawn by the viewer, which changes
// nothing but what it returns as ViewActions. Main thread only.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "assets/document/entry.h"
#include "assets/scene/scene.h"
#include "client/findings/measure_watch.h"
#include "client/review/clash_view.h"
#include "client/session/document_view.h"
#include "client/session/presenting_view.h"
#include "client/session/way_out_view.h"
#include "haptics/tick.h"
#include "sync/wire/participant_messages.h"
#include "sync/wire/state_update.h"

namespace tandem::client {

/// What the held part is nearest to, as measured a moment ago (clearance_watch.h).
struct NearestView {
  PartId part = kNoPart;                                     // kNoPart: nothing is held, or not known yet
  double clearance = 0.0;                                    // m; below 0: as deep as they overlap
  glm::dvec3 onHeld{0.0, 0.0, 0.0}, onOther{0.0, 0.0, 0.0};  // m, world: that far apart
};

/// A hand's tool, as it is drawn.
struct ToolView {
  bool valid = false;  // its last reading was good
  Pose worldFromDevice, worldFromProxy;
  double toolRadius = 0.0;          // m
  glm::dvec3 force{0.0, 0.0, 0.0};  // N on the hand
  std::array<haptics::Contact, haptics::kMaxContacts> contacts;
  int contactCount = 0;
};

/// The same person's other hand.
struct SecondHandView : ToolView {
  std::string deviceName;  // empty: there is none
  PartId held = kNoPart;
  double mostForce = 0.0;       // N, so far
  std::uint32_t flagsSeen = 0;  // of all ticks so far
};

/// The hand at this site, from the haptic loop.
struct HandView : ToolView {
  bool present = false;  // a device is open
  std::string deviceName;
  PartId touched = kNoPart, held = kNoPart;
  haptics::LinkReport links;  // of the held part to other sites
  NearestView nearest;
  bool grabPending = false;     // asked for, not answered yet
  std::uint32_t flags = 0;      // haptics::TickFlag
  std::uint32_t flagsSeen = 0;  // of all ticks so far
  std::uint32_t stalls = 0;     // pauses of its loop, during which the hand was without force
  std::string fault;            // why force is off; empty without a fault
  double stiffest = 0.0;        // N/m, largest stiffness of a contact on this device; 0 = any
  SecondHandView second;
};

/// The 1 kHz loop.
struct LoopView {
  double compute_us_p50 = 0.0, compute_us_p99 = 0.0, compute_us_max = 0.0;
  std::uint64_t ticks = 0, late = 0;
  bool realtime = false;
  double refined = 1.0;  // share of the contact models that are refined; the others cost the ticks more
  std::vector<float> recentCompute_us;  // oldest first
  std::vector<float> recentForce_n;     // oldest first
};

/// The connection.
struct ConnectionView {
  bool connected = false;
  std::string status;         // in words: "connected", "reconnecting (2 s)", "no network (local scene)"
  double roundTrip_ms = 0.0;  // 0: nothing is measured yet
  double lossUp = 0.0, lossDown = 0.0;  // share of datagrams
  double playOut_ms = 0.0;
  double sentKbit_s = 0.0, receivedKbit_s = 0.0;
  bool stateOverUdp = true;
  std::string voiceUrl;  // where people talk; empty: nowhere that the server names
};

/// A participant of the session.
struct SiteView {
  sync::SiteInfo info;
  bool self = false;
  bool seen = false;                // presence has arrived
  sync::Presence presence;          // smoothed for display
  std::vector<SiteId> doubtedBy{};  // who does not believe its motion
};

/// A line for the person: a denied grab and why, a new participant, a warning.
struct Notice {
  enum class Level : std::uint8_t { info, warning, error };
  Level level = Level::info;
  double age = 0.0;  // s
  std::string text;
  std::uint64_t number = 0;  // of this site's notices, from 1
};

/// What the person set; the viewer edits a copy and returns it.
struct HandSettings {
  double forceLimit = 3.3;  // N
  double gain = 1.0;        // 0..1
  bool zeroForce = false;
  double stiffness = 800.0;  // N/m
};

struct ViewModel {
  const assets::Scene* scene = nullptr;        // never changes while a viewer lives
  std::vector<Pose> worldFromPart;             // one a part
  std::vector<SiteId> owner;                   // one a part
  std::vector<std::vector<SiteId>> coHolders;  // by part, the longest co-holder first
  std::vector<SiteView> sites;
  HandView hand;
  LoopView loop;
  ConnectionView connection;
  ClashSearchView clashes;
  WayOutView wayOut;
  MeasureView measure;                           // of the marks that the last frame returned
  const document::Document* document = nullptr;  // the session's; null: there is none
  DocumentStanding documentStanding;
  PresentingView presenting;
  std::vector<ChatLine> chat;   // oldest first, at most kMaxSaidLines
  std::vector<Notice> notices;  // newest last
  HandSettings settings;
  sync::Role role = sync::Role::observer;
  // replay only
  bool replay = false;
  double time = 0.0, duration = 0.0;  // s
  bool playing = false;
  double speed = 1.0;  // 1 = as it happened
};

inline const SiteView* selfSite(const ViewModel& model) {
  for (const SiteView& view : model.sites)
    if (view.self) return &view;
  return nullptr;
}

/// Position and aim of a camera; looks along -z of its frame, +y up.
struct Camera {
  glm::dvec3 target{0.0, 0.0, 0.0};
  double distance = 1.0;          // m, from the target
  double yaw = 0.7, pitch = 0.5;  // rad
  double fieldOfView = 0.7;       // rad, vertical
};
Pose worldFromCamera(const Camera& camera);

/// What the person did in this frame.
struct ViewActions {
  bool quit = false;
  HandSettings settings;
  bool settingsChanged = false;
  // the virtual stylus, where no device is: world pose that mouse and keyboard ask for
  bool stylusMoved = false;
  Pose worldFromStylus;
  bool lifted = false;          // parts are drawn elsewhere than they are: no hand feels or takes one
  bool grasp = false;           // the grasp button is down (mouse) or latched (keyboard)
  PartId graspedAt = kNoPart;   // under the cursor when `grasp` began: to be taken; kNoPart: the touched one
  PartId setControl = kNoPart;  // the part of a control that shall have `controlValue`
  double controlValue = 0.0;    // m or rad
  PartId revoke = kNoPart;      // instructor
  bool resetParts = false;      // instructor
  bool resetFault = false;
  std::optional<ClashQuestion> findClashes;  // look for them now
  bool stopClashes = false;
  PartId findWayOut = kNoPart;  // look for this part's way out of its assembly
  bool clearWayOut = false;     // stop that, or forget it
  std::vector<DocumentWish> documentWishes;
  std::vector<document::Anchor> marks;  // to be measured, at most two
  Pose worldFromCamera;
  std::vector<document::SectionPlane> sections;  // how the scene is cut open
  sync::Presentation shown;                      // what the others may see of this person
  std::vector<sync::Say> says;
  // replay only
  bool seek = false;
  double seekTo = 0.0;  // s
  bool togglePlay = false;
  double setSpeed = 0.0;  // 0 = unchanged
};

}  // namespace tandem::client
