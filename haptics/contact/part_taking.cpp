#include "haptics/contact/part_taking.h"

#include <algorithm>

#include "haptics/contact/side_clocks.h"

namespace tandem::haptics {
namespace {

constexpr double kStands = 0.02;  // tolerances by which a part that stands may move

}  // namespace

void PartTaking::begin(PartId part, const glm::dvec3& centreOfMass, double dt, bool exits) {
  centreOfMass_ = centreOfMass;
  dt_ = dt;
  exits_ = exits;
  overlaps_.forget(part);
  parts_.clear();
  parts_.push_back(standing(part, 0.0));
  neighbour_ = 0;
  if (!TICK_ASSERT(fault_, taken().model != nullptr)) return;
  island_.clear();
  island_.addBody(part, centreOfMass, taken().pose);
  finder_.findTouching(ContactStep::shortReach(island_), dt, island_);
  for (const ContactPair& pair : island_.pairs()) parts_.push_back(standing(pair.other, pair.gap));
}

bool PartTaking::advance(const ContactEffort& effort, CountedWork& work) {
  if (!measureOn(work)) return false;
  if (work.hurried()) return true;
  fillIsland();
  return step_.readAhead(dt_, effort, work);
}

bool PartTaking::measureOn(CountedWork& work) {
  while (neighbour_ < parts_.size()) {
    if (neighbour_ > 0) {
      if (!measure_.advance(work)) return false;
      overlaps_.remember(taken().part, parts_[neighbour_].part, measure_.measured(), measure_.fit());
    }
    if (++neighbour_ < parts_.size()) beginPair();
  }
  return true;
}

void PartTaking::beginPair() {
  const Standing& other = parts_[neighbour_];
  const PartPair pair{taken().model, other.model, inverse(other.pose) * taken().pose};
  measure_.begin(pair, world_.collider(taken().part).centre, exits_,
                 overlaps_.knownFit(taken().part, other.part));
}

void PartTaking::fillIsland() {
  island_.clear();
  island_.addBody(taken().part, centreOfMass_, taken().pose);
  for (std::size_t i = 1; i < parts_.size(); ++i) {
    ContactPair pair;
    pair.other = parts_[i].part;
    pair.model = parts_[i].model;
    pair.gap = parts_[i].gap;
    island_.addPair(pair);
  }
  island_.place();
}

bool PartTaking::undisturbed() const {
  return std::all_of(parts_.begin(), parts_.end(), [&](const Standing& known) {
    const Collider& ball = world_.collider(known.part);
    return farthestMotion(known.pose, world_.pose(known.part), ball.centre, ball.radius) <=
           kStands * known.model->field.tolerance();
  });
}

bool PartTaking::hasSameModels() const {
  return std::all_of(parts_.begin(), parts_.end(),
                     [&](const Standing& known) { return world_.model(known.part) == known.model; });
}

}  // namespace tandem::haptics
