#pragma once

// A part begins to move here: what must be known of it before its first step, in portions that fit into
// ticks. In this order
//
// overlaps   how deep it and each of its neighbours stand in each other (overlap_measure.h);
// samples    those of it and of its neighbours are read before each other for the first time, and those of
//            which fields do not tell whether they touch are measured exactly (ContactStep::readAhead).
//
// As long as this takes, the part must stand still, so that what is known of it stays true. Where a model is
// exchanged meanwhile, all begins anew. A part that cannot stand still, or whose neighbour moves, is taken in
// a hurry: at once, its overlaps alone, and these as well as a limited portion of work allows.
//
// 1. Fills the island, which belongs to nobody between steps, and remembers overlaps; owns all else that it
//    keeps from tick to tick. 2. Free of allocation after construction.

#include <cstddef>

#include "haptics/base/contact_effort.h"
#include "haptics/base/fault.h"
#include "haptics/base/fixed_vector.h"
#include "haptics/contact/contact_island.h"
#include "haptics/contact/contact_step.h"
#include "haptics/contact/overlaps.h"
#include "haptics/contact/pair_finder.h"
#include "haptics/fit/counted_work.h"
#include "haptics/fit/overlap_measure.h"

namespace tandem::haptics {

class PartTaking {
 public:
  PartTaking(const ContactWorld& world, const PairFinder& finder, ContactIsland& island, Overlaps& overlaps,
             ContactStep& step, FaultLatch& fault)
      : world_(world), finder_(finder), island_(island), overlaps_(overlaps), step_(step), fault_(fault) {}

  /// Begins to take a part, from its pose in the world, in ticks of dt seconds. Without `exits` it does not
  /// count as wholly inside another one.
  void begin(PartId part, const glm::dvec3& centreOfMass, double dt, bool exits = true);
  /// Goes on; true once the part is taken.
  bool advance(const ContactEffort& effort, CountedWork& work);

  /// Whether the part and its neighbours stand where they stood at the beginning.
  bool undisturbed() const;
  /// Whether they have the models that they had.
  bool hasSameModels() const;

 private:
  /// A part as it was at the beginning; the first one is the part that is taken.
  struct Standing {
    PartId part = kNoPart;
    const PartModel* model = nullptr;
    Pose pose;
    double gap = 0.0;  // m, to the part that is taken, at least
  };
  /// Puts the part and its neighbours on the island.
  void fillIsland();
  /// Goes on with the overlaps; true once all are measured.
  bool measureOn(CountedWork& work);
  void beginPair();
  Standing standing(PartId part, double gap) const {
    return {part, world_.model(part), world_.pose(part), gap};
  }
  const Standing& taken() const { return parts_[0]; }

  const ContactWorld& world_;
  const PairFinder& finder_;
  ContactIsland& island_;
  Overlaps& overlaps_;
  ContactStep& step_;
  FaultLatch& fault_;
  FixedVector<Standing, kMaxPairs + 1> parts_;
  glm::dvec3 centreOfMass_{0.0};
  double dt_ = 0.0;  // s
  bool exits_ = true;
  std::size_t neighbour_ = 0;  // into parts_, whose overlap is being measured
  OverlapMeasure measure_;
};

}  // namespace tandem::haptics
