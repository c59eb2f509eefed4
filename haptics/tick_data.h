#pragma once

// What TickState holds. For tick.cpp, tick_state.cpp and the tests that read it.

#include <array>
#include <memory>

#include "haptics/base/fault.h"
#include "haptics/contact/part_contact.h"
#include "haptics/fields/force_fields.h"
#include "haptics/foreign_limit.h"
#include "haptics/grasp/controls.h"
#include "haptics/grasp/hand.h"
#include "haptics/grasp/held_part.h"
#include "haptics/moved_parts.h"
#include "haptics/scene/contact_world.h"
#include "haptics/surface/held_magnets.h"
#include "haptics/surface/held_surfaces.h"
#include "haptics/tick.h"
#include "haptics/tool/tool.h"

namespace tandem::haptics {

struct TickState::Data {
  explicit Data(const ContactScene& contactScene);

  /// Whether a part stands still here because it is still being taken (part_taking.h).
  bool isTaking(PartId part) const { return partContact != nullptr && partContact->isTaking(part); }
  void modelsChanged() {
    if (partContact != nullptr) partContact->modelsChanged();
  }

  const ContactScene::Data* scene;
  ContactWorld world;
  FaultLatch fault;
  HeldParts held;
  std::unique_ptr<PartContact> partContact;  // null: the scene has no part models
  Layers layers;
  MovedParts moved;
  ForeignLimit foreign;
  Tool tool;  // of the first hand
  std::array<Hand, kHands> hands{Hand(true), Hand(false)};
  ForceFields fields;                             // on the first hand's tip
  std::array<ForceFields, kHands> fieldsOnPart;   // on what a hand holds, at its centre of mass
  std::array<double, kHands> fieldShare{};        // 0..1, of fieldsOnPart; the rest acts at the tip
  std::array<HeldSurfaces, kHands> heldSurfaces;  // under what each hand holds
  std::array<HeldMagnets, kHands> heldMagnets;    // near what each hand holds
  std::array<Wrench, kHands> throughPart;  // of these surfaces on each hand, of this tick, before limits
  bool lifted = false;                     // the tool, in the last tick
  double liftedShare = 0.0;  // 0..1, of the fields on the tip, which a lifted tool does not feel
  int bridging = 0;          // ticks in which the proxy may still find its place after sections have moved
  Wrench fieldWrench;        // of this tick, before limits
  double time = 0.0;         // s, session clock, of the last tick
};

}  // namespace tandem::haptics
