#pragma once

// Where a sample of one part that stands for a piece of its surface meets another part: the deepest place of
// the piece, and the half-space that holds it off there. For the files of this room only.

#include <cstdint>
#include <span>

#include "haptics/contact/touching_feature.h"
#include "haptics/geometry/primitive_distance.h"
#include "haptics/scene/contact_patch.h"
#include "haptics/scene/distance_field.h"

namespace tandem::haptics {

/// The deepest place of a patch, and what is known of the surface under it.
struct PatchTouch {
  ContactPatch::Place place;
  glm::dvec3 point{0.0, 0.0, 0.0};  // m
  SurfaceDistance read;
};

/// The mean direction of a place that has these normals; of any length, 0 on a sheet.
glm::dvec3 outwardOf(std::span<const glm::dvec3> normals);

/// Where a patch is deepest in a convex shape, in one frame: the least distance to within `slack` m (a rim's
/// patch, whose distance is not convex, where it has only one least one).
ContactPatch::Place deepestPlace(const Primitive& shape, const ContactPatch& patch, double slack);

/// That place, and what holds it off, read for a surface whose middle looks along `outward`.
PatchTouch deepestIn(const Primitive& shape, const ContactPatch& patch, double slack,
                     const glm::dvec3& outward = glm::dvec3(0.0));

/// In a field, by its gradients: nearer with each reading, as far as the field's cells tell.
PatchTouch deepestIn(const DistanceField& field, const ContactPatch& patch, double slack, float& error);

/// As touchingFeature(), of one of the convex shapes of a part: `patch` null for a sample that is a point.
/// What it is near to on the shape is found from `asked` and the patch; asked.edge and along are set from it.
/// A face that other shapes cover holds nothing off: where two boxes make one floor, nothing catches at the
/// seam. No plane where all do.
TouchingFeature touchingShape(std::span<const Primitive> shapes, std::size_t which, const ContactPatch* patch,
                              SampleQuery sampleQuery);

/// As touchingFeature(), of the deepest place of a patch; `start`: from which to look for it.
bool touchingPatch(const TriangleBvh& tree, const MeshEdges& edges, const ContactPatch& patch,
                   const ContactPatch::Place& start, SampleQuery sampleQuery, std::uint32_t hint,
                   TouchingFeature& found);

}  // namespace tandem::haptics
