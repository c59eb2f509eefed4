#pragma once

// All force fields of a scene as one hand feels them.
//
// 1. step() is free of allocation; the constructor allocates. A scene without fields costs one comparison.
// 2. Not shared between threads: each TickState owns one.

#include <cstdint>
#include <vector>

#include "haptics/base/device.h"
#include "haptics/fields/field_force.h"
#include "haptics/scene/contact_world.h"

namespace tandem::haptics {

/// Combined action of all fields on the hand in one tick.
struct FieldForces {
  glm::dvec3 force{0.0, 0.0, 0.0};         // N, world axes, at the device's tip, before the output's limits
  glm::dvec3 sourceChange{0.0, 0.0, 0.0};  // N, change of the force since the last tick by time alone
  double sourcePower = 0.0;                // W, power that the fields' laws gave the hand since the last tick
  glm::dvec3 damping{0.0, 0.0, 0.0};       // N, the share of dampers in the force
  double dampingRate = 0.0;                // N·s/m, the greatest of all dampers together, within their limit
  double curvature = 0.0;                  // N/m, bound of how the rest of the force changes with the place
  std::uint32_t flags = 0;                 // kFlagOverflow, kFlagFieldLimited
};

/// Parameters of all fields.
struct FieldSettings {
  double dt = 1e-3;            // s
  double fadeTime = 0.3;       // s, fade of a field when the hand takes or releases its part
  double dampingLimit = 10.0;  // N·s/m, of all dampers together
  PartId held = kNoPart;       // the fields of a part do not act on the hand that holds it
  double curvatureOver = 0.0;  // m, over which FieldForces::curvature is measured; 0: it is not
};

class ForceFields {
 public:
  /// The scene must outlive this object. Fields beyond kMaxForceFields are ignored, which step() flags.
  explicit ForceFields(const assets::Scene& scene);

  bool empty() const { return entries_.empty(); }

  /// The forces on a hand with this valid reading, at a time in s of the session's clock.
  FieldForces step(const ContactWorld& world, const DeviceSample& device, double time,
                   const FieldSettings& settings);
  /// Notes a tick without a reading: the next one searches paths anew, and no work is counted until then.
  void forgetHand();

 private:
  struct Entry {
    explicit Entry(const assets::ForceField& field) : law(field) {}
    FieldForce law;
    double at = 0.0;         // parameter on the path
    double potential = 0.0;  // J, of the last tick
    double weight = 1.0;     // 0..1
    bool known = false;      // at and potential are those of the last tick
  };
  struct Sum;

  void addEntry(Entry& entry, const ContactWorld& world, const DeviceSample& device, double time,
                const FieldSettings& settings, Sum& sum);
  static void findPlace(Entry& entry, const glm::dvec3& x);
  static double curvatureOf(const Entry& entry, const FieldQuery& query, const FieldAction& here,
                            double over);

  std::vector<Entry> entries_;
  double lastTime_ = 0.0;  // s, of the last step
  bool started_ = false;
  bool overflow_ = false;
};

}  // namespace tandem::haptics
