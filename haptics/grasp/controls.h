#pragma once

// Controls within the tick: what the tool and the hand put on them, and which parts their layers show.
//
// In a tick in which a moving part may touch a control that this site owns, the control is one more body of
// the contact (guidedPart()). Along its axis it has the inertia of one step of its dynamics, across it 1e6
// times that. Its stops are half-spaces, its dry friction a row that yields (haptics/contact, axis_rows.h).
// It touches moving parts alone, not its housing.
//
// 1. Parts, hand and control are solved together: the contact does no work, and a step of the control gains
//    no energy (control_dynamics.h), so nothing is created. One step a tick in place of eight: a drag of up
//    to L T.
// 2. TickOutput::pushed lists a control that is not owned and on which a part presses: the site asks for it.
//    A control in a hand is not pushed by parts.
// 3. Nothing here allocates, but for the constructor of Layers.

#include <vector>

#include "haptics/base/tick_types.h"
#include "haptics/body/control_dynamics.h"
#include "haptics/body/virtual_coupling.h"
#include "haptics/contact/moving_part.h"
#include "haptics/proxy/proxy.h"
#include "haptics/scene/contact_world.h"

namespace tandem::haptics {

/// A control that this hand moves.
struct MovedControl {
  const assets::Control* control = nullptr;  // null: the part is free
  double steepest = 0.0;                     // of its resistance
  ControlState state;
  AxisLoad tool;        // of the tool in the last tick
  bool pushed = false;  // by a part, in the last tick
};

/// Takes a part over from where it is in `world`; control == nullptr if the part is none. Of a control it
/// puts the reference point of the body, its centre of mass, onto the axis beside the part's middle.
MovedControl takeControl(const ContactWorld& world, PartId part, RigidBody& body);

/// What the tool's contact puts on a control: the opposite of `force` (N, on the hand, from the contacts with
/// its part in the last tick), along or about its axis, at the mean of the places that press. The stiffness
/// and the damping are upper bounds of how it changes when the part moves: those of the contact's springs, in
/// whatever direction they act, for friction acts across them too.
AxisLoad toolLoad(const ContactWorld& world, const Proxy& proxy, const assets::Control& control,
                  const glm::dvec3& force, const TickParameters& parameters);

/// One step of a control that only the tool and its own springs move.
void stepFree(MovedControl& moved, double dt, Pose& worldFromPart, Twist& twist);

/// What a control brings into a contact tick in which parts may push it: its free step along its axis.
/// `body` is its part's, whose centre of mass must lie on the axis (see takeControl()).
MovingPart guidedPart(const MovedControl& moved, RigidBody& body, double radius, double dt);

/// Ends that tick: the control keeps the motion along its axis, and the part stands where its value says.
void endGuided(MovedControl& moved, const Displacement& displacement, double dt, Pose& worldFromPart,
               Twist& twist);

/// One step of a control that the hand holds by the coupling from `partFromGrip` to the device. Motion along
/// the free axis is coupled as stepCoupledBody() couples it; across it the part does not give way, and the
/// hand feels the coupling's spring. Returns the wrench on the hand at the device's tip.
Wrench stepHeld(MovedControl& moved, const Pose& partFromGrip, const DeviceSample& device,
                const CouplingGains& gains, double dt, Pose& worldFromPart, Twist& twist);

/// Whether nothing moves a control that nobody holds: no tool or part on it, and slower than its range in a
/// thousand seconds.
bool isQuiet(const MovedControl& moved);

/// Hides the parts whose layers are off.
class Layers {
 public:
  explicit Layers(const assets::Scene& scene);

  /// Sets what is hidden by the values of the layers' parts now. `changed(part, hide)` is called for each
  /// part that appears or is about to vanish.
  template <typename Changed>
  void update(ContactWorld& world, Changed&& changed) const {
    for (const assets::Control* layer : layers_) {
      const bool hide = !assets::isShowing(*layer, assets::controlValue(*layer, world.pose(layer->part)));
      for (const PartId part : layer->shows) {
        if (world.hidden(part) == hide) continue;
        changed(part, hide);
        world.setHidden(part, hide);
      }
    }
  }

 private:
  std::vector<const assets::Control*> layers_;
};

}  // namespace tandem::haptics
