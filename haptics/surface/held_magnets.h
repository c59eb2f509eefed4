#pragma once

// The pull of magnetic surfaces on a part in the hand.
//
// With d the least distance of the part to the faces of a magnet, D the reach and F the force of their
// surface, u the potential of magneticPull() and x = d / D:
//     U = min over points p of the part and q of the faces of u(|p - q|),    F(d) = 4 F x (1 - x)
// acts at p towards q, and the opposite at q where the magnet moves here too.
//
// 1. Some pair of points must be known. That of the last tick is led down to a place where each is the
//    nearest to the other; a search through the balls of both parts' samples, some each tick, finds where
//    another pair is nearer. What is found late has been pulled too weakly until then.
// 2. The pull gives out no more than it got. An account of each magnet adds up the work of its force and the
//    growth of its potential, which makes what a force that is held for a tick has given too much, to second
//    order. A damper between the points takes it back; what is too little is lost.
// 3. The force is held for a tick, so that its stiffness F(d) / d is held to 1 / (T^2 W), W the most that a
//    push moves the points towards each other. One of 4 N over 1 mm pulls the end of a bar of 60 g as stated.
// 4. The pull of a magnet that comes into reach grows within the fade time, which loses energy too. A grasp
//    begins without pull.
// 5. Up to kMax magnets pull; kFlagOverflow where more may be in reach. Parts without models, hidden ones and
//    those that the part may not touch do not. Free of allocation.

#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/mat3x3.hpp>

#include "haptics/base/fixed_vector.h"
#include "haptics/scene/contact_world.h"
#include "haptics/scene/surface_scene.h"

namespace tandem::haptics {

/// A part that moves here.
struct MagneticBody {
  PartId part = kNoPart;
  glm::dvec3 centre{0.0, 0.0, 0.0};  // m, world, of mass
  double mass = 1.0;                 // kg
  glm::dmat3 mobility{0.0};          // 1/(kg·m^2), the inverse inertia about the centre, world axes
};

/// The pull of one magnet.
struct MagnetPull {
  PartId magnet = kNoPart;
  glm::dvec3 onHeld{0.0, 0.0, 0.0}, onMagnet{0.0, 0.0, 0.0};  // m, world
  glm::dvec3 force{0.0, 0.0, 0.0};                            // N, world, on the part in the hand
};

class HeldMagnets {
 public:
  static constexpr std::size_t kMax = 16;
  using Pulls = FixedVector<MagnetPull, kMax>;

  struct Settings {
    double dt = 1e-3;    // s
    double fade = 1.0;   // 0..1, of the fade time, that a tick takes
    double share = 1.0;  // 0..1, of all pulls
  };

  /// The hand holds nothing that is pulled.
  void forget() {
    tracks_.clear();
    pulls_.clear();
  }
  /// What pulls at the part that the hand holds, once a tick, as the parts stand in the world. `bodies`: that
  /// part and the others that move here. Adds to `flags`.
  const Pulls& find(const ContactWorld& world, PartId held, std::span<const MagneticBody> bodies,
                    const Settings& settings, std::uint32_t& flags);
  /// Of the last tick.
  const Pulls& pulls() const { return pulls_; }

 private:
  struct Near {
    double gap = 0.0;  // m, as far as it is known (rank())
    PartId part = kNoPart;
    std::size_t magnet = 0;  // into the part's magnets
    bool before(const Near& other) const;
  };
  /// The pair of points of a magnet and the part, and the search for a nearer one.
  struct Track {
    PartId part = kNoPart;
    std::size_t magnet = 0;
    double share = 0.0;  // 0..1, of its pull
    bool known = false;
    glm::dvec3 onHeld{0.0, 0.0, 0.0}, onMagnet{0.0, 0.0, 0.0};  // m, each in the frame of its part
    double distance = 0.0;                                      // m, between them
    int work = 0;                                               // nodes that it may still visit
    bool searched = false;                                      // through the samples of the part
    bool throughHeld = false;                                   // the samples of which part are searched
    FixedVector<std::uint32_t, 64> balls;                       // that remain to be searched
    glm::dvec3 force{0.0, 0.0, 0.0};                            // N, on the part in the last tick, world
    glm::dvec3 between{0.0, 0.0, 0.0};                          // m, from q to p then, world
    double potential = 0.0;                                     // J, <= 0
    double account = 0.0;                                       // J, >= 0, given too much
  };
  class Search;

  using NearList = FixedVector<Near, kMax>;
  NearList nearest(const ContactWorld& world, PartId held, std::uint32_t& flags) const;
  static double rank(const Track* track, double gap, double distance);
  const Track* trackOf(PartId part, std::size_t magnet) const;
  void keepOnly(const NearList& near);
  MagnetPull follow(Track& track, const ContactWorld& world, std::span<const MagneticBody> bodies,
                    const Settings& settings);

  PartId held_ = kNoPart;
  FixedVector<Track, kMax> tracks_;
  Pulls pulls_;
};

}  // namespace tandem::haptics
