#include "haptics/contact/pair_finder.h"

#include <algorithm>

#include <glm/geometric.hpp>

namespace tandem::haptics {
namespace {

/// Whether the first `count` pairs of an island hold the pair of these two bodies already.
bool isKnown(const ContactIsland& island, int count, int first, int second) {
  const auto known = island.pairs().first(static_cast<std::size_t>(count));
  return std::any_of(known.begin(), known.end(),
                     [&](const ContactPair& pair) { return pair.first == first && pair.second == second; });
}

}  // namespace

bool PairFinder::mayTouch(PartId a, PartId b) const {
  return !world_.hidden(b) && world_.mayCollide(a, b) && joints_.letTouch(a, b);
}

double PairFinder::push(PartId part, double dt) const {
  const Twist& twist = world_.twist(part);
  const Collider& other = world_.collider(part);
  const double arm = glm::length(other.centre) + other.radius;
  return dt * (glm::length(twist.linear) + arm * glm::length(twist.angular));
}

double PairFinder::leastGap(const ContactBody& body, const Pose& bodyFromWorld, PartId other) const {
  const assets::Bounds& own = body.model->tree->bounds();
  const Collider& ball = world_.collider(other);
  const glm::dvec3 centre = transformPoint(bodyFromWorld * world_.pose(other), ball.centre);
  return glm::length(centre - glm::clamp(centre, own.min, own.max)) - ball.radius;
}

void PairFinder::findTouching(double reach, double dt, ContactIsland& island) const {
  for (int i = 0; i < island.bodyCount(); ++i) {
    const ContactBody& body = island.body(i);
    if (body.model == nullptr) continue;
    const Collider& collider = world_.collider(body.part);
    const glm::dvec3 middle = transformPoint(body.pose, collider.centre), grow(collider.radius + reach);
    const int before = island.pairCount();
    const Pose bodyFromWorld = inverse(body.pose);
    world_.forEachNear({middle - grow, middle + grow}, [&](PartId part) {
      const PartModel* model = world_.model(part);
      if (part == body.part || model == nullptr || !mayTouch(body.part, part)) return;
      const int second = island.bodyOf(part);
      if (second >= 0 && isKnown(island, before, second, i)) return;
      // A control passes through its housing, and through other controls.
      if (body.axis && (second < 0 || island.body(second).axis)) return;
      ContactPair pair;
      pair.first = i;
      pair.second = second;
      pair.other = part;
      pair.model = model;
      if (second < 0) pair.push = push(part, dt);
      pair.gap = leastGap(body, bodyFromWorld, part);
      if (pair.gap <= reach + pair.push) island.addPair(pair);
    });
  }
}

void PairFinder::findJoined(double dt, ContactIsland& island) const {
  for (int i = 0; i < island.bodyCount(); ++i) {
    const ContactBody& body = island.body(i);
    if (body.axis) {
      ContactPair pair;
      pair.first = i;
      pair.joint = ContactPair::kAxis;
      island.addPair(pair);
    }
    for (const std::uint32_t joint : joints_.of(body.part)) {
      const PartId other = joints_.otherPart(joint, body.part);
      const int second = other != kNoPart ? island.bodyOf(other) : -1;
      if (second >= 0 && second < i) continue;  // the pair stands with the other body
      ContactPair pair;
      pair.first = i;
      pair.second = second;
      pair.other = other;
      pair.joint = static_cast<std::int32_t>(joint);
      if (second < 0 && other != kNoPart) pair.push = push(other, dt);
      if (joints_.sprung(joint)) pair.push = std::max(pair.push, body.escapeDistance(dt));
      island.addPair(pair);
    }
  }
}

}  // namespace tandem::haptics
