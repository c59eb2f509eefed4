#pragma once

// Exact queries of single samples: the separating half-spaces between a sample and the mesh or shapes of
// the target, as exact rows, at the displacement that the solver has reached.
//
// 1. Alone writes the samples' memory. 2. Free of allocation.

#include <cstdint>

#include "haptics/base/contact_effort.h"
#include "haptics/base/fault.h"
#include "haptics/base/fixed_vector.h"
#include "haptics/base/tick_helpers.h"
#include "haptics/contact/contact_island.h"
#include "haptics/contact/overlaps.h"
#include "haptics/contact/side_query.h"
#include "haptics/solver/row_refiner.h"
#include "haptics/touch/sample_descent.h"
#include "haptics/touch/sample_memory.h"
#include "haptics/touch/seat_memory.h"
#include "haptics/touch/touching_feature.h"

namespace tandem::haptics {

class SampleRefiner final : public RowRefiner {
 public:
  SampleRefiner(const ContactWorld& world, const ContactIsland& island, const Overlaps& overlaps,
                FaultLatch& fault)
      : world_(world), island_(island), overlaps_(overlaps), fault_(fault), memory_(world) {}

  /// Begins a step of a tick of dt seconds in which nothing moves further than `reach` m.
  void beginStep(double dt, double reach, const ContactEffort& effort);
  /// Begins to ask ahead for samples of the next step, which has this reach: what is known does not age.
  void beginAhead(double dt, double reach, const ContactEffort& effort);

  /// The threads that prepare() runs its queries on from now on; null: nothing is prepared.
  void share(TickHelpers* helpers) { helpers_ = helpers; }

  bool prepares() const override { return helpers_ != nullptr && exact_; }
  void prepare(std::span<const RowSource> sources, PairMotions u) override;
  void refine(RowSource source, const Displacement& u, ContactRows& rows) override;
  /// Whether the field leaves open that the sample is deep, or its smooth surface may be deeper near by. What
  /// is known of it by its last answer or descent decides where that still holds.
  bool mayTouchBeside(RowSource source, const glm::vec3& normal, float room, const Displacement& u) override;
  glm::dvec3 surfaceMotion(const ExactRow& row) const override;

  const SampleMemory& memory() const { return memory_; }
  /// Queries of the present step.
  int queries() const { return queries_; }

 private:
  static constexpr std::size_t kMaxNormals = 16;  // of one sample
  using Normals = FixedVector<glm::dvec3, kMaxNormals>;
  /// The sample as the target sees it. `u` is the displacement expected of the pair's first part. Fills
  /// `normals`, empty before, which must outlive the result.
  SampleQuery sampleQueryFor(const SideQuery& query, const ContactSample& sample, const Displacement& u,
                             Normals& normals) const;
  /// The answer of a query that prepare() has run before the solver asked for it.
  struct Prepared {
    RowSource source;
    Displacement u;
    TouchingFeature found;
    std::uint32_t hint = kNoTriangle;
    bool known = false, touches = false;
  };
  void prepareOne(Prepared& prepared) const;
  /// The prepared answer for a sample at exactly this displacement; null if there is none.
  const Prepared* preparedFor(RowSource source, const Displacement& u) const;
  /// m, frame of the target: how far a place (m, the same) is expected to go.
  glm::dvec3 motionAt(const SideQuery& query, const glm::dvec3& point, const Displacement& u) const;
  /// Sets what the field knows of the place of a query.
  void readField(const SideQuery& query, SampleQuery& sampleQuery) const;
  /// False if nothing constrains the sample. `prepared`: its prepared answer, or null.
  bool touch(const SideQuery& query, const ContactSample& sample, const SampleQuery& sampleQuery,
             const SampleAnswer* last, const Prepared* prepared, TouchingFeature& found);
  /// The same on a mesh, at the deepest place near the sample.
  bool touchMesh(const SideQuery& query, const ContactSample& sample, const SampleQuery& sampleQuery,
                 const SampleAnswer* last, const Prepared* prepared, TouchingFeature& found);
  /// The same at one place, of which `hint` is a triangle near by; it becomes the one that was found.
  static bool touchAt(const SideQuery& query, const SampleQuery& at, std::uint32_t& hint,
                      TouchingFeature& found);
  /// The deepest place near a sample that has been found to touch at `found`: known or newly descended to.
  Seat seatOf(const SideQuery& query, const ContactSample& sample, const SampleQuery& sampleQuery,
              std::uint32_t hint, const TouchingFeature& found);
  /// Whether a sample at `place` (m, relative to the origin of the target's field) goes by `motion` through a
  /// plane of its last answer.
  static bool entersPlanes(const SideQuery& query, const SampleAnswer& answer, const glm::vec3& place,
                           const glm::vec3& motion);
  /// Whether a seat is inside the target after u, by more than its field leaves open.
  bool entersAt(const SideQuery& query, const KnownSeat& known, const Displacement& u) const;
  /// Where the last descent of a sample ended; null if that is not known.
  const KnownSeat* lastSeat(const SideQuery& query, const ContactSample& sample) const;
  /// The sample's last seat while its part has moved little before the target; null otherwise.
  const KnownSeat* recallNear(const SideQuery& query, const ContactSample& sample) const;
  /// The sample's last seat while the target, in the direction `up`, touches it from the same side; null
  /// otherwise.
  const KnownSeat* recall(const SideQuery& query, const ContactSample& sample, const SampleQuery& sampleQuery,
                          const glm::dvec3& up) const;
  void note(const SideQuery& query, const ContactSample& sample, const SampleQuery& sampleQuery,
            const glm::dvec3& up, const Seat& seat, bool level);
  void remember(const SideQuery& query, std::uint32_t sample, const SampleQuery& sampleQuery,
                const TouchingFeature& found);
  void addRows(const SideQuery& query, const ContactSample& sample, const TouchingFeature& found,
               RowSource source, ContactRows& rows) const;

  const ContactWorld& world_;
  const ContactIsland& island_;
  const Overlaps& overlaps_;
  FaultLatch& fault_;
  SampleMemory memory_;
  double dt_ = 0.0;     // s
  double reach_ = 0.0;  // m
  bool exact_ = true, descend_ = true;
  SeatMemory seats_;
  TickHelpers* helpers_ = nullptr;  // null: nothing is prepared
  FixedVector<Prepared, kMostAhead> prepared_;
  int queries_ = 0, descents_ = 0, besideQueries_ = 0;  // of the present step
};

}  // namespace tandem::haptics
