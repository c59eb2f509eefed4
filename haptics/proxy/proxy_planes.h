#pragma once

// The planes that hold the proxy, and the projection of the goal onto them: what proxy.cpp's rounds are made of.

#include <glm/vec3.hpp>

#include "haptics/proxy/proxy.h"
#include "haptics/scene/contact_world.h"

namespace tandem::haptics {

/// Measures the planes anew from where the proxy is now and drops those that it no longer touches. True if
/// one that matters has gone or turned, so that the last projection is out of date.
bool refreshPlanes(const ContactWorld& world, double radius, Proxy& proxy);

/// Adds what a sweep has met, in the place of the same triangle's plane, of a free one or of one that does not
/// press.
void addPlane(const ContactWorld& world, const WorldHit& hit, Proxy& proxy);

/// Makes a contact on the edge or corner of a triangle (world) one with its plane; of a triangle of no area it
/// stays what it is.
void takeFacePlane(const Triangle& face, const glm::dvec3& position, SurfacePoint& at);

/// What a contact on an edge counts as whose face rises out of another contact's: that face's whole plane,
/// which is right before an inner edge, or the edge alone.
enum class Covered { asFace, asEdge };

/// The way from the proxy to the point nearest to the goal that the known planes allow, m. Notes the
/// multipliers, and whether a face presses beyond its edge. Zero where the planes contradict each other.
glm::dvec3 wayToGoal(const ContactWorld& world, const glm::dvec3& goal, double radius, Proxy& proxy,
                     Covered covered = Covered::asFace);

/// Of the planes known, m; 0 without any.
double smallestSkin(const Proxy& proxy);

/// Whether any plane presses.
bool touches(const Proxy& proxy);

/// The index of the plane that presses alone; -1 if none or several do.
int onlyPressing(const Proxy& proxy);

}  // namespace tandem::haptics
