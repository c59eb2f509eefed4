#include "haptics/surface/apply_surface.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "assets/base/finite.h"
#include "haptics/base/fixed_vector.h"
#include "haptics/proxy/contact_force.h"
#include "haptics/scene/haptic_texture.h"
#include "haptics/scene/surface_scene.h"

namespace tandem::haptics {
namespace {

using assets::Material;
using assets::Surface;
using assets::SurfaceTexture;

constexpr int kMaxNear = 4;       // parts per tick that may act before they are touched
constexpr int kMaxAsked = 16;     // parts whose nearest point is queried for that
constexpr double kFlat = 0.9999;  // cos of 0.8 degrees between a contact and the flat facet under it
// Angle between a contact and the normal of the patch under it, in turns of the facet over its patch, from
// which shading fades, and from which the tool is on an edge that is sharp.
constexpr double kOnPatch = 2.5, kOnEdge = 3.5;
constexpr double kFacing = 0.75;  // cos of the largest angle between planes of one smooth contact

/// Of materials that have none: they are as smooth as the file's normals say.
const Surface kPlainSurface;

/// One contact of the proxy with a surface: one pressing plane, or several of one smooth surface.
struct Touch {
  PartId part = kNoPart;
  std::uint32_t triangle = kNoTriangle;
  const Material* material = nullptr;
  const Surface* surface = nullptr;
  glm::dvec3 point{0.0, 0.0, 0.0};   // m, world, on the triangle
  glm::dvec3 normal{0.0, 0.0, 0.0};  // world, of the facet, towards the tool
  glm::dvec3 goal{0.0, 0.0, 0.0};    // m, world
  glm::dvec3 old{0.0, 0.0, 0.0};     // N, force of contactForce()
  double strongest = 0.0;            // m, largest depth of its planes
  int contact = -1;                  // into TickOutput::contacts; -1 = near but not touched
};

class SurfaceTick {
 public:
  SurfaceTick(const ContactWorld& world, const Proxy& proxy, const DeviceSample& device,
              const TickParameters& parameters, SurfaceState& state, TickOutput& out)
      : world_(world),
        surfaces_(*world.surfaces()),
        proxy_(proxy),
        device_(device),
        parameters_(parameters),
        state_(state),
        out_(out) {}

  glm::dvec3 run(const glm::dvec3& force) {
    ASSERT(out_.contactCount >= 0 && out_.contactCount <= kMaxContacts);

    state_.letGo = kNoPart;
    glm::dvec3 friction = force;
    for (int i = 0; i < out_.contactCount; ++i) {
      const Contact& contact = out_.contacts[static_cast<std::size_t>(i)];
      friction -= contact.force * contact.normal;
    }
    findTouches();
    findNear();
    for (SurfaceSlot& slot : state_.slots) slot.active = false;
    glm::dvec3 total = force;
    double before = plainPressing_, now = plainPressing_;  // N, of all contacts together
    for (const Touch& touch : touches_) {
      const glm::dvec3 felt = forceOf(touch);
      total += felt - touch.old;
      const double old = glm::length(touch.old);
      if (!(old > 0.0)) continue;
      before += old;
      now += glm::dot(felt, touch.old) / old;
    }
    // Less normal force holds less friction, so friction stays within the cone. More normal force does not
    // stiffen its spring.
    if (now < before) total -= friction * (1.0 - std::max(0.0, now) / before);
    for (SurfaceSlot& slot : state_.slots)
      if (!slot.active) rest(slot);
    return holdShading(shading_, device_.worldFromDevice.position, force, isFinite(total) ? total : force,
                       state_.shading);
  }

