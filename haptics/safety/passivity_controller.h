#pragma once

// Time-domain passivity control of the force that is sampled and held: it damps when, and only when, the
// sampling has given the hand energy that the rendered world did not have.

#include <glm/vec3.hpp>

#include "haptics/safety/resting_reading.h"

namespace tandem::haptics {

/// Passivity controller of Hannaford & Ryu 2002, with the energy that the rendered world should have
/// exchanged as the reference (Ryu, Preusche, Hannaford & Hirzinger 2005, "Time-domain passivity control
/// with reference energy following"): energy received earlier licenses none to be given later, and nothing
/// has to be dissipated in a burst.
///
/// Over a tick the hand moves by d. It receives F_sent . d, exactly, because the force is held. Had the
/// force followed the displacement, it would have been given (F_last + F_now) . d / 2: exactly so for every
/// spring, whatever law the force follows otherwise. The difference, less what the device's own damping b
/// takes (b d^2 / T; Colgate & Schenkel 1994: K T / 2 <= b), is the deficit, never below zero:
///
///     deficit += F_sent . d - (F_last + F_now - F_time) . d / 2 - b d^2 / T
///
/// and is dissipated by a force -deficit d / d^2 against d, at most as large as the last change of the
/// force: a device's quantum is never amplified beyond what the spring itself makes of it. It never pulls.
///
/// The change F_time of a source that varies with time (a waveform) is not caused by sampling: its held
/// force is what the world renders.
///
/// An encoder at a mark (RestingReading) counts as no displacement, so a hand at rest feels the spring's
/// own flicker of one quantum and nothing on top.
class PassivityController {
 public:
  /// The force to add, N. `position` is the device's reading (m), `force` what is rendered (N), `byTime` what
  /// of its change since the last step would have come had the hand stood still (N), `damping` what of the
  /// device's physical damping may be counted on (N·s/m), `dt` in s. sent() must follow.
  glm::dvec3 step(const glm::dvec3& position, const glm::dvec3& force, const glm::dvec3& byTime,
                  double damping, double dt);

  /// What was sent in the end, N: held until the next step().
  void sent(const glm::dvec3& force) { sent_ = force; }

  /// Energy given beyond the reference and not yet dissipated, J.
  double deficit() const { return deficit_; }

  /// Forgets everything: the force was interrupted.
  void restart() { *this = PassivityController{}; }

 private:
  bool started_ = false;
  RestingReading reading_;
  glm::dvec3 position_{0.0, 0.0, 0.0};  // the reading
  glm::dvec3 rendered_{0.0, 0.0, 0.0}, sent_{0.0, 0.0, 0.0};
  double deficit_ = 0.0;  // J
};

}  // namespace tandem::haptics
