#pragma once

// The law of one force field: its force and its potential at a place, in the field's own frame. The
// equations stand in haptics/fields/README.md.

#include <array>
#include <optional>

#include "assets/scene/force_field.h"
#include "haptics/fields/field_path.h"

namespace tandem::haptics {

/// What a field does at one place, in its own axes, before any weight of the hand's own.
struct FieldAction {
  glm::dvec3 stored{0.0, 0.0, 0.0};        // N, minus the gradient of `potential`
  glm::dvec3 source{0.0, 0.0, 0.0};        // N, of what can give energy without end
  glm::dvec3 sourceChange{0.0, 0.0, 0.0};  // N, by which time alone has changed `source` since `timeBefore`
  glm::dvec3 damping{0.0, 0.0, 0.0};       // N, against the velocity
  double potential = 0.0;                  // J; beyond the region or range it is constant
  double dampingRate = 0.0;                // N·s/m, the most along any direction
  bool limited = false;  // maxForce cut the gradient short: what is stored is then not exact
};

/// Where the hand is and what it does, in the field's frame.
struct FieldQuery {
  glm::dvec3 position{0.0, 0.0, 0.0};  // m
  glm::dvec3 velocity{0.0, 0.0, 0.0};  // m/s, relative to the field
  double time = 0.0;                   // s
  double timeBefore = 0.0;             // s, of the last tick
};

/// One field made ready. Only the constructor allocates; the field must outlive this.
class FieldForce {
 public:
  explicit FieldForce(const assets::ForceField& field);

  /// The action at a place. `at` is the parameter on the field's path (see path()), unused without one.
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
  double atRange_ =
      0.0;  // J, what the law without range holds where its fade begins, less what the one with it does
  double gauge_ = 0.0;  // J, taken off the potential so that a region's border draws inwards
};

/// A waveform's value in -1..1 at a time in s; 0 before its start, after its stop, and at a time that is not
/// finite.
double waveformValue(const assets::FieldWaveform& waveform, double time);

/// Weight of a region at a place, 0..1, and its gradient in 1/m.
double regionWeight(const assets::FieldRegion& region, const glm::dvec3& x, glm::dvec3& gradient);

}  // namespace tandem::haptics
