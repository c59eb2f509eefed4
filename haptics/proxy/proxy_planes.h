#pragma once

// The constraint planes of the proxy, and the projection of the goal onto them: the parts of each round in
// proxy.cpp.

#include <glm/vec3.hpp>

#include "haptics/proxy/proxy.h"
#include "haptics/scene/contact_world.h"

namespace tandem::haptics {

/// Measures the planes again from the present proxy position and drops those that it no longer touches. True
/// if a pressing plane was dropped or rotated, so that the last projection is out of date.
bool refreshPlanes(const ContactWorld& world, double radius, Proxy& proxy);

/// Adds the triangle that a sweep has hit. It replaces the plane of the same triangle, takes a free slot, or
/// replaces a plane that does not press.
void addPlane(const ContactWorld& world, const WorldHit& hit, double radius, Proxy& proxy);

/// Turns a contact on the edge or corner of a triangle (world frame) into one with the triangle's plane. A
/// triangle without area leaves the contact unchanged.
void takeFacePlane(const Triangle& face, const glm::dvec3& position, SurfacePoint& at);

/// How a contact on an edge counts when its face rises out of another contact's plane: as that face's whole
/// plane, which is right at an inner edge, or as the edge alone.
enum class Covered { asFace, asEdge };

/// Displacement from the proxy to the point nearest to the goal that the known planes allow, m: the god
/// object of Zilles & Salisbury 1995, with planes at the height of the ball as in Ruspini, Kolarov & Khatib
/// 1997. Stores the multipliers, the depths, and whether a face presses beyond its edge. In a gap where the
/// planes contradict each other the proxy may come no nearer to any of them.
glm::dvec3 displacementToGoal(const ContactWorld& world, const glm::dvec3& goal, double radius, Proxy& proxy,
                              Covered covered = Covered::asFace);

/// Smallest skin and largest margin of the known planes, m; 0 without any.
double smallestSkin(const Proxy& proxy);
double largestMargin(const Proxy& proxy);

/// Whether any plane presses.
bool touches(const Proxy& proxy);

/// The plane that presses alone; null if none or several do.
ProxyPlane* onlyPressing(Proxy& proxy);

}  // namespace tandem::haptics
