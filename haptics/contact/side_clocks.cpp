#include "haptics/contact/side_clocks.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace tandem::haptics {
namespace {

// Radii of the sampled part after which a clock starts anew, because its floats become coarse.
constexpr double kLongest = 16.0;

double radiusOf(const PartModel& model) {
  return model.samples.nodes().empty() ? 0.0 : static_cast<double>(model.samples.nodes().front().radius);
}

std::size_t timesOf(const PartModel& model) {
  return model.samples.nodes().size() + model.samples.samples().size();
}

}  // namespace

double farthestMotion(const Pose& from, const Pose& to, const glm::dvec3& centre, double radius) {
  const glm::dquat &a = from.orientation, &b = to.orientation;
  const glm::dquat near = glm::dot(a, b) < 0.0 ? -b : b;
  // A rotation by t moves a point at a distance of 1 by 2 sin(t/2) <= 4 sin(t/4) = 2 |a - b|.
  const double turn = 2.0 * glm::length(near - a);
  return glm::length(transformPoint(to, centre) - transformPoint(from, centre)) + radius * turn;
}

SideClocks::SideClocks(const ContactWorld& world) {
  for (PartId part = 0; world.has(part); ++part) {
    const PartModel* const model = world.model(part);
    if (model == nullptr) continue;
    largest_ = std::max(largest_, timesOf(*model));
    mostNodes_ = std::max(mostNodes_, model->samples.nodes().size());
  }
  room_ = largest_ > 0 ? std::max(kMaxTimes, largest_) : 0;
  times_ = std::make_unique<float[]>(room_);
  visited_ = std::make_unique<std::uint32_t[]>(mostNodes_);
}

void SideClocks::restart(Side& side, const SampledModels& models) {
  side.clock = 0.0;
  side.pose = models.toFromSamples;
  float* const times = times_.get() + side.first;
  std::fill(times, times + timesOf(*models.from), DueTimes::kNever);
}

bool SideClocks::isOf(const Side& side, PartId sampled, PartId target, const SampledModels& models) {
  return side.sampled == sampled && side.target == target && side.features == models.from->features.get() &&
         side.tree == models.to->tree;
}

bool SideClocks::hasRoomFor(const SampledModels& models) const {
  return !sides_.full() && used_ + timesOf(*models.from) <= room_;
}

bool SideClocks::forgetsFor(PartId sampled, PartId target, const SampledModels& models) const {
  const auto isThis = [&](const Side& side) { return isOf(side, sampled, target, models); };
  return std::none_of(sides_.begin(), sides_.end(), isThis) && !hasRoomFor(models);
}

SideClocks::Side& SideClocks::sideOf(PartId sampled, PartId target, const SampledModels& models) {
  for (Side& side : sides_) {
    if (isOf(side, sampled, target, models)) return side;
    // One of the meshes has been exchanged.
    if (side.sampled == sampled && side.target == target) side.sampled = kNoPart;
  }
  const std::size_t needed = timesOf(*models.from);
  if (!hasRoomFor(models)) {
    while (!sides_.empty()) sides_.pop_back();
    used_ = 0;
  }
  Side& side = sides_.push_back({});
  side.sampled = sampled;
  side.target = target;
  side.features = models.from->features.get();
  side.tree = models.to->tree;
  side.first = used_;
  used_ += needed;
  restart(side, models);
  return side;
}

DueTimes SideClocks::at(PartId sampled, PartId target, const SampledModels& models,
                        const AllowedDepth& allowed) {
  const ContactSamples& samples = models.from->samples;
  // An exchanged mesh may have more samples than all that were there before.
  if (samples.nodes().empty() || samples.nodes().size() > mostNodes_ || timesOf(*models.from) > room_)
    return {};
  Side& side = sideOf(sampled, target, models);
  const ContactSamples::Node& ball = samples.nodes().front();
  const double moved =
      farthestMotion(side.pose, models.toFromSamples, {ball.centre[0], ball.centre[1], ball.centre[2]},
                     static_cast<double>(ball.radius));
  if (!side.allowed.sameBoxes(allowed) || side.clock + moved > kLongest * radiusOf(*models.from)) {
    restart(side, models);
  } else {
    // What a sample may be deep changes as it moves beside the overlap, and as the overlap shrinks.
    const double slope =
        allowed.depth > 0.0f ? static_cast<double>(side.allowed.depth / allowed.margin) : 0.0;
    const double shrunk = static_cast<double>(std::max(side.allowed.depth - allowed.depth, 0.0f));
    side.clock += moved * (1.0 + slope) + shrunk;
  }
  side.pose = models.toFromSamples;
  side.allowed = allowed;
  DueTimes due;
  due.nodes = {times_.get() + side.first, samples.nodes().size()};
  due.samples = {due.nodes.data() + due.nodes.size(), samples.samples().size()};
  due.visited = {visited_.get(), samples.nodes().size()};
  due.now = static_cast<float>(side.clock);
  return due;
}

}  // namespace tandem::haptics
