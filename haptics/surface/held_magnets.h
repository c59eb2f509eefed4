#pragma once

// The pull of magnetic surfaces on a part in the hand.
//
// With d the least distance of the part to the faces of a magnet, D the reach and F the force of their
// surface, u the potential of magneticPull() and x = d / D:
//     U = min over points p of the part and q of the faces of u(|p - q|),    F(d) = 4 F x (1 - x)
// acts at p towards q, as a spring between them of k = F(d) / d = (1 - x) 4 F / D.
//
// 1. The pull gives out no more than it got. u is a concave function of d^2, so that the spring, which is
//    tangent to it there, lies above it everywhere: a step that loses energy against the spring (backward
//    Euler, haptics/body) loses it against u(|p - q|), and U is nowhere above that.
// 2. So it suffices to know some pair of points. That of the last tick is led down to a place where each is
//    the nearest to the other; a search through the balls of both parts' samples, some each tick, finds where
//    another pair is nearer. What is found late has been pulled too weakly until then, which only loses
//    energy.
// 3. The pull of a magnet that comes into reach grows within the fade time, which loses energy too. A grasp
//    begins without pull.
// 4. Up to kMax magnets pull, those whose bounding spheres are nearest; kFlagOverflow where there are more.
//    Parts without models, hidden ones and those that the part may not touch do not. Free of allocation.

#include <cstddef>
#include <cstdint>
#include <span>

#include "haptics/base/fixed_vector.h"
#include "haptics/scene/contact_world.h"
#include "haptics/scene/surface_scene.h"

namespace tandem::haptics {

/// A spring of no length between a place of the part in the hand and one of a magnet.
struct MagnetPull {
  PartId magnet = kNoPart;
  glm::dvec3 onHeld{0.0, 0.0, 0.0}, onMagnet{0.0, 0.0, 0.0};  // m, world
  double stiffness = 0.0;                                     // N/m, > 0
};

class HeldMagnets {
 public:
  static constexpr std::size_t kMax = 4;
  using Pulls = FixedVector<MagnetPull, kMax>;

  /// The hand holds nothing that is pulled.
  void forget() { tracks_.clear(); }
  /// What pulls at the part that the hand holds, once a tick, as the parts stand in the world. `fade`, 0..1,
  /// is the share of the fade time that a tick takes. Adds to `flags`.
  Pulls find(const ContactWorld& world, PartId held, double fade, std::uint32_t& flags);

 private:
  struct Near {
    double gap = 0.0;  // m, between bounding spheres; 0 where they meet
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
    bool throughHeld = false;                                   // the samples of which part are searched
    FixedVector<std::uint32_t, 64> balls;                       // that remain to be searched
  };
  class Search;

  using NearList = FixedVector<Near, kMax>;
  static NearList nearest(const ContactWorld& world, PartId held, std::uint32_t& flags);

  PartId held_ = kNoPart;
  FixedVector<Track, kMax> tracks_;
};

}  // namespace tandem::haptics
