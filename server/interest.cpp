#include "server/interest.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "sync/wire/wire.h"

namespace tandem::server {
namespace {

/// A ball around both.
Reach::Ball around(const Reach::Ball& a, const Reach::Ball& b) {
  const double distance = glm::length(b.centre - a.centre);
  if (distance + b.radius <= a.radius) return a;
  if (distance + a.radius <= b.radius) return b;
  const double radius = 0.5 * (distance + a.radius + b.radius);
  return {a.centre + (b.centre - a.centre) * ((radius - a.radius) / distance), radius};
}

Reach::Ball ballOf(const assets::ImplicitShape& shape) {
  const double round = std::max(shape.radiusTop, shape.radiusBottom) + 0.5 * shape.height;
  return {shape.partFromShape.position, std::max(round, 0.5 * glm::length(shape.size))};
}

Reach::Ball ballOf(const assets::Scene& scene, const assets::Part& part) {
  Reach::Ball ball;
  bool any = part.mesh != assets::kNone;
  if (any) {
    const assets::Bounds& bounds = scene.meshes[part.mesh].bounds;
    ball = {0.5 * (bounds.min + bounds.max), 0.5 * glm::length(bounds.max - bounds.min)};
  }
  for (const assets::ImplicitShape& shape : part.shapes) {
    ball = any ? around(ball, ballOf(shape)) : ballOf(shape);
    any = true;
  }
  return ball;
}

double longestSide(const assets::Bounds& bounds) {
  const glm::dvec3 size = glm::max(bounds.max - bounds.min, glm::dvec3(0.0));
  return std::max({size.x, size.y, size.z});
}

void add(Reach& reach, const Reach::Ball& ball) {
  if (reach.count < Reach::kMaxBalls)
    reach.balls[reach.count++] = ball;
  else
    reach.balls.back() = around(reach.balls.back(), ball);
}

}  // namespace

Interest::Interest(const assets::Scene& scene) : margin_(kShareOfScene * longestSide(scene.bounds)) {
  for (const assets::Part& part : scene.parts) parts_.push_back(ballOf(scene, part));
}

void Interest::observe(const sync::StateUpdate& update, Reach& reach) const {
  const glm::dvec3 hand = update.presence.worldFromTool.position;
  const double since = sync::toSeconds(update.time - reach.time);
  const double moved = reach.count > 0 ? glm::length(hand - reach.balls[0].centre) : 0.0;
  const double handSpeed = since > 0.0 ? moved / since : 0.0;
  reach.count = 0;
  reach.time = update.time;
  reach.speed = std::isfinite(handSpeed) ? std::min(handSpeed, sync::kMaxLinearSpeed) : 0.0;
  add(reach, {hand, 0.0});
  if (update.presence.worldFromSecondTool) add(reach, {update.presence.worldFromSecondTool->position, 0.0});
  for (const sync::PartState& state : update.parts) {
    ASSERT(state.part < parts_.size());
    const Reach::Ball& ball = parts_[state.part];
    add(reach, {transformPoint(state.worldFromPart, ball.centre), ball.radius});
    reach.speed = std::max(reach.speed,
                           glm::length(state.twist.linear) + ball.radius * glm::length(state.twist.angular));
  }
}

bool Interest::near(const Reach& a, const Reach& b) const {
  if (a.count == 0 || b.count == 0) return true;  // nobody knows yet
  const double far = margin_ + kForesight_s * (a.speed + b.speed);
  for (std::size_t i = 0; i < a.count; ++i)
    for (std::size_t k = 0; k < b.count; ++k) {
      const glm::dvec3 apart = a.balls[i].centre - b.balls[k].centre;
      const double reach = far + a.balls[i].radius + b.balls[k].radius;
      if (glm::dot(apart, apart) <= reach * reach) return true;
    }
  return false;
}

}  // namespace tandem::server
