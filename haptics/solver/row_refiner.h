#pragma once

// The solver's view of the surfaces while it iterates: exact rows on demand.

#include <cstddef>
#include <span>

#include "haptics/solver/contact_rows.h"

namespace tandem::haptics {

/// Makes the rows of a sample exact at the displacement of its pair that the solver has reached.
class RowRefiner {
 public:
  static constexpr std::size_t kMostAhead = 32;
  /// At most kMostAhead samples of which refine() is likely to be called next, at these displacements. Saves
  /// time where other cores are idle, and changes no result.
  virtual void prepare(std::span<const RowSource> /*sources*/, PairMotions /*u*/) {}
  /// Whether prepare() is worth a call.
  virtual bool prepares() const { return false; }
  /// Adds the exact rows of a sample.
  virtual void refine(RowSource source, const Displacement& u, ContactRows& rows) = 0;
  /// Whether a sample must be made exact although u leaves `room` m between it and its plane, of this normal
  /// (world, as in a row), because its part may touch beside it.
  virtual bool mayTouchBeside(RowSource, const glm::vec3& /*normal*/, float /*room*/,
                              const Displacement& /*u*/) {
    return false;
  }
  /// The displacement in this tick of the surface under a row of a pair without a second body, m, world
  /// axes.
  virtual glm::dvec3 surfaceMotion(const ExactRow& row) const = 0;

 protected:
  ~RowRefiner() = default;
};

}  // namespace tandem::haptics