 private:
  /// Notes a touch with a shaded part for holdShading().
  void noteShading(const Touch& touch, const ShadedMesh* shaded, const PatchPoint& patch) {
    const Surface& s = *touch.surface;
    shading_.other = shading_.other || shaded == nullptr || s.law != Surface::Law::elastic ||
                     s.texture.pattern != SurfaceTexture::Pattern::none || s.vibrationAmplitude > 0.0 ||
                     s.stickSlipForce > 0.0 || s.magneticForce > 0.0 || s.popThroughForce > 0.0;
    if (shading_.other) return;
    const double stated = touch.material->stiffness > 0.0 ? touch.material->stiffness : parameters_.stiffness;
    const double stiffness = stated * shareOfStiffness(s, stated);
    const glm::dvec3 velocity = velocityAt(world_.pose(touch.part), world_.twist(touch.part), touch.point);
    if (!shading_.any) {
      shading_.part = touch.part;
      shading_.region = shaded->region[touch.triangle];
    }
    shading_.any = true;
    shading_.relief += stiffness * patch.relief;
    shading_.stiffness = std::max(shading_.stiffness, stiffness);
    shading_.travel = std::max(shading_.travel, parameters_.dt * glm::length(velocity));
    shading_.trust = std::min(shading_.trust, patch.trust);
    shading_.steepness = std::max(shading_.steepness, patch.steepness);
  }

  const Surface* surfaceOf(PartId part, std::uint32_t triangle, const Material*& material) const {
    material = &world_.material(part, triangle);
    const auto& all = world_.scene().surfaces;
    if (material->surface < all.size()) return &all[material->surface];
    return surfaces_.parts[part].shaded != nullptr ? &kPlainSurface : nullptr;
  }

  void findTouches() {
    int contact = 0;
    for (const ProxyPlane& plane : proxy_.planes) {
      if (!isFelt(plane)) continue;
      addPlane(plane, contact < out_.contactCount ? contact : -1);
      ++contact;
    }
  }

  void addPlane(const ProxyPlane& plane, int contact) {
    const SurfacePoint& at = plane.surface;
    const Material* material = nullptr;
    const Surface* surface = surfaceOf(at.part, at.triangle, material);
    if (contact < 0) return;
    const Contact& known = out_.contacts[static_cast<std::size_t>(contact)];
    if (surface == nullptr) {
      plainPressing_ += known.force;
      return;
    }
    const glm::dvec3 push = plane.depth * at.normal;
    Touch* touch = nullptr;
    for (Touch& other : touches_) {
      if (touch == nullptr && joined(other, at, surface)) touch = &other;
    }
    if (touch == nullptr) {
      if (touches_.full()) return;
      touch = &touches_.push_back(
          {at.part, at.triangle, material, surface, at.point, at.normal, tool_, {}, 0.0, contact});
    }
    touch->goal -= push;
    touch->old += known.force * known.normal;
    if (plane.depth > touch->strongest) {
      touch->strongest = plane.depth;
      touch->triangle = at.triangle;
      touch->point = at.point;
      touch->normal = at.normal;
    }
  }

  /// Whether two planes are facets of one smooth surface.
  bool joined(const Touch& touch, const SurfacePoint& at, const Surface* surface) const {
    if (touch.part != at.part || touch.surface != surface) return false;
    const ShadedMesh* shaded = surfaces_.parts[at.part].shaded;
    const double crease = surface->creaseAngle;
    return shaded != nullptr &&
           glm::dot(touch.normal, at.normal) > (crease > 0.0 ? std::cos(crease) : kFacing) &&
           smoothTogether(*shaded, world_.collider(at.part).tree->mesh(), touch.triangle, at.triangle);
  }

  /// Finds surfaces that act before their facets are touched: curved patches and relief above them, magnets.
  /// Parts within reach are queried nearest first, by their bounding spheres.
  void findNear() {
    const double most = reachOf(surfaces_.reach, surfaces_.forceReach);
    if (!(most > 0.0)) return;
    NearList near;
    const glm::dvec3 grow(parameters_.toolRadius + most);
    world_.forEachNear({tool_ - grow, tool_ + grow}, [&](PartId part) { considerNear(part, near); });
    int acting = 0;
    for (const NearPart& entry : near) {
      const PartId part = entry.part;
      const PartSurface& special = surfaces_.parts[part];
      SurfacePoint at;
      const double reach = parameters_.toolRadius + reachOf(special.reach, special.forceReach);
      if (!world_.nearest(part, tool_, reach, at)) continue;
      const Material* material = nullptr;
      const Surface* surface = surfaceOf(part, at.triangle, material);
      if (surface == nullptr) continue;
      if (acting == kMaxNear || touches_.full()) {
        out_.flags |= kFlagOverflow;
        return;
      }
      ++acting;
      touches_.push_back({part, at.triangle, material, surface, at.point, at.normal, tool_, {}, 0.0, -1});
    }
  }

