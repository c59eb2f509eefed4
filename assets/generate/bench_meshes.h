#pragma once

// Large meshes and scenes whose exact answer is known, for benches, hard-case tests and reports.
//
// 1. Triangles face outwards; bounds and materials (all 0) are filled. Topology (neighbours, edge flags,
//    shells, volume) is filled for meshes of up to kAnalysedTriangles triangles, or on demand: contact
//    without shading does not read it.
// 2. Deterministic: the same arguments give the same bits.

#include <vector>

#include <glm/vec2.hpp>

#include "assets/scene/scene.h"

namespace tandem::generate {

enum class Topology { whenCheap, always, never };
inline constexpr int kAnalysedTriangles = 2'000'000;

/// A sphere around the origin whose vertices lie on the surface: 8 f^2 triangles, at least `triangles`, of
/// nearly equal size (edges within 1 : 1.6).
assets::Mesh sphereMesh(double radius, int triangles, Topology topology = Topology::whenCheap);

/// A scan of a body of about `radius` m: the vertices of sphereMesh() under waves of 4 % of the radius, each
/// then displaced at random by up to `noise` of a mean edge, along the sphere's normal and across it.
assets::Mesh scanMesh(double radius, int triangles, double noise, unsigned seed,
                      Topology topology = Topology::whenCheap);
/// The height of its waves over the sphere in a direction, m.
double scanWave(double radius, const glm::dvec3& direction);

inline constexpr int kGearTeeth = 12;
inline constexpr double kGearPitchRadius = 0.020;  // m
inline constexpr double kGearHeight = 0.010;       // m, from z = 0

/// Outline of the gear, m: closed polygon, counter-clockwise around the origin, tooth 0 centred on +x. Flanks
/// follow an involute of 20 degrees in straight pieces; tips and roots are flat.
std::vector<glm::dvec2> gearProfile();

/// gearProfile() extruded along z from 0 to kGearHeight, cut into at least `triangles` triangles of nearly
/// equal size. Cuts lie in the planar faces: every tessellation is the same solid, to the rounding of
/// coordinates (4e-18 m).
assets::Mesh gearMesh(int triangles, Topology topology = Topology::whenCheap);

/// The largest depth, m, of the triangles of a sphere around the origin below that sphere.
double deepestFacet(const assets::Mesh& sphere, double radius);

/// A square sheet in the plane z = 0 around the origin, normal +z, of n x n quads.
assets::Mesh flatSheet(double size, int n);

/// A groove along y: two walls of n x n quads each from the apex line at the origin upwards, at `halfAngle`
/// rad from +z. Both are `size` wide and 2 size long, from y = -size.
assets::Mesh vGroove(double size, double halfAngle, int n);

/// A floor of columns x columns square plates side by side: top faces in z = 0, centred on the origin; each
/// plate is a static part of its own.
assets::Scene plateGrid(int columns, double edge, double thickness);

/// `count` movable parts, all one mesh: spheres of 2 mm radius and some 200 triangles, 5 mm apart in a square
/// grid in the plane z = 0, centred on the origin.
assets::Scene smallParts(int count);

/// A scene of one static part at the origin.
assets::Scene sceneOf(assets::Mesh mesh);

}  // namespace tandem::generate
