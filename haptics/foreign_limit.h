#pragma once

// What parts that others move may do to a hand, whatever their owners say of them.
//
// 1. They change the force at TickParameters::foreignSlewLimit a, beside what the hand's own motion does to
//    the spring of stiffness K between the hand and what it touches.
// 2. Near a part in a hand they come after their poses at a / K. Parts in the hands of two sites are linked
//    instead (haptics/link), and not held back.
// 3. A part that comes against the bare tool, or leaves a surface that the tool presses on, faster than a / K
//    passes through the tool until the tool has left it, and its force fades.
// 4. Once they have given the hand kMostWork, which grows back at kPower, parts near held ones stand still,
//    and what still pushes the tool passes through it.
// 5. Nothing here allocates. Only the thread that ticks uses it.

#include "haptics/base/fixed_vector.h"
#include "haptics/contact/part_contact.h"
#include "haptics/grasp/held_part.h"
#include "haptics/scene/contact_world.h"
#include "haptics/tool/tool.h"

namespace tandem::haptics {

class ForeignLimit {
 public:
  static constexpr double kMostWork = 6e-3;  // J
  static constexpr double kPower = 1e-3;     // W

  /// Begins a tick with its limit a in N/s (0: owners are believed), stiffness K in N/m and dt in s.
  void begin(double a, double stiffness, double dt);
  bool active() const { return travel_ > 0.0; }

  /// The region in which foreign parts can touch this hand in the tick, m, world: what the tool reaches, and
  /// the room around each held part.
  assets::Bounds reach(assets::Bounds ofTool, const ContactWorld& world, const HeldParts& held) const;

  /// A part has moved from `before`, where it had `twistBefore`, to its present pose: holds it back, and
  /// moves the tool. False if it has outrun the tool, whose touch of it ends now. `contact` may be null.
  [[nodiscard]] bool follow(ContactWorld& world, const HeldParts& held, const PartContact* contact,
                            Tool& tool, PartId part, const Pose& before, const Twist& twistBefore);

  /// After the tool has moved: a hand that touches a part that others move feels that motion too, even where
  /// its own has led it there.
  void noteTouch(Tool& tool) const;

 private:
  static constexpr std::size_t kMax = 64;

  double travel_ = 0.0;                // m, in this tick
  double work_ = 0.0;                  // J, given to the hand and not yet grown back
  FixedVector<PartId, kMax> moved_{};  // of this tick
};

}  // namespace tandem::haptics