  double reachOf(double length, double force) const { return length + force / parameters_.stiffness; }

  /// A part whose bounding sphere is within reach.
  struct NearPart {
    double gap = 0.0;  // m, from the proxy to the sphere; 0 inside
    PartId part = kNoPart;
    bool before(const NearPart& other) const {
      return gap < other.gap || (gap == other.gap && part < other.part);
    }
  };
  using NearList = FixedVector<NearPart, kMaxAsked>;

  void considerNear(PartId part, NearList& near) {
    const PartSurface& special = surfaces_.parts[part];
    const double own = reachOf(special.reach, special.forceReach);
    if (!(own > 0.0) || !world_.touchable(part) || touches(part)) return;
    const Collider& collider = world_.collider(part);
    const double away = glm::distance(tool_, transformPoint(world_.pose(part), collider.centre));
    const NearPart entry{std::max(0.0, away - collider.radius), part};
    if (entry.gap > own + parameters_.toolRadius) return;
    if (near.full()) {
      out_.flags |= kFlagOverflow;
      if (!entry.before(near.back())) return;
      near.pop_back();
    }
    near.insert(std::upper_bound(near.begin(), near.end(), entry,
                                 [](const NearPart& a, const NearPart& b) { return a.before(b); }),
                entry);
  }

  bool touches(PartId part) const {
    return std::any_of(touches_.begin(), touches_.end(),
                       [part](const Touch& touch) { return touch.part == part; });
  }

  SurfaceSlot& slotOf(PartId part) {
    SurfaceSlot* free = &state_.slots[0];
    for (SurfaceSlot& slot : state_.slots) {
      if (slot.part == part && !slot.active) return slot;
      if (!slot.active && (free->active || slot.part == kNoPart)) free = &slot;
    }
    *free = SurfaceSlot{};
    free->part = part;
    return *free;
  }

  /// Ends a contact: viscoelastic surfaces continue to recover, all other state is cleared.
  void rest(SurfaceSlot& slot) {
    if (slot.part == kNoPart) return;
    slot.anchor.set = false;
    slot.phase = 0.0;
    slot.velocity = glm::dvec3(0.0);
    constexpr double kFarOut = -1e30;  // m: out of reach of any contact
    if (slot.law.depth > 0.0)
      viscoelasticForce(slot.stiffness, slot.stiffness2, slot.relaxation, kFarOut, parameters_.dt, slot.law);
  }

  glm::dvec3 forceOf(const Touch& touch) {
    const Pose& pose = world_.pose(touch.part);
    const glm::dquat partFromWorld = glm::conjugate(pose.orientation);
    const auto toPart = [&](const glm::dvec3& p) { return partFromWorld * (p - pose.position); };
    const assets::Mesh& mesh = world_.collider(touch.part).tree->mesh();
    const ShadedMesh* shaded = surfaces_.parts[touch.part].shaded;
    const glm::dvec3 facet = facetDirection(mesh, touch.triangle);
    const double side = glm::dot(partFromWorld * touch.normal, facet) < 0.0 ? -1.0 : 1.0;
    const glm::dvec3 plain = touch.contact < 0 ? pullOf(touch) : touch.old;
    PatchPoint patch;
    const bool found =
        projectOntoPatch(mesh, shaded, touch.triangle, toPart(touch.point), toPart(touch.goal), side, patch);
    noteShading(touch, shaded, patch);
    if (!found) return plain;
    const double share =
        std::min(patch.share, shareOnPatch(mesh, shaded, patch, partFromWorld * touch.normal, facet));
    if (!(share > 0.0)) return plain;
    if (shaded != nullptr) limitDepth(touch, patch);
    const glm::dvec3 felt = transformVector(pose, respond(touch, mesh, patch, partFromWorld));
    return share < 1.0 ? glm::mix(plain, felt, share) : felt;
  }

