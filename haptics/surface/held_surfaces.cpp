#include "haptics/surface/held_surfaces.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/across.h"
#include "haptics/proxy/contact_force.h"
#include "haptics/scene/haptic_texture.h"
#include "haptics/scene/surface_scene.h"

namespace tandem::haptics {
namespace {

using assets::Material;
using assets::Surface;
using assets::SurfaceTexture;

constexpr double kAlike = 0.75;  // cos of the angle between normals up to which touches are one contact
constexpr double kReach = 0.25;  // of the other part's radius, within which its surface is sought
constexpr double kBlow = 20e-3;  // s, after which the damper of a grip presses a part that has struck no more

/// The sum of the touches with faces of one surface on one side of a part.
struct Side {
  PartId part = kNoPart;
  std::uint32_t surface = 0;  // into the scene's
  bool yields = false;
  SurfacePoint strongest;            // of the touches
  double most = 0.0;                 // N, of it
  glm::dvec3 first{0.0, 0.0, 0.0};   // normal of the strongest touch
  glm::dvec3 moment{0.0, 0.0, 0.0};  // N·m, sum of force times point
  glm::dvec3 push{0.0, 0.0, 0.0};    // N
  double force = 0.0;                // N, sum

  glm::dvec3 point() const { return moment / force; }
  glm::dvec3 normal() const { return glm::normalize(push); }
};

class HeldSurfaceTick {
 public:
  HeldSurfaceTick(const ContactWorld& world, const HeldBody& body, const TickParameters& parameters,
                  HeldSurfaces& state)
      : world_(world), body_(body), parameters_(parameters), state_(state) {}

  HeldSurfaceForces run(std::span<const HeldTouch> touches) {
    state_.account -= glm::dot(state_.relief, body_.handMoved) * body_.sentShare;
    for (HeldSurfaces::Slot& slot : state_.slots) slot.active = false;
    gather(touches);
    for (const Side& side : sides_) feel(side);
    for (HeldSurfaces::Slot& slot : state_.slots)
      if (!slot.active) slot = HeldSurfaces::Slot{};
    drag();
    payRelief();
    out_.onHand += state_.relief;
    return out_;
  }

 private:
  /// What drags at one contact across its normal, before the drags of all contacts are lowered together.
  struct Drag {
    glm::dvec3 point{0.0}, velocity{0.0};  // m; m/s, slip
    double viscosity = 0.0;                // N·s/m
    double stiffness = 0.0, most = 0.0;    // N/m and N, of stick-slip
    HeldSurfaces::Slot* slot = nullptr;
  };

  void gather(std::span<const HeldTouch> touches) {
    for (const HeldTouch& touch : touches) {
      if (!(touch.force > 0.0) || !world_.surfaces()->parts[touch.part].any) continue;
      SurfacePoint at;
      if (!world_.nearest(touch.part, touch.point, reachOn(touch.part), at)) continue;
      const std::uint32_t surface = world_.material(at.part, at.triangle).surface;
      if (surface >= world_.scene().surfaces.size()) continue;
      Side* same = sideOf(touch, surface);
      if (same == nullptr) {
        if (sides_.full()) continue;
        same = &sides_.push_back({});
        same->part = touch.part;
        same->surface = surface;
        same->yields = touch.yields;
        same->first = touch.normal;
      }
      if (touch.force > same->most) {
        same->most = touch.force;
        same->strongest = at;
      }
      same->moment += touch.force * touch.point;
      same->push += touch.force * touch.normal;
      same->force += touch.force;
    }
  }

  double reachOn(PartId part) const { return kReach * world_.collider(part).radius; }

  Side* sideOf(const HeldTouch& touch, std::uint32_t surface) {
    for (Side& known : sides_)
      if (known.part == touch.part && known.surface == surface &&
          glm::dot(known.first, touch.normal) > kAlike)
        return &known;
    return nullptr;
  }

  HeldSurfaces::Slot& slotOf(const Side& side) {
    HeldSurfaces::Slot* free = nullptr;
    for (HeldSurfaces::Slot& slot : state_.slots) {
      if (slot.active) continue;
      if (slot.part == side.part && glm::dot(slot.normal, side.normal()) > kAlike) return slot;
      if (free == nullptr || slot.part == kNoPart) free = &slot;
    }
    *free = HeldSurfaces::Slot{};  // as many slots as contacts
    free->part = side.part;
    return *free;
  }

  void feel(const Side& side) {
    // In the middle of a ring of touches there may be no surface, or another one.
    SurfacePoint at;
    if (!world_.nearest(side.part, side.point(), reachOn(side.part), at) ||
        world_.material(at.part, at.triangle).surface != side.surface)
      at = side.strongest;
    const Material& material = world_.material(at.part, at.triangle);
    const Surface& surface = world_.scene().surfaces[side.surface];
    const glm::dvec3 normal = side.normal();
    HeldSurfaces::Slot& slot = slotOf(side);
    slot.active = true;
    slot.normal = normal;
    if (surface.popThroughForce > 0.0) {
      slot.pressed = side.force > surface.popThroughForce ? slot.pressed + parameters_.dt : 0.0;
      if (slot.pressed >= kBlow) out_.givesWay = side.part;
    }
    addRelief(surface.texture, material, at, normal, side.force);
    if (surface.vibrationAmplitude > 0.0)
      out_.onHand += normal * vibration(surface.vibrationFrequency, surface.vibrationAmplitude, side.force,
                                        parameters_.dt, slot.phase);
    if (!side.yields) noteDrag(surface, at, normal, slot);
  }

