#pragma once

// One straight pull at a part: a hand draws it along an axis at a part's length a second, with the solver of
// a held part, and gives way across the line and about every axis, until the part is clear of the others or
// stuck. All other parts stand still. Allocates.

#include <functional>
#include <vector>

#include "haptics/scene/contact_scene.h"

namespace tandem::client {

/// One straight pull, as far as the part went.
struct ExtractionLeg {
  glm::dvec3 axis{0.0, 0.0, 0.0};  // unit, world
  double distance = 0.0;           // m, along it
};

/// A place that pulls have led to, and the way there.
struct Place {
  Pose worldFromPart;
  std::vector<ExtractionLeg> way;
  std::vector<Pose> path;  // world from part, a pose each time that the part has gone a fiftieth of its size
  double travelled = 0.0;  // m
  double force = 0.0;      // N, the largest resistance along the way; at most maxForce
  double work = 0.0;       // J, against that resistance; weight, and what speeds the part up, are left out
};

/// The end of one pull.
struct PullEnd {
  Place place;
  bool free = false;
  std::vector<PartId> pressed;  // on which the part pressed where it got stuck
};

/// The share of its size that a part goes in a tick of a pull, and the ticks in which it reaches that speed.
inline constexpr double kPullSpeed = 1e-3;
inline constexpr int kPullRamp = 50;

struct PullSettings {
  PartId part = kNoPart;
  double size = 0.0;         // m, of the part
  double maxForce = 0.0;     // N, with which the hand gives up
  double farthest = 0.0;     // m, after which it gives up
  std::vector<PartId> away;  // parts that are not there
  std::function<bool(const Pose& worldFromPart, const glm::dvec3& axis)> isClear;
};

PullEnd pullStraight(const haptics::ContactScene& contact, const PullSettings& settings, const Place& from,
                     const glm::dvec3& axis);

}  // namespace tandem::client
