#include "client/review/part_stroke.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "client/base/thread_clock.h"
#include "haptics/geometry/triangle_math.h"

namespace tandem::client {
namespace {

constexpr int kPlaces = 8, kTicks = 60;
constexpr double kStep = 1e-3;    // of the part's size: its length in a second
constexpr double kHeight = 2e-3;  // of it, above the surface at first
constexpr double kDepth = 1e-3;   // of it, into the surface
constexpr double kFastest = 1.5;  // steps a tick, round an edge
constexpr double kFacets = 1e-4;  // of the radius: haptics/scene/implicit_mesh.h
constexpr double kSilence = 0.3;  // s without a reading, after which a tick puts the proxy onto the device

class Stroker {
 public:
  Stroker(const haptics::ContactScene& contact, const haptics::ContactWorld& world, haptics::TickState& state,
          PartId part)
      : contact_(contact),
        world_(world),
        state_(state),
        part_(part),
        mesh_(world.collider(part).tree->mesh()),
        size_(glm::length(mesh_.bounds.max - mesh_.bounds.min)) {}

  PartStroke run() {
    for (int place = 0; place < kPlaces; ++place)
      strokeFrom(mesh_.triangles.size() * static_cast<std::size_t>(place) / kPlaces);
    stroke_.error += facets();
    return std::move(stroke_);
  }

 private:
  void strokeFrom(std::size_t triangle) {
    const auto& c = mesh_.triangles[triangle];
    const glm::dvec3 &a = mesh_.positions[c[0]], &b = mesh_.positions[c[1]], &d = mesh_.positions[c[2]];
    const glm::dvec3 area = haptics::areaVector({a, b, d});
    if (!(glm::length(area) > 0.0)) return;
    const Pose& pose = world_.pose(part_);
    normal_ = transformVector(pose, glm::normalize(area));
    along_ = transformVector(pose, glm::normalize(b - a));
    device_ = transformPoint(pose, (a + b + d) / 3.0) + normal_ * (kHeight * size_);
    put();
    const glm::dvec3 lowered = device_ - normal_ * ((kHeight + kDepth) * size_);
    bool low = false;
    for (int i = 0; i < kTicks; ++i) {
      if (!low) {
        low = approach(lowered);
      } else {
        approach(proxy_ + along_ * (kStep * size_) - normal_ * (kDepth * size_));
      }
      measuredTick();
    }
  }

  haptics::TickInput reading(bool valid) const {
    haptics::TickInput input;
    input.hands[0].device.valid = valid;
    input.hands[0].device.worldFromDevice.position = device_;
    return input;
  }

  void put() {
    haptics::TickParameters silence = parameters_;
    silence.dt = kSilence;
    static_cast<void>(haptics::tick(reading(false), contact_, silence, state_));
    note(haptics::tick(reading(true), contact_, parameters_, state_));
  }

  /// Moves the stylus towards a target by at most the distance that a hand covers in a tick. True once it is
  /// there.
  bool approach(const glm::dvec3& target) {
    const glm::dvec3 displacement = target - device_;
    const double length = glm::length(displacement), limit = kFastest * kStep * size_;
    const bool near = length <= limit;
    device_ = near ? target : device_ + displacement * (limit / length);
    stroke_.longestStep = std::max(stroke_.longestStep, std::min(length, limit));
    return near;
  }

  void measuredTick() {
    const haptics::TickInput input = reading(true);
    const double start = threadMicroseconds();
    const haptics::TickOutput out = haptics::tick(input, contact_, parameters_, state_);
    stroke_.tick_us.push_back(threadMicroseconds() - start);
    if (!note(out)) return;
    ++stroke_.touching;
    // Relief and magnets act before the facets constrain the tool; those ticks are not judged.
    if (proxy_ == device_) return;
    haptics::SurfacePoint exact;
    if (world_.nearest(part_, proxy_, size_, exact)) stroke_.error = std::max(stroke_.error, exact.distance);
  }

  /// Stores the tool's position and the contact's normal for the next step. True if the tool touches the
  /// part.
  bool note(const haptics::TickOutput& out) {
    proxy_ = out.worldFromProxy.position;
    for (int i = 0; i < out.contactCount; ++i) {
      const haptics::Contact& contact = out.contacts[static_cast<std::size_t>(i)];
      if (contact.part != part_) continue;
      normal_ = contact.normal;
      const glm::dvec3 flat = along_ - normal_ * glm::dot(along_, normal_);
      if (glm::length(flat) > 1e-3) along_ = glm::normalize(flat);
      return true;
    }
    return false;
  }

  double facets() const {
    double limit = 0.0;
    using Kind = assets::ImplicitShape::Kind;
    for (const assets::ImplicitShape& shape : contact_.scene().parts[part_].shapes)
      if (shape.kind != Kind::box && shape.kind != Kind::plane)
        limit = std::max({limit, shape.radiusBottom, shape.kind == Kind::sphere ? 0.0 : shape.radiusTop});
    return kFacets * limit;
  }

  const haptics::ContactScene& contact_;
  const haptics::ContactWorld& world_;
  haptics::TickState& state_;
  const PartId part_;
  const assets::Mesh& mesh_;
  const double size_;  // m
  const haptics::TickParameters parameters_;
  PartStroke stroke_;
  glm::dvec3 device_{0.0, 0.0, 0.0}, proxy_{0.0, 0.0, 0.0};  // m, world
  glm::dvec3 normal_{0.0, 0.0, 0.0}, along_{0.0, 0.0, 0.0};  // unit, world
};

}  // namespace

PartStroke strokePart(const haptics::ContactScene& contact, const haptics::ContactWorld& world,
                      haptics::TickState& state, PartId part) {
  ASSERT(part < contact.scene().parts.size());
  const haptics::TriangleBvh* tree = world.collider(part).tree;
  if (tree == nullptr || tree->mesh().triangles.empty()) return {};
  return Stroker(contact, world, state, part).run();
}

}  // namespace tandem::client
