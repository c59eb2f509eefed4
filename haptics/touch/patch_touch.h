#pragma once

// Contact of a sample that stands for a patch, a piece of its part's surface: the deepest place of the
// patch in the other part, and the separating half-space there.

#include <cstdint>
#include <span>

#include "haptics/geometry/primitive_distance.h"
#include "haptics/scene/contact_patch.h"
#include "haptics/scene/distance_field.h"
#include "haptics/touch/touching_feature.h"

namespace tandem::haptics {

/// The deepest place of a patch, and what is known of the surface under it.
struct PatchTouch {
  ContactPatch::Place place;
  glm::dvec3 point{0.0, 0.0, 0.0};  // m
  SurfaceDistance read;
};

/// The mean direction of a place that has these normals; of any length, 0 on a sheet.
glm::dvec3 outwardOf(std::span<const glm::dvec3> normals);

/// The place where a patch is deepest in a convex shape, both in one frame. Its distance is the least one
/// to within `slack` m. The distance along a rim is not convex, and the place is the least one only if
/// there is no other minimum.
ContactPatch::Place deepestPlace(const Primitive& shape, const ContactPatch& patch, double slack);

/// That place with the distance there. `outward` is the outward direction of the middle of the patch.
PatchTouch deepestIn(const Primitive& shape, const ContactPatch& patch, double slack,
                     const glm::dvec3& outward = glm::dvec3(0.0));

/// The deepest place of a patch in a field, by descent along the field's gradients.
PatchTouch deepestIn(const DistanceField& field, const ContactPatch& patch, double slack, float& error);

/// The touching feature of one convex shape of a part. `patch` is null for a sample that is a point;
/// otherwise its deepest place replaces the query's point, normals and edge. A face that other shapes cover
/// has no contact, so that nothing catches at the seam of two boxes that make one floor. Without an
/// uncovered face the result has no plane.
TouchingFeature touchingShape(std::span<const Primitive> shapes, std::size_t which, const ContactPatch* patch,
                              SampleQuery sampleQuery);

/// The touching feature of the deepest place of a patch on a mesh; the search for it begins at `start`.
bool touchingPatch(const TriangleBvh& tree, const MeshEdges& edges, const ContactPatch& patch,
                   const ContactPatch::Place& start, SampleQuery sampleQuery, std::uint32_t hint,
                   TouchingFeature& found);

}  // namespace tandem::haptics
