#include "haptics/touch/sample_touch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include <glm/geometric.hpp>

#include "haptics/touch/patch_touch.h"

namespace tandem::haptics {
namespace {

// Share of a field's tolerance by which a place on a patch may be less deep than the deepest one.
constexpr double kEven = 0.05;
// Tolerances from a sheet within which the place of a sample does not decide its side.
constexpr float kHair = 8.0f;

}  // namespace

double evenness(const PartModel& target) { return kEven * target.field.tolerance(); }

bool patchBefore(const SampledModels& models, const ContactSample& sample, ContactPatch& patch) {
  if (!models.from->patchOf(sample, patch)) return false;
  patch = patch.moved(models.toFromSamples);
  return true;
}

glm::dvec3 outwardBefore(const SampledModels& models, const ContactSample& sample) {
  return models.toFromSamples.orientation * outwardOf(models.from->samples.normals(sample));
}

void orientAgainst(const glm::dvec3& outward, double tolerance, glm::dvec3& normal, double& gap) {
  if (gap > static_cast<double>(kHair) * tolerance || glm::dot(outward, normal) <= 0.05) return;
  normal = -normal;
  gap = -gap;
}

bool touchShapes(const SampledModels& models, const ContactSample& sample, const SampleQuery& sampleQuery,
                 TouchingFeature& found) {
  ContactPatch patch;
  const bool patched = patchBefore(models, sample, patch);
  std::array<double, 2> predicted = {1e300, 1e300};
  found = TouchingFeature{};
  found.distance = 0.0;
  const std::span<const Primitive> shapes = models.to->field.shapes();
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    TouchingFeature one = touchingShape(shapes, i, patched ? &patch : nullptr, sampleQuery);
    if (one.count == 0) continue;
    TouchingPlane& plane = one.planes[0];
    if (!shapes[i].solid())
      orientAgainst(outwardBefore(models, sample), models.to->field.tolerance(), plane.normal, plane.gap);
    const double gap = plane.gap + glm::dot(plane.normal, sampleQuery.motion);
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

bool touchPatch(const SampledModels& models, const ContactSample& sample, SampleQuery sampleQuery,
                std::uint32_t hint, bool exact, TouchingFeature& found) {
  const PartModel& to = *models.to;
  const ContactPatch patch = models.from->samples.patches()[sample.patch].moved(models.toFromSamples);
  float error = 0.0f;
  const PatchTouch start = deepestIn(to.field, patch, evenness(to), error);
  sampleQuery.outside = start.read.distance > static_cast<double>(error);
  if (exact) return touchingPatch(*to.tree, to.edges, patch, start.place, sampleQuery, hint, found);
  sampleQuery.point = start.point;
  return fieldFeature(to, sampleQuery, found);
}

bool fieldFeature(const PartModel& target, const SampleQuery& sampleQuery, TouchingFeature& found) {
  const DistanceField::Reading read = target.field.read(glm::vec3(sampleQuery.point - target.field.origin()));
  const glm::dvec3 up(read.gradient);
  const double slope = glm::length(up), distance = static_cast<double>(read.distance);
  if (!(slope > 0.1)) return false;
  found.planes[0] = {sampleQuery.point, up / slope, distance};
  found.distance = std::abs(distance);
  found.triangle = 0;
  found.count = 1;
  return true;
}

double depthOf(const SampledModels& models, const ContactSample& sample, glm::dvec3& deepestPoint) {
  const PartModel& to = *models.to;
  deepestPoint = transformPoint(models.toFromSamples, sample.point);
  ContactPatch patch;
  const bool patched = patchBefore(models, sample, patch);
  if (!to.byFormula()) {
    float error = 0.0f;
    if (sample.patch != assets::kNone) deepestPoint = deepestIn(to.field, patch, evenness(to), error).point;
    return 0.0;
  }
  const glm::dvec3 outward = outwardBefore(models, sample);
  double depth = 0.0;
  for (const Primitive& shape : to.field.shapes()) {
    const double distance = patched ? deepestIn(shape, patch, evenness(to), outward).read.distance
                                    : shape.against(deepestPoint, outward).distance;
    depth = std::max(depth, -distance);
  }
  return depth;
}

}  // namespace tandem::haptics