  /// Holds the patch's depth and its gradient to what the facets and the surface over them allow:
  /// |depth * gradient| <= the depth of the proxy's contact + the height of the surface over its facet.
  void limitDepth(const Touch& touch, PatchPoint& patch) const {
    const double most = glm::distance(tool_, touch.goal) + patch.relief;
    const double depth = patch.depth + parameters_.toolRadius, steep = glm::length(patch.depthGradient);
    if (!(depth * std::max(1.0, steep) > most)) return;
    const double held = std::min(depth, most);
    patch.depth = held - parameters_.toolRadius;
    if (held * steep > most) patch.depthGradient *= most / (held * steep);
  }

  /// Pull of a magnet beyond its edges and corners, where its potential continues with the distance.
  glm::dvec3 pullOf(const Touch& touch) const {
    const double height = glm::dot(touch.goal - touch.point, touch.normal) - parameters_.toolRadius;
    return -touch.normal *
           magneticPull(touch.surface->magneticForce, touch.surface->magneticDistance, height);
  }

  static glm::dvec3 facetDirection(const assets::Mesh& mesh, std::uint32_t t) {
    const auto& c = mesh.triangles[t];
    return areaVector({mesh.positions[c[0]], mesh.positions[c[1]], mesh.positions[c[2]]});
  }

  /// 1 where the tool rests on a facet or on its patch, 0 on an edge or corner that is not smooth, where the
  /// plain contact is right.
  static double shareOnPatch(const assets::Mesh& mesh, const ShadedMesh* shaded, const PatchPoint& patch,
                             const glm::dvec3& contact, const glm::dvec3& facet) {
    const double cosine = glm::dot(contact, patch.normal);
    if (cosine >= kFlat || shaded == nullptr) return cosine >= kFlat ? 1.0 : 0.0;
    const double along = glm::dot(contact, facet);
    if (along * along >= kFlat * kFlat * glm::dot(facet, facet)) return 1.0;
    const double turn = facetTurn(mesh, *shaded, patch.triangle);
    if (!(turn > 0.0)) return 0.0;
    const double off = std::acos(std::clamp(cosine, -1.0, 1.0)) / turn;
    return std::clamp((kOnEdge - off) / (kOnEdge - kOnPatch), 0.0, 1.0);
  }

  /// Force in the part's frame.
  glm::dvec3 respond(const Touch& touch, const assets::Mesh& mesh, const PatchPoint& patch,
                     const glm::dquat& partFromWorld) {
    const Surface& surface = *touch.surface;
    const double stated = touch.material->stiffness > 0.0 ? touch.material->stiffness : parameters_.stiffness;
    const double share = shareOfStiffness(surface, stated), stiffness = share * stated;
    const double flatDepth = patch.depth + parameters_.toolRadius;
    glm::dvec3 gradient = patch.depthGradient;
    const double depth = flatDepth + relief(surface.texture, mesh, patch, stated, gradient);
    glm::dvec3 force =
        patch.depthGradient * magneticPull(surface.magneticForce, surface.magneticDistance, -flatDepth);
    if (!(depth > 0.0)) return force;

    SurfaceSlot& slot = slotOf(touch.part);
    slot.active = true;
    const double pressing =
        contactLaw(touch, patch, depth, stiffness, share * surface.stiffness2, gradient, slot);
    if (!(pressing > 0.0)) {
      // The tool has left a dent, or the dent has not recovered yet, so there is no contact.
      slot.velocity = glm::dvec3(0.0);
      slot.anchor.set = false;
      if (touch.contact >= 0) noteContact(touch, glm::conjugate(partFromWorld) * patch.normal, 0.0);
      return force;
    }
    if (surface.popThroughForce > 0.0 && pressing > surface.popThroughForce) {
      state_.letGo = touch.part;
      noteContact(touch, glm::conjugate(partFromWorld) * patch.normal, 0.0);
      return glm::dvec3(0.0);
    }
    force -= pressing * gradient;
    force += dissipation(touch, patch, force, partFromWorld, slot);
    force += shaking(touch, patch, glm::dot(force, patch.normal), partFromWorld, slot);
    noteContact(touch, glm::conjugate(partFromWorld) * patch.normal, glm::dot(force, patch.normal));
    return force;
  }

