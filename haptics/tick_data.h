#pragma once

// What TickState holds. For tick.cpp, the report and the tests that read it.

#include <memory>

#include "haptics/base/fault.h"
#include "haptics/body/fade.h"
#include "haptics/contact/part_contact.h"
#include "haptics/fields/force_fields.h"
#include "haptics/grasp/controls.h"
#include "haptics/grasp/held_part.h"
#include "haptics/grasp/second_hand.h"
#include "haptics/safety/output_limits.h"
#include "haptics/safety/resting_reading.h"
#include "haptics/safety/sample_guard.h"
#include "haptics/scene/contact_world.h"
#include "haptics/scene/moved_parts.h"
#include "haptics/tick.h"
#include "haptics/tool/tool.h"

namespace tandem::haptics {

struct TickState::Data {
  explicit Data(const ContactScene& contactScene);

  const ContactScene::Data* scene;
  ContactWorld world;
  FaultLatch fault;
  HeldParts held;
  std::unique_ptr<PartContact> partContact;  // null: the scene has no part models
  Layers layers;
  MovedParts moved;
  Tool tool;  // of the first hand
  Fade fade;
  OutputLimits output;
  SampleGuard guard;
  RestingReading reading;
  Wrench couplingWrench;  // of the last tick, before limits
  ForceFields fields;
  Wrench fieldWrench;      // of this tick, before limits
  double sentShare = 0.0;  // of the force that the last tick wanted, how much left for the hand
  SecondHandPort second;
  DeviceSample device;       // the last valid one
  double invalidTime = 0.0;  // s since the last valid sample
  bool stalled = false;      // there was none since ticks have stood still
  double time = 0.0;         // s, session clock, of the last tick
};

}  // namespace tandem::haptics
