#pragma once

// The hard cases of contact between a held part and its neighbours: scene, device path, and what must come
// out. Tests run them through HeldPartRig; make_part_cases writes them as files for the command line.
//
// The path says where the held part's frame would be if nothing were in the way, world; the part starts
// there.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "assets/base/pose.h"
#include "assets/scene/scene.h"
#include "tests/support/part_meshes.h"

namespace tandem::test {

/// Where the device wants the held part at a time (s).
using DevicePath = std::function<Pose(double time)>;

struct PartCase {
  std::string name;
  assets::Scene scene;
  PartId held = 0;
  DevicePath path;
  double duration = 1.0;  // s
  assets::TriangleSoup
      asFiled{};  // what a file has in place of the last part's mesh, if it has any triangles
};

/// A part of a case. Movable parts have the mass of their solid at `density`.
struct CasePart {
  std::string name;
  assets::Mesh mesh;
  Pose worldFromPart{};
  bool movable = false;
  double friction = 0.0;    // static and dynamic, of its material
  double density = 7850.0;  // kg/m^3
  double mass = 0.0;        // kg; 0: of the density
};
assets::Scene sceneOfParts(const std::vector<CasePart>& parts);

/// Six-axis tremor of a hand: `amplitude` m along, amplitude / lever rad about each axis, 8 to 12 Hz.
class Tremor {
 public:
  Tremor(std::uint32_t seed, double amplitude, double lever = 0.040);
  glm::dvec3 shift(double time) const;  // m
  glm::dvec3 turn(double time) const;   // rad, a rotation vector

 private:
  double value(std::size_t axis, double time) const;
  double amplitude_, lever_;
  double frequency_[6], phase_[6];
};

/// A 20 mm peg of 40 mm with a 1 mm chamfer over its bore, tilted and offset, brought down at 20 mm/s to 38
/// mm.
struct PegCase {
  double diametralClearance = 0.1e-3;  // m
  int triangles = 1'500;               // of the peg
  std::uint32_t seed = 0;
  double friction = 0.0;
  double tiltLeast = 1.0, tiltMost = 2.0;            // degrees
  double offsetLeast = 0.2e-3, offsetMost = 0.8e-3;  // m
  double tremor = 0.1e-3;                            // m
  double depth = 0.038;                              // m, of the tip below the bore's rim
  double settle = 0.6;                               // s at the end of the way
  Fit fit = Fit::around;
  int segments = 0;  // of peg and bore; 0: of the number of triangles
  /// Of the peg about its axis, from where its corners stand before the bore's, rad; below 0: any.
  double spin = -1.0;
};
inline constexpr double kPegRadius = 0.010;
PartCase pegCase(const PegCase& peg);

/// Straight above the top, beyond what its chamfer allows: it must come to rest with its tip in z = 0.
PartCase pegOnTopCase();

/// Let down straight into its bore, `engaged` deep, and then held askew with a moment of `moment` N·m about
/// its tip (at 4 N·m/rad), the peg is pushed down further and further, 5 mm/s from start() + 0.3 s until
/// start() + `pushed` s. It touches with the upper end of its chamfer and at the rim, a height l = engaged -
/// 1 mm apart, and slides when the push exceeds 2 mu moment / l (Whitney 1982, "Quasi-static assembly of
/// compliantly supported rigid parts": the line |M / (r Fz)| = l / (2 r mu) of the jamming diagram at Fx =
/// 0). Where l is less than mu times its diameter it may wedge.
struct JamCase {
  double engaged = 0.020;
  double moment = 0.3;
  double friction = 0.2;
  double pushed = 3.0;       // s
  bool pullsOut = false;     // and then straightens and pulls out
  bool takenInside = false;  // it is taken where it is, engaged, with 50 um of air around it

  double start() const { return takenInside ? 0.0 : (engaged + 0.001) / 0.1 + 0.05; }  // s
};
PartCase jamCase(const JamCase& jam);
inline constexpr double kJamPushSpeed = 0.005;  // m/s

/// A plate of 0.5 mm that comes down on another at `speed` m/s, somewhat askew, and goes on to 20 mm below
/// it.
PartCase plateOnPlateCase(double speed, std::uint32_t seed);

/// A cube of 5 mm that is taken within a block of 60 mm around the origin, and held still.
PartCase cubeInBlockCase(const glm::dvec3& where);

/// A peg of 6 mm, leaning outwards by 20 degrees, is pressed against the rim of a 20 mm bore and led round it
/// in 2 s.
inline constexpr int kRimSegments = 240;
PartCase pegAlongRimCase();

/// A cube of 10 mm pressed by 1 mm onto the top of a block, led across it at `speed` from 0.2 s on.
PartCase coplanarSlideCase(double speed);

/// A cube of 10 mm pushed by `push` m into a gap between two blocks in a slot that is 0.2 mm too narrow for
/// it.
PartCase threeBlocksCase(double push);

/// A cube of 10 mm pressed by 1 mm onto a block whose file is dirty.
enum class Dirt { none, insideOut, flipped, torn };
PartCase dirtyShellsCase(Dirt dirt);

/// Taken where it touches already: a cube on a block, or a peg against the wall of its bore. Held still.
PartCase cubeAtRestCase();
PartCase pegAtRestCase();

/// All, at the sizes of the default tests.
std::vector<PartCase> allPartCases();

}  // namespace tandem::test
