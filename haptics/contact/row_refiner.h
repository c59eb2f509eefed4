#pragma once

// What the solver asks of the surfaces while it iterates.

#include "haptics/contact/contact_rows.h"

namespace tandem::haptics {

/// Makes the rows of a sample exact at the displacement of its pair that the solver has reached.
class RowRefiner {
 public:
  /// Adds the exact rows of a sample.
  virtual void refine(RowSource source, const Displacement& u, ContactRows& rows) = 0;
  /// m, world axes: how far the surface under a row of a pair without a second body has gone in this tick.
  virtual glm::dvec3 surfaceMotion(const ExactRow& row) const = 0;

 protected:
  ~RowRefiner() = default;
};

}  // namespace tandem::haptics
