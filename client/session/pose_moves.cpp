#include "client/session/pose_moves.h"

#include <cmath>

#include <glm/geometric.hpp>

namespace tandem::client {
namespace {

constexpr double kMoved = 1e-6, kTurned = 1e-6;  // m, rad

bool samePlace(const Pose& a, const Pose& b) {
  const glm::dquat turn = a.orientation * glm::conjugate(b.orientation);
  return glm::length(a.position - b.position) < kMoved &&
         2.0 * glm::length(glm::dvec3(turn.x, turn.y, turn.z)) < kTurned;
}

}  // namespace

void PoseMoves::onOwnership(const sync::PartRecord& record, SiteId self) {
  records_[record.part] = record;
  if (record.owner != self) {
    mine_.erase(record.part);
  } else if (const auto mine = mine_.find(record.part);
             mine == mine_.end() || mine->second.epoch != record.epoch) {
    mine_[record.part] = record;  // not a part that is reclaimed: it still stands where it was granted
  }
}

std::optional<DocumentUndo::Step> PoseMoves::onRelease(const sync::Release& release) {
  const auto mine = mine_.find(release.part);
  if (mine == mine_.end() || mine->second.epoch != release.epoch) return std::nullopt;
  const Pose stood = mine->second.worldFromPart;
  mine_.erase(mine);
  if (samePlace(stood, release.worldFromPart)) return std::nullopt;
  return DocumentUndo::Step{0, release.epoch - 1, release.epoch, {}, release.part, stood};
}

const sync::PartRecord* PoseMoves::record(PartId part) const {
  const auto found = records_.find(part);
  return found == records_.end() ? nullptr : &found->second;
}

}  // namespace tandem::client
