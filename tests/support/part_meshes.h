#pragma once

// Machine parts with exact answers, for contact between parts. Everything in m.
//
// 1. Each function gives triangles that form one closed solid, oriented outwards, unless it says otherwise;
//    meshOf() welds them.
// 2. Round things are polygons of `segments` sides. A shaft's corners lie on its radius, so that it lies
//    within the true cylinder by chordSag(); a bore's side middles do (Fit::around), so that the gap between
//    a shaft and a bore is exactly the difference of radii where a corner meets a side's middle, and nowhere
//    less.
// 3. Deterministic: the same arguments give the same bits.

#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "assets/mesh/mesh_analysis.h"

namespace tandem::test {

/// How round things are cut: sides around, and layers along the axis.
struct Facets {
  int segments = 96;  // rounded up to a multiple of 8
  int rings = 8;
};

/// Facets of a shaft of about `triangles` triangles, at least 300: 5,000 give 160 x 13, 50,000 give 504 x 47.
Facets facetsFor(int triangles);

/// How deep the sides of a polygon with its corners on a circle lie under that circle, m.
double chordSag(double radius, int segments);

/// How many segments a shaft or bore of `radius` needs so that its sag is at most half the radial
/// `clearance`: pi / sqrt(c / r).
int segmentsNeeded(double radius, double clearance);

/// Where a bore's polygon lies: sides' middles on its circle, or corners on it as CAD programs write it (then
/// a shaft has chordSag() less room).
enum class Fit { around, within };

struct Peg {
  double radius = 0.010;
  double length = 0.040;
  double chamfer = 0.001;  // at 45 degrees, at the tip; 0 = none
  Facets facets;
};
/// Along +z, its tip's face in z = 0.
assets::TriangleSoup pegSoup(const Peg& peg);

struct BoredBlock {
  double boreRadius = 0.010;
  double depth = 0.045;   // of the bore
  double width = 0.060;   // of the square block
  double height = 0.045;  // the bore goes through if this is the depth
  double chamfer = 0.0;   // of the bore's rim, at 45 degrees
  Fit fit = Fit::around;
  Facets facets;
};
/// The block's top is z = 0 and the bore goes down the z axis.
assets::TriangleSoup boredBlockSoup(const BoredBlock& block);

/// A box around the origin, each face of n x n squares.
assets::TriangleSoup boxSoup(const glm::dvec3& size, int n = 1);

/// A ball around the origin; corners on the sphere. 2 segments (rings - 1) triangles.
assets::TriangleSoup ballSoup(double radius, const Facets& facets);

/// A prism over a counter-clockwise polygon of the x-y plane, from z = 0 to `height` in `layers`. Caps use
/// the polygon's corners only.
assets::TriangleSoup prismSoup(const std::vector<glm::dvec2>& outline, double height, int layers = 1);

/// A block with a groove of half angle `halfAngle` (rad, from the vertical) along y: its floor line at the
/// origin, its brims in z = depth, 2 depth tan(halfAngle) + 2 land wide, from y = -length/2.
assets::TriangleSoup vGrooveSoup(double depth, double halfAngle, double land, double length);

/// A block with a slot of rectangular section along y: floor in z = 0, walls at x = -width/2 and width/2 up
/// to z = depth.
assets::TriangleSoup slotSoup(double width, double depth, double wall, double length);

/// `steps` stairs up along +x, each `run` wide and `rise` high, from the origin, `length` along y from
/// -length/2; the lowest tread lies in z = rise.
assets::TriangleSoup stairSoup(int steps, double run, double rise, double length);

struct SpurGear {
  double module = 0.002;
  int teeth = 20;
  double width = 0.010;
  double bore = 0.004;                          // radius of the hole
  double pressureAngle = 0.349065850398865915;  // rad: 20 degrees
  double backlash = 0.0;                        // by which a tooth is narrower at the pitch circle, m of arc
  int flankPoints = 12;                         // of the involute
};
/// Outline, counter-clockwise around the origin, tooth 0 centred on +x: involute flanks, flat tips and roots,
/// addendum 1 and dedendum 1.25 modules. Corners lie on the involute.
std::vector<glm::dvec2> spurGearOutline(const SpurGear& gear);
/// From z = 0 to the width.
assets::TriangleSoup spurGearSoup(const SpurGear& gear);

/// A thread of the ISO basic profile (ISO 68-1): 60 degrees between flanks, flats of pitch / 8 at the major
/// and pitch / 4 at the minor diameter, right-handed; at angle 0 the middle of the major flat is in z = k
/// pitch.
struct Thread {
  double majorRadius = 0.008;
  double pitch = 0.002;
  double length = 0.016;
  double clearance = 0.0;  // radial, taken off a bolt: flanks are half of it apart, across them
  int segments = 64;       // a turn, rounded up to a multiple of 8
  int perPitch = 4;        // steps of each flank
};
/// Radius of the basic profile at a height above the middle of the major flat, m.
double threadProfile(const Thread& thread, double height);
/// A bolt: thread from z = 0 to its length, cut off flat. Corners on the true surface.
assets::TriangleSoup boltThreadSoup(const Thread& thread);
/// A round nut of `outerRadius`, the same heights; corners of each side lie out by 1 / cos(pi / segments), so
/// that its middles are on the true surface.
assets::TriangleSoup nutThreadSoup(const Thread& thread, double outerRadius);

/// Every triangle turned over.
assets::TriangleSoup insideOut(assets::TriangleSoup soup);
/// Every triangle with corners of its own, every `flipEvery`-th turned over (0 = none), every `dropEvery`-th
/// left out (0 = none).
assets::TriangleSoup shattered(const assets::TriangleSoup& soup, int flipEvery = 0, int dropEvery = 0);
/// Moved by a vector.
assets::TriangleSoup moved(assets::TriangleSoup soup, const glm::dvec3& by);
/// Two in one.
assets::TriangleSoup joined(assets::TriangleSoup first, const assets::TriangleSoup& second);

/// Welded, with topology.
assets::Mesh meshOf(assets::TriangleSoup soup);
/// The same triangles as they are, without welding, topology, volume.
assets::Mesh rawMeshOf(const assets::TriangleSoup& soup);

}  // namespace tandem::test
