#pragma once

// What TickState holds. For tick.cpp, the report and the tests that look inside.

#include <array>
#include <memory>
#include <vector>

#include "haptics/base/fault.h"
#include "haptics/body/fade.h"
#include "haptics/contact/part_contact.h"
#include "haptics/fields/force_fields.h"
#include "haptics/grasp/controls.h"
#include "haptics/grasp/held_part.h"
#include "haptics/grasp/second_hand.h"
#include "haptics/proxy/mesh_change.h"
#include "haptics/proxy/proxy.h"
#include "haptics/safety/output_limits.h"
#include "haptics/safety/resting_reading.h"
#include "haptics/safety/sample_guard.h"
#include "haptics/scene/contact_world.h"
#include "haptics/surface/apply_surface.h"
#include "haptics/tick.h"

namespace tandem::haptics {

inline constexpr int kMaxIgnored = 16;
// A part may be taken when its surface is within this share of its own bounding diagonal: scale-free.
inline constexpr double kTouchShare = 0.02;
// More parts than this that move at once are kept out of the scene tree.
inline constexpr std::size_t kManyMoving = 32;

struct TickState::Data {
  explicit Data(const ContactScene& contactScene);
  void measureReach();
  void noteMeshChange();

  const ContactScene::Data* scene;
  ContactWorld world;
  HeldParts held;
  std::unique_ptr<PartContact> partContact;  // null: the scene has no part models
  Layers layers;
  Proxy proxy;
  SurfaceState surface;
  FaultLatch fault;
  Fade fade;
  OutputLimits output;
  SampleGuard guard;
  RestingReading reading;
  Wrench contactWrench;  // of the last tick, before limits
  Wrench couplingWrench;
  ForceFields fields;
  Wrench fieldWrench;      // of this tick, before limits
  double sentShare = 0.0;  // of the force that the last tick wanted, how much left for the hand
  SecondHandPort second;
  DeviceSample device;                        // the last valid one
  double invalidTime = 0.0;                   // s since the last valid sample
  bool stalled = false;                       // there was none since ticks have stood still
  double time = 0.0;                          // s, session clock, of the last tick
  MeshChange meshChange;                      // since the last tick
  bool started = false;                       // there has been a valid sample
  double touchReach = 0.0;                    // m, the largest of all parts
  std::vector<std::uint32_t> near;            // of the parts moved in this tick; capacity for all
  std::vector<PartId> moving;                 // parts with a twist from this tick; capacity for all
  std::vector<PartId> movedBefore;            // those of the last tick
  std::vector<std::uint32_t> movedAt;         // per part: the last tick in which others moved it
  std::uint32_t tickNumber = 0;               // wraps: only equality with movedAt is asked
  std::array<PartId, kMaxIgnored> ignored{};  // parts that the tool passes through until it has left them
  int ignoredCount = 0;
};

}  // namespace tandem::haptics