  /// Factor by which the device's stiffness limit scales all springs along the normal together.
  double shareOfStiffness(const Surface& surface, double stated) const {
    const double all = stated + (surface.law == Surface::Law::viscoelastic ? surface.stiffness2 : 0.0);
    return parameters_.stiffnessLimit > 0.0 ? std::min(1.0, parameters_.stiffnessLimit / all) : 1.0;
  }

  /// Force along the depth's gradient, which plastic dents tilt.
  double contactLaw(const Touch& touch, const PatchPoint& patch, double depth, double stiffness,
                    double stiffness2, glm::dvec3& gradient, SurfaceSlot& slot) {
    const Surface& surface = *touch.surface;
    if (surface.law == Surface::Law::viscoelastic) {
      slot.stiffness = stiffness;
      slot.stiffness2 = stiffness2;
      slot.relaxation = surface.relaxation;
      return viscoelasticForce(stiffness, stiffness2, surface.relaxation, depth, parameters_.dt, slot.law);
    }
    if (surface.law == Surface::Law::elastic) return stiffness * depth;
    glm::dvec3 slope(0.0);
    const double before = dented(touch.part, patch.point, slope);
    double set = before;
    const double force = plasticForce(stiffness, surface.yieldForce, surface.hardening, depth, set);
    const double natural = 4.0 * surface.yieldForce / stiffness + 2.0 * parameters_.toolRadius;
    if (set > before) dent(touch.part, patch.point, set - before, natural > 0.0 ? natural : 4.0 * depth);
    gradient -=
        glm::dot(slope, patch.pointU) * patch.uGradient + glm::dot(slope, patch.pointV) * patch.vGradient;
    return force;
  }

  /// Permanent set of a place, m, and its slope.
  double dented(PartId part, const glm::dvec3& x, glm::dvec3& slope) const {
    double set = 0.0;
    for (const Dent& dent : state_.dents) {
      const double share = dent.part == part ? shareOf(dent, x) : 0.0;
      if (!(share > 0.0)) continue;
      set += dent.depth * share * share;
      slope += (x - dent.point) * (-4.0 * dent.depth * share / (dent.width * dent.width));
    }
    return set;
  }

  static double shareOf(const Dent& dent, const glm::dvec3& x) {
    const glm::dvec3 off = (x - dent.point) / dent.width;
    return std::max(0.0, 1.0 - glm::dot(off, off));
  }

  /// Raises the set at x by `growth`: a nearby dent grows, or else a new one begins.
  void dent(PartId part, const glm::dvec3& x, double growth, double width) {
    constexpr double kNear = 0.94;  // 1 - 1/4^2: within a quarter of the width
    double best = 0.0;
    Dent* nearest = nullptr;
    for (Dent& dent : state_.dents) {
      const double share = dent.part == part ? shareOf(dent, x) : 0.0;
      if (share > best) best = share, nearest = &dent;
    }
    if (nearest != nullptr && best > kNear) {
      nearest->depth += growth / (best * best);
      return;
    }
    if (state_.dents.full()) forgetOldest();
    state_.dents.push_back({part, x, growth, width});
  }

  void forgetOldest() {
    std::move(state_.dents.begin() + 1, state_.dents.end(), state_.dents.begin());
    state_.dents.pop_back();
  }

  /// Vibration along the normal, and the stick-slip spring across it.
  glm::dvec3 shaking(const Touch& touch, const PatchPoint& patch, double pressing,
                     const glm::dquat& partFromWorld, SurfaceSlot& slot) {
    const Surface& surface = *touch.surface;
    glm::dvec3 force(0.0);
    if (surface.vibrationAmplitude > 0.0) {
      force += patch.normal * vibration(surface.vibrationFrequency, surface.vibrationAmplitude, pressing,
                                        parameters_.dt, slot.phase);
    }
    if (surface.stickSlipForce > 0.0) {
      const glm::dvec3 tip =
          partFromWorld * (device_.worldFromDevice.position - world_.pose(touch.part).position);
      const double stiffness = limitedStiffness(surface.stickSlipStiffness, parameters_);
      force += stickSlip(surface.stickSlipForce, stiffness, tip, patch.normal, slot.anchor);
    }
    return force;
  }

