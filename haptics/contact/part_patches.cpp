#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "haptics/contact/part_contact.h"
#include "haptics/contact/patch_touch.h"

// Contact of parts that are known by formula, or whose samples stand for pieces of round surfaces.

namespace tandem::haptics {
namespace {

// Of a field's tolerance: by how much a place on a patch may be less deep than the deepest one.
constexpr double kEven = 0.05;
// Of a tolerance: nearer to a sheet the side on which a sample is cannot be told from its place.
constexpr float kHair = 8.0f;

/// A sheet holds a sample off on the side from which that looks at it.
void turnAgainst(const glm::dvec3& outward, double tolerance, glm::dvec3& normal, double& gap) {
  if (gap > static_cast<double>(kHair) * tolerance || glm::dot(outward, normal) <= 0.05) return;
  normal = -normal;
  gap = -gap;
}

}  // namespace

double PartContact::evenness(const PartModel& to) { return kEven * to.field.tolerance(); }

void PartContact::addShapeRows(const AskedSide& side, std::uint32_t i, float& deepest) {
  const ContactSample& sample = side.from->samples.samples()[i];
  const double slack = evenness(*side.to), allowed = static_cast<double>(side.allowed);
  ContactPatch patch;
  const bool patched = side.from->patchOf(sample, patch);
  if (patched) patch = patch.moved(side.toFromSamples);
  const glm::dvec3 at = transformPoint(side.toFromSamples, sample.point),
                   outward = side.toFromSamples.orientation * outwardOf(side.from->samples.normals(sample));
  for (const Primitive& shape : side.to->field.shapes()) {
    glm::dvec3 point = at;
    SurfaceDistance read = shape.against(at, outward);
    if (patched) {
      // The shape is convex: its distance lies above the plane that touches it in one place.
      const double drop = glm::dot(read.gradient, patch.pointAt(patch.lowest(read.gradient, 0.0)) - at);
      if (read.distance + drop + allowed > static_cast<double>(side.limit)) {
        deepest = std::max(deepest, static_cast<float>(-read.distance - drop));
        continue;
      }
      if (drop < -slack) {
        const PatchTouch touch = deepestIn(shape, patch, slack, outward);
        point = touch.point;
        read = touch.read;
      }
    }
    deepest = std::max(deepest, static_cast<float>(-read.distance));
    if (side.contained || read.distance + allowed > static_cast<double>(side.limit)) continue;
    if (!shape.solid()) turnAgainst(outward, side.to->field.tolerance(), read.gradient, read.distance);
    rows_.addPlane(side.world(read.gradient), side.arm(point), static_cast<float>(read.distance + allowed),
                   {side.pair, side.side, i});
  }
}

void PartContact::addPatchRow(const AskedSide& side, std::uint32_t i, const glm::vec3& place,
                              const DistanceField::Reading& read, float& deepest) {
  const ContactSample& sample = side.from->samples.samples()[i];
  const float least = read.distance - read.error - sample.along;
  if (side.contained) {
    deepest = std::max(deepest, -least);
    return;
  }
  const double slack = evenness(*side.to);
  const ContactPatch patch = side.from->samples.patches()[sample.patch].moved(side.toFromSamples);
  PatchTouch touch;
  float error = read.error;
  if (error <= side.rough) touch = deepestIn(side.to->field, patch, slack, error);
  if (error > side.rough) {
    deepest = std::max(deepest, -least);
    return addLookRows(side, i, place, &patch, least + side.allowed);
  }
  const float distance = static_cast<float>(touch.read.distance);
  deepest = std::max(deepest, error - distance);
  if (distance - error + side.allowed > side.limit) return;
  const float gap = error <= side.smooth ? distance + error : distance - error;
  rows_.addPlane(side.world(touch.read.gradient), side.arm(touch.point), gap + side.allowed,
                 {side.pair, side.side, i});
}

bool PartContact::touchShapes(const PartModel& from, const PartModel& to, const Pose& toFromSamples,
                              const ContactSample& sample, const SampleAtMesh& asked,
                              TouchingFeature& found) {
  ContactPatch patch;
  const bool patched = from.patchOf(sample, patch);
  if (patched) patch = patch.moved(toFromSamples);
  // The two shapes into which it is predicted to go furthest: a nook has two sides.
  std::array<double, 2> predicted = {1e300, 1e300};
  found = TouchingFeature{};
  found.distance = 0.0;
  const std::span<const Primitive> shapes = to.field.shapes();
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const Primitive& shape = shapes[i];
    TouchingFeature one = touchingShape(shapes, i, patched ? &patch : nullptr, asked);
    if (one.count == 0) continue;
    TouchingPlane& plane = one.planes[0];
    if (!shape.solid())
      turnAgainst(toFromSamples.orientation * outwardOf(from.samples.normals(sample)), to.field.tolerance(),
                  plane.normal, plane.gap);
    const double gap = plane.gap + glm::dot(plane.normal, asked.motion);
    if (gap < predicted[0]) {
      predicted[1] = predicted[0];
      found.planes[1] = found.planes[0];
      predicted[0] = gap;
      found.planes[0] = plane;
      found.triangle = one.triangle;
    } else if (gap < predicted[1]) {
      predicted[1] = gap;
      found.planes[1] = plane;
    } else {
      continue;
    }
    found.distance = std::max(found.distance, one.distance);
    found.count = std::min(found.count + 1, 2);
  }
  return found.count > 0;
}

bool PartContact::touchPatch(const PartModel& from, const PartModel& to, const Pose& toFromSamples,
                             const ContactSample& sample, SampleAtMesh asked, std::uint32_t hint,
                             TouchingFeature& found) const {
  const ContactPatch patch = from.samples.patches()[sample.patch].moved(toFromSamples);
  float error = 0.0f;
  const PatchTouch start = deepestIn(to.field, patch, evenness(to), error);
  asked.outside = start.read.distance > static_cast<double>(error);
  if (effort_.exact) return touchingPatch(*to.tree, to.edges, patch, start.place, asked, hint, found);
  asked.point = start.point;
  return fieldFeature(to, asked, found);
}

double PartContact::depthOf(const PartModel& from, const PartModel& to, const Pose& toFromSamples,
                            const ContactSample& sample, glm::dvec3& deepestPoint) {
  deepestPoint = transformPoint(toFromSamples, sample.point);
  ContactPatch patch;
  const bool patched = from.patchOf(sample, patch);
  if (patched) patch = patch.moved(toFromSamples);
  if (!to.byFormula()) {
    float error = 0.0f;
    if (sample.patch != assets::kNone) deepestPoint = deepestIn(to.field, patch, evenness(to), error).point;
    return 0.0;
  }
  const glm::dvec3 outward = toFromSamples.orientation * outwardOf(from.samples.normals(sample));
  double depth = 0.0;
  for (const Primitive& shape : to.field.shapes()) {
    const double distance = patched ? deepestIn(shape, patch, evenness(to), outward).read.distance
                                    : shape.against(deepestPoint, outward).distance;
    depth = std::max(depth, -distance);
  }
  return depth;
}

}  // namespace tandem::haptics
