#pragma once

// What parts may do to a hand that another site moves as no hand moves them: the force changes at a limited
// rate, and they give the hand a limited energy.
//
// A part that another site moves is an obstacle of unlimited strength, because its owner does not feel this
// hand. Its motion is known from states that may be wrong or lies, and whoever brings the motions to the tick
// says which are suspect (PartMotion). The guard acts on those alone. While such a part is calm, so slow that
// it changes the force by less than ForeignLimits::slew, what the hand itself makes of the force passes:
//
//   C += -K d        d: displacement of the hand in the tick, K: the stiffness in play
//   |F - F_sent| <= max(slew T, C . direction of the change)
//
// Within kRestless of a faster motion every change passes at the slew rate only, because the hand's own
// motion may be what the part has made of it.
//
// The energy that the hand is given, sum of F_sent . d, is taken from an account that the hand fills by
// pushing. The force is limited so that it can fall to zero at the slew rate before the account is empty,
// where v is the hand's velocity along it:
//
//   F^2 / 2K + F^2 v / (2 slew) <= account
//
// Then the part yields to the hand, which feels it as a surface that no longer advances.
//
// 1. Without suspect motion the wrench passes unchanged, to the bit, once nothing is held back.
// 2. What is held back never pulls: the force lies between the last one and the wanted one.
// 3. Pure and bounded; nothing allocates.

#include "haptics/base/tick_types.h"

namespace tandem::haptics {

class ForeignGuard {
 public:
  /// A tick as one hand has it.
  struct Tick {
    double foreign = -1.0;                   // m, displacement of the suspect part that it feels; < 0: none
    bool touches = false;                    // it touches suspect parts
    glm::dvec3 displacement{0.0, 0.0, 0.0};  // m, of the hand since the last tick
    double stiffness = 1.0;                  // N/m, the stiffest spring between hand and parts
    bool held = false;                       // the part meets what this hand holds, which may swing on
  };

  /// The wrench that may go on in place of `wanted`. Sets kFlagForeignLimited where it differs.
  Wrench step(const Wrench& wanted, const Tick& tick, const TickParameters& parameters, std::uint32_t& flags);

  /// Whether a part moved fast under the hand within kRestless.
  bool restless() const { return restless_ > 0.0; }
  /// J: what foreign parts may still give.
  double account() const { return account_ < 0.0 ? 0.0 : account_; }

 private:
  glm::dvec3 force(const glm::dvec3& wanted, const Tick& tick, const TickParameters& parameters);
  double mostForce(double stiffness, const TickParameters& parameters) const;

  Wrench sent_;                       // of the last tick
  glm::dvec3 credit_{0.0, 0.0, 0.0};  // N: C, change of the force that the hand has made and not used
  double account_ = 0.0;              // J, once `counts_`
  bool counts_ = false;
  double restless_ = 0.0;  // s for which the parts count as restless
  double along_ = 0.0;     // m/s, velocity of the hand along the force, low-passed
  double engaged_ = 0.0;   // s for which the guard still acts
};

}  // namespace tandem::haptics