  /// Height of the relief, m; adds the relief's gradient to that of the depth.
  double relief(const SurfaceTexture& texture, const assets::Mesh& mesh, const PatchPoint& patch,
                double stiffness, glm::dvec3& gradient) const {
    const double amplitude = texture.amplitude + texture.amplitudeForce / stiffness;
    if (texture.pattern == SurfaceTexture::Pattern::none || !(amplitude > 0.0)) return 0.0;
    double byU = 0.0, byV = 0.0, value = 0.0;
    if (texture.pattern == SurfaceTexture::Pattern::image) {
      if (patch.triangle >= mesh.triangleUv.size()) return 0.0;
      const FacetHeight h = imageHeightOnFacet(world_.scene().textures[texture.image],
                                               mesh.triangleUv[patch.triangle], patch.u, patch.v);
      value = h.value;
      byU = h.byU;
      byV = h.byV;
    } else {
      const Height h = patternHeight(texture.pattern, texture.wavelength, patch.point);
      value = h.value;
      byU = glm::dot(h.gradient, patch.pointU);
      byV = glm::dot(h.gradient, patch.pointV);
    }
    gradient += amplitude * (byU * patch.uGradient + byV * patch.vGradient);
    return amplitude * value;
  }

  /// Damping and viscous drag; along the normal they never exceed the pressing force.
  glm::dvec3 dissipation(const Touch& touch, const PatchPoint& patch, const glm::dvec3& pressing,
                         const glm::dquat& partFromWorld, SurfaceSlot& slot) {
    const glm::dvec3 surfaceVelocity =
        velocityAt(world_.pose(touch.part), world_.twist(touch.part), touch.point);
    const glm::dvec3 velocity = partFromWorld * (device_.twist.linear - surfaceVelocity);
    const double damping = contactDamping(*touch.material, parameters_);
    glm::dvec3 drag =
        viscousDrag(limitedDamping(touch.surface->viscosity, parameters_), velocity, slot.velocity);
    slot.velocity = velocity;
    drag -= damping * glm::dot(velocity, patch.normal) * patch.normal;
    const double along = glm::dot(drag, patch.normal);
    const double least = -std::max(0.0, glm::dot(pressing, patch.normal));
    return along < least ? drag + (least - along) * patch.normal : drag;
  }

  void noteContact(const Touch& touch, const glm::dvec3& normal, double force) {
    ASSERT(touch.contact < out_.contactCount);
    int at = touch.contact;
    if (at < 0) {
      if (out_.contactCount == kMaxContacts) return;
      at = out_.contactCount++;
      out_.contacts[static_cast<std::size_t>(at)] = {touch.part, touch.point, normal, force};
      return;
    }
    Contact& contact = out_.contacts[static_cast<std::size_t>(at)];
    contact.normal = normal;
    contact.force = force;
  }

  static constexpr int kMaxTouches = kMaxContacts + kMaxNear;

  const ContactWorld& world_;
  const SurfaceScene& surfaces_;
  const Proxy& proxy_;
  const DeviceSample& device_;
  const TickParameters& parameters_;
  SurfaceState& state_;
  TickOutput& out_;
  const glm::dvec3 tool_ = proxy_.position - heldByMargins(proxy_);  // m, world
  FixedVector<Touch, kMaxTouches> touches_;
  double plainPressing_ = 0.0;  // N, of contacts without a surface
  ShadedTouches shading_;
};

}  // namespace

glm::dvec3 applySurfaceEffects(const ContactWorld& world, const Proxy& proxy, const DeviceSample& device,
                               const TickParameters& parameters, const glm::dvec3& force, SurfaceState& state,
                               TickOutput& out) {
  return SurfaceTick(world, proxy, device, parameters, state, out).run(force);
}

}  // namespace tandem::haptics
