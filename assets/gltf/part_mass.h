#pragma once

// Mass and extent of parts from what the file states, and of primitive colliders. For the loader's sources
// only.

#include <optional>
#include <vector>

#include "assets/scene/scene.h"

namespace tandem::assets {

struct PhysicsMotion;

/// Box of a primitive in the part's frame, m. A plane without extent counts as a point: it has no size to fit
/// a view to.
Bounds shapeBounds(const ImplicitShape& shape);

/// Mass properties of a body of primitives, each filled with `density` kg/m^3. Overlaps count twice; a
/// tapered cylinder or capsule counts as one of its mean radius. Planes have no mass.
MassProperties shapesMass(const std::vector<ImplicitShape>& shapes, double density);

/// `computed` if its mass and inertia are finite and positive; else nothing.
std::optional<MassProperties> usableMass(const MassProperties& computed);

/// The mass properties of a `motion`, completed from `computed`. Where no inertia is stated, the computed
/// inertia is scaled to the stated mass. An axis of infinite inertia (a zero in the file) gets 1e6 times the
/// largest other inertia. Nothing if neither gives a mass.
std::optional<MassProperties> statedMass(const PhysicsMotion& motion, const MassProperties& computed,
                                         double unitScale);

}  // namespace tandem::assets
