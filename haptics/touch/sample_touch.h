#pragma once

// Contact of one sample, with the patch that it stands for, against the target: by formula where the target
// is made of implicit shapes, by its field and mesh elsewhere.
//
// 1. Free of state and of allocation.

#include <cstdint>

#include "haptics/scene/part_model.h"
#include "haptics/touch/touching_feature.h"

namespace tandem::haptics {

/// The samples of one part before the surface of another, the target.
struct SampledModels {
  const PartModel* from = nullptr;  // whose samples
  const PartModel* to = nullptr;    // the target
  Pose toFromSamples;               // part frames
};

/// m, by how much a place on a patch may be less deep in the target than the deepest place.
double evenness(const PartModel& target);

/// The patch that a sample stands for, in the frame of the target; false where the sample is a point.
bool patchBefore(const SampledModels& models, const ContactSample& sample, ContactPatch& patch);

/// The outward direction of a sample's surface, in the frame of the target; of any length, 0 on a sheet.
glm::dvec3 outwardBefore(const SampledModels& models, const ContactSample& sample);

/// Orients a plane of a sheet against a sample whose surface has this outward direction. Far from the sheet
/// the plane stays as it is.
void orientAgainst(const glm::dvec3& outward, double tolerance, glm::dvec3& normal, double& gap);

/// The half-spaces of the two shapes of a target into which the sample is predicted to go furthest, because
/// a nook has two sides. False if no shape constrains the sample.
bool touchShapes(const SampledModels& models, const ContactSample& sample, const SampleQuery& sampleQuery,
                 TouchingFeature& found);

/// The half-space at the deepest place of a round sample's patch. `hint` is a triangle that may be near.
/// Without `exact` the field alone gives it.
bool touchPatch(const SampledModels& models, const ContactSample& sample, SampleQuery sampleQuery,
                std::uint32_t hint, bool exact, TouchingFeature& found);

/// The half-space by the field of the target alone, good to within the field's error. False where its
/// gradient is too small to be a direction.
bool fieldFeature(const PartModel& target, const SampleQuery& sampleQuery, TouchingFeature& found);

/// m, depth of a sample with its patch in a target that is known by formula; 0 in any other target, where
/// `deepestPoint` (m, frame of the target) is the place to measure.
double depthOf(const SampledModels& models, const ContactSample& sample, glm::dvec3& deepestPoint);

}  // namespace tandem::haptics