  void addRelief(const SurfaceTexture& texture, const Material& material, const SurfacePoint& at,
                 const glm::dvec3& normal, double force) {
    const double stiffness = material.stiffness > 0.0 ? material.stiffness : parameters_.stiffness;
    const double amplitude = texture.amplitude + texture.amplitudeForce / stiffness;
    if (texture.pattern == SurfaceTexture::Pattern::none || !(amplitude > 0.0)) return;
    glm::dvec3 slope = amplitude * slopeAt(texture, at);
    slope -= normal * glm::dot(normal, slope);
    const double steep = glm::length(slope);
    wanted_ -= force * slope / std::max(1.0, steep);  // a wall is no relief
    height_ += 2.0 * amplitude * force;
  }

  /// Gradient of the height in units of the amplitude, 1/m, world axes.
  glm::dvec3 slopeAt(const SurfaceTexture& texture, const SurfacePoint& at) const {
    const Pose& pose = world_.pose(at.part);
    const glm::dvec3 x = glm::conjugate(pose.orientation) * (at.point - pose.position);
    const auto height =
        heightOnFacet(world_.scene(), texture, world_.collider(at.part).tree->mesh(), at.triangle, x);
    return height ? pose.orientation * height->gradient : glm::dvec3(0.0);
  }

  void noteDrag(const Surface& surface, const SurfacePoint& at, const glm::dvec3& normal,
                HeldSurfaces::Slot& slot) {
    const double viscosity = limitedDamping(surface.viscosity, parameters_);
    if (!(viscosity > 0.0) && !(surface.stickSlipForce > 0.0)) return;
    const glm::dvec3 velocity = velocityAt(body_.worldFromPart, body_.twist, at.point) -
                                velocityAt(world_.pose(at.part), world_.twist(at.part), at.point);
    const double stiffness =
        surface.stickSlipForce > 0.0 ? limitedStiffness(surface.stickSlipStiffness, parameters_) : 0.0;
    drags_.push_back({at.point, velocity - normal * glm::dot(normal, velocity), viscosity, stiffness,
                      surface.stickSlipForce, &slot});
    slot.slip += parameters_.dt * drags_.back().velocity;
    slot.slip -= normal * glm::dot(normal, slot.slip);
  }

  /// How far a unit push across the normal moves the part there, 1/kg: the most of all directions.
  double mobilityAt(const Drag& d) const {
    const auto [u, v] = acrossOf(d.slot->normal);
    const glm::dvec3 arm = d.point - body_.centre;
    const glm::dvec3 byU = glm::cross(arm, u), byV = glm::cross(arm, v);
    const double uu = glm::dot(byU, body_.mobility * byU), vv = glm::dot(byV, body_.mobility * byV),
                 uv = glm::dot(byU, body_.mobility * byV);
    return 1.0 / body_.mass + 0.5 * (uu + vv) + std::hypot(0.5 * (uu - vv), uv);
  }

  /// Viscosity and springs at the slip that a tick at the present velocity leads to, held to
  /// T W (c + k T) <= 1 with W of mobilityAt().
  void drag() {
    double sum = 0.0;
    const double dt = parameters_.dt;
    for (const Drag& d : drags_) sum += dt * mobilityAt(d) * (d.viscosity + dt * d.stiffness);
    sum = std::max(1.0, sum);
    for (const Drag& d : drags_) {
      const double stiffness = d.stiffness / sum;
      HeldSurfaces::Slot& slot = *d.slot;
      // A spring that stiffens would hold more than was put into it.
      if (stiffness > slot.stiffness && slot.stiffness > 0.0)
        slot.slip *= std::sqrt(slot.stiffness / stiffness);
      slot.stiffness = stiffness;
      if (d.stiffness * glm::length(slot.slip) > d.most) slot.slip = glm::dvec3(0.0);
      const glm::dvec3 force = -stiffness * (slot.slip + dt * d.velocity) - d.viscosity / sum * d.velocity;
      out_.onPart = out_.onPart + Wrench{force, glm::cross(d.point - body_.centre, force)};
    }
  }

  /// The relief's force, as far as the account pays for the next tick's motion like the last.
  void payRelief() {
    state_.account = std::min(state_.account, height_);
    const double gives = 2.0 * glm::dot(wanted_, body_.handMoved);
    const double share = gives > 0.0 ? std::clamp(state_.account / gives, 0.0, 1.0) : 1.0;
    state_.relief = share * wanted_;
  }

  const ContactWorld& world_;
  const HeldBody& body_;
  const TickParameters& parameters_;
  HeldSurfaces& state_;
  FixedVector<Side, kMaxSurfaceContacts> sides_;
  FixedVector<Drag, kMaxSurfaceContacts> drags_;
  glm::dvec3 wanted_{0.0};  // N, of the relief
  double height_ = 0.0;     // J, from the lowest to the highest place of the relief
  HeldSurfaceForces out_;
};

}  // namespace

HeldSurfaceForces feelThrough(const ContactWorld& world, std::span<const HeldTouch> touches,
                              const HeldBody& body, const TickParameters& parameters, HeldSurfaces& state) {
  return HeldSurfaceTick(world, body, parameters, state).run(touches);
}

}  // namespace tandem::haptics
