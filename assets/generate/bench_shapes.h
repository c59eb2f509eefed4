#pragma once

// Shapes whose contact forces are known exactly, at any number of triangles: what speed and error are
// measured on. Everything is in m; solids are closed and oriented outwards, ready for assets::analyseMesh().

#include <cstddef>

#include "assets/generate/shapes.h"
#include "assets/mesh_analysis.h"

namespace tandem::generate {

/// An icosahedron whose faces are cut into frequency^2 triangles each, with every vertex on the sphere: about
/// `triangles` of them (20 frequency^2), nearly equal in size.
assets::TriangleSoup geodesicSphere(double radius, std::size_t triangles);

/// The most by which the facets of geodesicSphere() lie below the sphere, m, measured on the soup.
double deepestFacet(const assets::TriangleSoup& sphere, double radius);

/// Radii and steps of gearProfile().
struct GearShape {
  int teeth = 12;
  double rootRadius = 0.040;  // m
  double tipRadius = 0.050;   // m
  int flankSteps = 6;         // straight pieces of a flank
};

/// The outline of a gear: a polygon whose flanks bulge like an involute's, with straight lands at tips and
/// roots. Star-shaped about the origin.
Loop gearProfile(const GearShape& shape = {});

/// A prism over a polygon that is star-shaped about the origin, z from -thickness/2 to thickness/2. Walls and
/// caps are cut into about `triangles` triangles, at least four an edge of the polygon; the walls stay
/// exactly those of the polygon, however fine.
assets::TriangleSoup extrudeStar(const Loop& profile, double thickness, std::size_t triangles);

/// A square sheet in the plane z = 0 around the origin, normal +z, of n x n quads.
assets::TriangleSoup flatSheet(double size, int n);

/// A groove along y: two walls of n x n quads each from the apex line at the origin upwards, at `halfAngle`
/// rad from +z. Both are `size` wide, and 2 size long.
assets::TriangleSoup vGroove(double size, double halfAngle, int n);

/// A box around the origin.
assets::TriangleSoup plainBox(const glm::dvec3& size);

}  // namespace tandem::generate
