#pragma once

// Force law of one force field: its force and potential at a place, in the field's own frame. The equations
// stand in haptics/fields/README.md.

#include <array>
#include <optional>

#include "assets/scene/force_field.h"
#include "haptics/fields/field_path.h"

namespace tandem::haptics {

/// Action of a field at one place, in its own axes, before the hand's own weight.
struct FieldAction {
  glm::dvec3 stored{0.0, 0.0, 0.0};        // N, minus the gradient of `potential`
  glm::dvec3 source{0.0, 0.0, 0.0};        // N, of non-conservative terms, which can give energy without end
  glm::dvec3 sourceChange{0.0, 0.0, 0.0};  // N, change of `source` since `timeBefore` by time alone
  glm::dvec3 damping{0.0, 0.0, 0.0};       // N, against the velocity
  double potential = 0.0;                  // J; constant beyond the region or range
  double dampingRate = 0.0;                // N·s/m, the greatest along any direction
  bool limited = false;  // maxForce cut the gradient short, so the stored energy is not exact
};

/// State of the hand in the field's frame.
struct FieldQuery {
  glm::dvec3 position{0.0, 0.0, 0.0};  // m
  glm::dvec3 velocity{0.0, 0.0, 0.0};  // m/s, relative to the field
  double time = 0.0;                   // s
  double timeBefore = 0.0;             // s, of the last tick
};

/// One field, preprocessed. Only the constructor allocates; the field must outlive this object.
class FieldForce {
 public:
  explicit FieldForce(const assets::ForceField& field);

  /// The action at a place. `at` is the parameter on the field's path (see path()), unused without a path.
  FieldAction act(const FieldQuery& query, double at) const;

  const assets::ForceField& field() const { return *field_; }
  /// The path of a guide or of a spring to a path, else null.
  const FieldPath* path() const { return path_ ? &*path_ : nullptr; }

 private:
  FieldAction raw(const FieldQuery& query, double at) const;
  FieldAction springAction(const FieldQuery& query, double at) const;
  FieldAction gravityAction(const glm::dvec3& x) const;
  FieldAction potentialAction(const glm::dvec3& x) const;
  double radialForce(double distance) const;
  double radialPotential(double distance) const;
  double radialPotentialWithoutRange(double distance) const;
  std::array<double, 2> kinks() const;
  double integral(double from, double to) const;
  double rangeWeight(double distance) const;

  const assets::ForceField* field_;
  std::optional<FieldPath> path_;
  // J: potential of the law without range at the start of its fade, less that of the law with the fade.
  double atRange_ = 0.0;
  double gauge_ = 0.0;  // J, offset of the potential, such that a region's border draws inwards
};

/// Value of a waveform in -1..1 at a time in s; 0 before its start, after its stop, and at a non-finite time.
double waveformValue(const assets::FieldWaveform& waveform, double time);

/// Weight of a region at a place, 0..1, and its gradient in 1/m.
double regionWeight(const assets::FieldRegion& region, const glm::dvec3& x, glm::dvec3& gradient);

}  // namespace tandem::haptics
