#include "client/review/scene_features.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "assets/scene/ranges.h"
#include "assets/scene/smooth_normals.h"
#include "haptics/geometry/triangle_math.h"

namespace tandem::client {
namespace {

using assets::ForceField;
using assets::Surface;
using assets::SurfaceTexture;

constexpr double kTurn = 2.0 * std::numbers::pi;

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

/// The quantities that are not zero.
std::vector<Quantity> present(std::initializer_list<Quantity> all) {
  std::vector<Quantity> out;
  for (const Quantity& quantity : all)
    if (quantity.value != 0.0) out.push_back(quantity);
  return out;
}

void add(Feature& feature, const char* name, std::initializer_list<Quantity> quantities,
         std::string text = {}) {
  std::vector<Quantity> stated = present(quantities);
  if (!stated.empty() || !text.empty()) feature.effects.push_back({name, std::move(stated), std::move(text)});
}

std::string imageText(const assets::Scene& scene, const SurfaceTexture& texture) {
  if (texture.image >= scene.textures.size()) return "image";
  const assets::TextureImage& image = scene.textures[texture.image];
  return "image of " + std::to_string(image.width) + " x " + std::to_string(image.height);
}

void addTexture(const assets::Scene& scene, const SurfaceTexture& texture, Feature& feature) {
  if (texture.pattern == SurfaceTexture::Pattern::none) return;
  const bool isImage = texture.pattern == SurfaceTexture::Pattern::image;
  add(feature, "texture",
      {{"amplitude", texture.amplitude, "m"},
       {"amplitude", texture.amplitudeForce, "N"},
       {"wavelength", texture.wavelength, "m"},
       {"frictionScale", texture.frictionScale == 1.0 ? 0.0 : texture.frictionScale, ""}},
      isImage ? imageText(scene, texture) : assets::kPatternNames[static_cast<std::size_t>(texture.pattern)]);
}

void addEffects(const assets::Scene& scene, const Surface& s, Feature& feature) {
  add(feature, "shading", {{"creaseAngle", s.creaseAngle, "rad"}});
  addTexture(scene, s.texture, feature);
  add(feature, "viscosity", {{"viscosity", s.viscosity, "N·s/m"}});
  add(feature, "vibration",
      {{"frequency", s.vibrationFrequency, "Hz"}, {"amplitude", s.vibrationAmplitude, "N"}});
  add(feature, "stick-slip", {{"force", s.stickSlipForce, "N"}, {"stiffness", s.stickSlipStiffness, "N/m"}});
  add(feature, "magnetic", {{"force", s.magneticForce, "N"}, {"distance", s.magneticDistance, "m"}});
  add(feature, "pop-through", {{"force", s.popThroughForce, "N"}});
  if (s.law == Surface::Law::viscoelastic)
    add(feature, "law", {{"stiffness2", s.stiffness2, "N/m"}, {"relaxation", s.relaxation, "s"}},
        "viscoelastic");
  if (s.law == Surface::Law::plastic)
    add(feature, "law", {{"yield", s.yieldForce, "N"}, {"hardening", s.hardening, "N/m"}}, "plastic");
}

void remark(Feature& feature, const char* kind, bool applies, std::string text) {
  if (applies) feature.remarks.push_back({kind, std::move(text)});
}

/// Remarks that a device limits the value of `what` to `max`; 0 = not known.
void remarkHeld(Feature& feature, const char* what, double value, double max, const char* unit) {
  remark(feature, what, max > 0.0 && value > max,
         std::string(what) + " is felt as " + number(max) + " " + unit + ", the most on this device");
}

void remarkForce(Feature& feature, const char* what, double value, const FeatureLimits& limits) {
  remark(feature, what, limits.maxForce > 0.0 && value > limits.maxForce,
         std::string(what) + ": " + number(value) + " N is more than the " + number(limits.maxForce) +
             " N of this device");
}

/// Whether exactly one number of a pair is zero, which makes the other ineffective.
bool half(double a, double b) { return (a == 0.0) != (b == 0.0); }

void judgeMaterial(const assets::Material& m, const FeatureLimits& limits, Feature& feature) {
  remarkHeld(feature, "stiffness", m.stiffness, limits.contact, "N/m");
  remarkHeld(feature, "damping", m.damping, limits.damping, "N·s/m");
  remark(feature, "friction", m.dynamicFriction > m.staticFriction,
         "dynamic friction is more than static: what has begun to slide is held more firmly");
}

/// Judges pairs of numbers of which one is missing.
void judgePairs(const Surface& s, Feature& feature) {
  const SurfaceTexture& t = s.texture;
  remark(feature, "vibration pair", half(s.vibrationFrequency, s.vibrationAmplitude),
         "vibration needs a frequency and an amplitude: not felt");
  remark(feature, "stickSlip pair", half(s.stickSlipForce, s.stickSlipStiffness),
         "stickSlip needs a force and a stiffness: not felt");
  remark(feature, "magnetic pair", half(s.magneticForce, s.magneticDistance),
         "magnetic needs a force and a distance: not felt");
  remark(feature, "viscoelastic",
         s.law == Surface::Law::viscoelastic && !(s.stiffness2 > 0.0 && s.relaxation > 0.0),
         "viscoelastic needs stiffness2 and relaxation: felt as elastic");
  remark(feature, "plastic", s.law == Surface::Law::plastic && s.yieldForce == 0.0,
         "plastic without a yield force: every touch leaves a dent");
  remark(feature, "texture",
         t.pattern != SurfaceTexture::Pattern::none && t.amplitude == 0.0 && t.amplitudeForce == 0.0 &&
             t.frictionScale == 1.0,
         "texture without an amplitude or a frictionScale: not felt");
}

/// Judges values that the device cannot render stably or cannot reach.
void judgeByDevice(const assets::Material& m, const Surface& s, const FeatureLimits& limits,
                   Feature& feature) {
  remark(feature, "vibration rate",
         s.vibrationAmplitude > 0.0 && s.vibrationFrequency >= 0.5 * limits.tickRate,
         "vibration at " + number(s.vibrationFrequency) + " Hz cannot be shown at " +
             number(limits.tickRate) + " ticks a second: not felt");
  remarkForce(feature, "vibration", s.vibrationAmplitude, limits);
  remarkHeld(feature, "viscosity", s.viscosity, limits.damping, "N·s/m");
  if (s.stickSlipForce > 0.0)
    remarkHeld(feature, "stick-slip stiffness", s.stickSlipStiffness, limits.contact, "N/m");
  remarkForce(feature, "stick-slip", s.stickSlipForce, limits);
  // The pull 4 F x (1 - x), x = height / distance, is steepest at both ends.
  const double slope = s.magneticDistance > 0.0 ? 4.0 * s.magneticForce / s.magneticDistance : 0.0;
  remark(feature, "magnetic slope", limits.contact > 0.0 && slope > limits.contact,
         "magnetic pull changes by " + number(slope) + " N/m, more than the " + number(limits.contact) +
             " N/m that this device bears: it shakes there");
  if (s.magneticDistance > 0.0) remarkForce(feature, "magnetic pull", s.magneticForce, limits);
  remark(feature, "popThrough", limits.maxForce > 0.0 && s.popThroughForce > limits.maxForce,
         "popThrough at " + number(s.popThroughForce) + " N is more than the " + number(limits.maxForce) +
             " N of this device: felt only as the tool goes deeper than that force shows");
  remark(feature, "stiffness and stiffness2",
         s.law == Surface::Law::viscoelastic && limits.contact > 0.0 && m.stiffness <= limits.contact &&
             m.stiffness + s.stiffness2 > limits.contact,
         "stiffness and stiffness2 together are felt as " + number(limits.contact) +
             " N/m, the most on this device");
}

void judgeSurface(const assets::Material& m, const Surface& s, const FeatureLimits& limits,
                  Feature& feature) {
  judgePairs(s, feature);
  judgeByDevice(m, s, limits, feature);
  const SurfaceTexture& t = s.texture;
  remark(feature, "steep relief", t.wavelength > 0.0 && t.amplitude * kTurn > t.wavelength,
         "relief climbs more steeply than 45 degrees: it catches the tool more than it lifts it");
}

/// The edges within one material of a mesh that turn, rad.
struct EdgeTurns {
  std::size_t turning = 0, below = 0;  // all of them; those that the crease angle takes for smooth
  double least = kTurn, max = 0.0;
};

glm::dvec3 areaOf(const assets::Mesh& mesh, std::size_t t) {
  const auto& c = mesh.triangles[t];
  return haptics::areaVector({mesh.positions[c[0]], mesh.positions[c[1]], mesh.positions[c[2]]});
}

EdgeTurns edgeTurns(const assets::Mesh& mesh, std::uint16_t material, double crease) {
  constexpr double kFlat = 1e-4;  // rad; above the angles that rounding to floats gives a plane
  EdgeTurns turns;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (mesh.triangleMaterial[t] != material) continue;
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint32_t n = mesh.neighbours[t][e];
      if (n == assets::kNone || n < t || mesh.triangleMaterial[n] != material) continue;
      const glm::dvec3 a = areaOf(mesh, t), b = areaOf(mesh, n);
      const double angle = std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
      if (!(angle > kFlat)) continue;
      ++turns.turning;
      if (angle <= crease) ++turns.below;
      turns.least = std::min(turns.least, angle);
      turns.max = std::max(turns.max, angle);
    }
  }
  return turns;
}

/// Remarks on a crease angle that shades no edge, or all of them, as one in degrees would: a likely mistake.
void judgeCrease(const assets::Mesh& mesh, std::uint16_t material, double crease, Feature& feature) {
  constexpr double kCorner = 0.25 * std::numbers::pi;  // rad: a larger angle is meant to be an edge
  const EdgeTurns turns = edgeTurns(mesh, material, crease);
  const std::string is = "creaseAngle of " + number(crease) + " rad ";
  remark(feature, "crease shades nothing", turns.below == 0,
         is + "shades nothing: " +
             (turns.turning == 0 ? "the surface is flat"
                                 : "no edge turns by less than " + number(turns.least) + " rad"));
  remark(feature, "crease shades everything",
         turns.turning > 0 && turns.below == turns.turning && turns.max > kCorner,
         is + "shades everything: also edges that turn by " + number(turns.max) + " rad feel round");
}

std::vector<std::uint16_t> materialsOf(const assets::Scene& scene, const assets::Part& part) {
  std::vector<std::uint16_t> used;
  for (const assets::ImplicitShape& shape : part.shapes) used.push_back(shape.material);
  if (part.shapes.empty() && part.mesh != assets::kNone) used = scene.meshes[part.mesh].triangleMaterial;
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  return used;
}

/// Says that the file's normals are felt. A surface that says how smooth it is has none.
void addNormals(const assets::Scene& scene, const assets::Part& part, std::uint16_t material,
                Feature& feature) {
  if (!part.shapes.empty() || part.mesh == assets::kNone) return;
  const std::uint64_t smooth = assets::smoothTriangles(scene.meshes[part.mesh], material);
  if (smooth == 0) return;
  add(feature, "shading", {{"triangles", static_cast<double>(smooth), ""}}, "by the normals of the file");
}

Feature materialFeature(const assets::Scene& scene, const assets::Part& part, std::uint16_t material,
                        const FeatureLimits& limits) {
  const assets::Material& m = scene.materials[material];
  Feature feature{part.name, m.name, part.name, {}, {}, material};
  add(feature, "stiffness", {{"stiffness", m.stiffness, "N/m"}});
  add(feature, "damping", {{"damping", m.damping, "N·s/m"}});
  add(feature, "friction", {{"static", m.staticFriction, ""}, {"dynamic", m.dynamicFriction, ""}});
  judgeMaterial(m, limits, feature);
  addNormals(scene, part, material, feature);
  if (m.surface >= scene.surfaces.size()) return feature;
  addEffects(scene, scene.surfaces[m.surface], feature);
  judgeSurface(m, scene.surfaces[m.surface], limits, feature);
  const double crease = scene.surfaces[m.surface].creaseAngle;
  if (crease > 0.0 && part.shapes.empty()) judgeCrease(scene.meshes[part.mesh], material, crease, feature);
  return feature;
}

std::string rolesText(std::uint32_t roles) {
  std::string text;
  for (const auto& [bit, name] : {std::pair{0u, "observer"}, {1u, "participant"}, {2u, "instructor"}})
    if ((roles >> bit & 1u) != 0) text += (text.empty() ? "" : ", ") + std::string(name);
  return text.empty() ? "nobody" : text;
}

/// The width of one detent's well: as stated, else the least distance between two detents.
double wellWidth(const assets::Detents& detents) {
  if (detents.width > 0.0) return detents.width;
  double least = 0.0;
  for (std::size_t i = 1; i < detents.places.size(); ++i) {
    const double gap = detents.places[i] - detents.places[i - 1];
    if (least == 0.0 || gap < least) least = gap;
  }
  return least;
}

void judgeControl(const assets::Control& c, const FeatureLimits& limits, Feature& feature) {
  remark(feature, "roles", (c.roles & 7u) == 0, "no role may move it");
  remark(feature, "detents", !c.detents.places.empty() && c.detents.force == 0.0,
         "detents without a force: not felt");
  remark(feature, "click", c.click.width > 0.0 && c.click.drop == 0.0, "click without a drop: not felt");
  // The force of a dial's torque on the tool depends on where the tool presses, so dials are not judged.
  if (turns(c)) return;
  remarkForce(feature, "its click", c.click.drop, limits);
  remarkForce(feature, "its detents", c.detents.force, limits);
  // F sin(2 pi s / w) is steepest in the well.
  const double width = wellWidth(c.detents), slope = width > 0.0 ? kTurn * c.detents.force / width : 0.0;
  remark(feature, "detent slope", limits.contact > 0.0 && slope > limits.contact,
         "its detents rise by " + number(slope) + " N/m, more steeply than a contact on this device (" +
             number(limits.contact) + " N/m): it jumps from place to place");
  remark(feature, "spring", limits.contact > 0.0 && c.springStiffness > limits.contact,
         "its spring is stiffer than a contact on this device (" + number(limits.contact) +
             " N/m): the tool sinks in before it moves");
}

Feature controlFeature(const assets::Scene& scene, const assets::Control& c, const FeatureLimits& limits) {
  ASSERT(c.part < scene.parts.size());
  const std::string unit = turns(c) ? "rad" : "m", force = turns(c) ? "N·m" : "N";
  Feature feature{c.name, toString(c.kind), scene.parts[c.part].name, {}, {}, assets::kNone};
  feature.effects.push_back({"range",
                             {{"min", c.min, unit}, {"max", c.max, unit}, {"value", c.initial, unit}},
                             c.endless ? "endless" : ""});
  if (c.springStiffness > 0.0)
    feature.effects.push_back(
        {"spring", {{"stiffness", c.springStiffness, force + "/" + unit}, {"rest", c.springRest, unit}}});
  add(feature, "damping", {{"damping", c.damping, force + "·s/" + unit}});
  add(feature, "friction", {{"friction", c.friction, force}});
  add(feature, "inertia", {{"inertia", c.inertia, turns(c) ? "kg·m^2" : "kg"}});
  if (c.detents.force > 0.0 && !c.detents.places.empty())
    add(feature, "detents", {{"force", c.detents.force, force}, {"width", c.detents.width, unit}},
        std::to_string(c.detents.places.size()) + " places");
  if (c.click.drop > 0.0)
    feature.effects.push_back(
        {"click", {{"at", c.click.at, unit}, {"drop", c.click.drop, force}, {"width", c.click.width, unit}}});
  feature.effects.push_back({"roles", {}, rolesText(c.roles)});
  std::string shown;
  for (const PartId part : c.shows) shown += (shown.empty() ? "" : ", ") + scene.parts[part].name;
  if (!shown.empty()) feature.effects.push_back({"shows", {{"threshold", c.threshold, unit}}, shown});
  judgeControl(c, limits, feature);
  return feature;
}

void addAxes(Feature& feature, const char* name, const glm::dvec3& v, const char* unit) {
  if (v.x == v.y && v.y == v.z) return add(feature, name, {{name, v.x, unit}});
  add(feature, name, {{"x", v.x, unit}, {"y", v.y, unit}, {"z", v.z, unit}});
}

void addSpring(const ForceField& f, Feature& feature) {
  static const char* const kAnchors[] = {"point", "line", "plane", "path"};
  std::string to = kAnchors[static_cast<std::size_t>(f.anchor)];
  if (f.oneSided) to += ", one side";
  if (f.anchor == ForceField::Anchor::path) to += " of " + std::to_string(f.points.size()) + " points";
  add(feature, "spring",
      {{"stiffness", f.stiffness, "N/m"},
       {"radius", f.radius, "m"},
       {"damping", f.damping.x, "N·s/m"},
       {"range", f.range, "m"},
       {"fade", f.fade, "m"},
       {"drive", f.drive, "N"}},
      to);
}

void addWaveform(const assets::FieldWaveform& w, Feature& feature) {
  using Kind = assets::FieldWaveform::Kind;
  static const char* const kShapes[] = {"sine", "square", "chirp", "pulses"};
  const bool chirp = w.kind == Kind::chirp;
  constexpr double kNever = 1e299;
  add(feature, "waveform",
      {{"frequency", w.frequency, "Hz"},
       {"endFrequency", chirp ? w.endFrequency : 0.0, "Hz"},
       {"sweep", chirp ? w.sweep : 0.0, "s"},
       {w.kind == Kind::square ? "edge" : "width", w.width, "s"},
       {"phase", w.phase, "rad"},
       {"start", w.start, "s"},
       {"stop", w.stop < kNever ? w.stop : 0.0, "s"}},
      kShapes[static_cast<std::size_t>(w.kind)]);
}

void addPotential(const ForceField& f, Feature& feature) {
  using Potential = ForceField::Potential;
  if (f.potential == Potential::polynomial)
    return add(feature, "potential", {}, "polynomial of " + std::to_string(f.terms.size()) + " terms");
  const bool ripple = f.potential == Potential::ripple;
  add(feature, "potential", {{"depth", f.depth, "J"}, {"wavelength", ripple ? f.sigma.x : 0.0, "m"}},
      ripple ? "ripple" : "gaussian");
  if (!ripple) addAxes(feature, "sigma", f.sigma, "m");
}

/// The properties of a field's law, by its kind.
void addLaw(const ForceField& f, Feature& feature) {
  using Kind = ForceField::Kind;
  switch (f.kind) {
    case Kind::spring:
    case Kind::guide:
      return addSpring(f, feature);
    case Kind::constant:
      return addAxes(feature, "force", f.force, "N");
    case Kind::waveform:
      addAxes(feature, "force", f.force, "N");
      return addWaveform(f.waveform, feature);
    case Kind::damper:
    case Kind::viscosity:
      return addAxes(feature, "damping", f.damping, "N·s/m");
    case Kind::gravity:
      add(feature, "gravity",
          {{"surfaceForce", f.strength / (f.radius * f.radius), "N"},
           {"radius", f.radius, "m"},
           {"range", f.range, "m"},
           {"fade", f.fade, "m"}});
      break;
    case Kind::potential:
      addPotential(f, feature);
      break;
  }
  add(feature, "stiffness", {{"stiffness", assets::steepest(f), "N/m"}});
}

void addRegion(const assets::FieldRegion& r, Feature& feature) {
  using Kind = assets::FieldRegion::Kind;
  if (r.kind == Kind::sphere)
    add(feature, "region", {{"radius", r.radius, "m"}, {"fade", r.fade, "m"}}, "sphere");
  if (r.kind == Kind::box)
    add(feature, "region",
        {{"x", 2.0 * r.halfSize.x, "m"},
         {"y", 2.0 * r.halfSize.y, "m"},
         {"z", 2.0 * r.halfSize.z, "m"},
         {"fade", r.fade, "m"}},
        "box");
}

}  // namespace

std::vector<Feature> surfaceFeatures(const assets::Scene& scene, const FeatureLimits& limits) {
  std::vector<Feature> all;
  for (const assets::Part& part : scene.parts) {
    for (const std::uint16_t material : materialsOf(scene, part)) {
      if (material >= scene.materials.size()) continue;
      Feature feature = materialFeature(scene, part, material, limits);
      if (!feature.effects.empty() || !feature.remarks.empty()) all.push_back(std::move(feature));
    }
  }
  return all;
}

std::vector<Feature> fieldFeatures(const assets::Scene& scene, const FeatureLimits& limits) {
  std::vector<Feature> all;
  for (const ForceField& field : scene.fields) {
    const double slope = assets::steepest(field);
    const std::string part = field.part == kNoPart ? "" : scene.parts[field.part].name;
    Feature feature{field.name, assets::nameOf(field.kind), part, {}, {}, assets::kNone};
    feature.effects.push_back({"energy", {}, assets::nameOf(assets::passivity(field))});
    feature.effects.push_back({"limit", {{"maxForce", field.maxForce, "N"}}});
    addLaw(field, feature);
    addRegion(field.region, feature);
    remark(feature, "field stiffness", limits.stiffest > 0.0 && slope > limits.stiffest,
           "changes by " + number(slope) + " N/m, stiffer than is stable on this device");
    remark(feature, "field force", limits.maxForce > 0.0 && field.maxForce > limits.maxForce,
           "gives up to " + number(field.maxForce) + " N, more than the " + number(limits.maxForce) +
               " N of this device");
    remarkHeld(feature, "damping", std::max({field.damping.x, field.damping.y, field.damping.z}),
               limits.damping, "N·s/m");
    all.push_back(std::move(feature));
  }
  return all;
}

std::vector<Feature> controlFeatures(const assets::Scene& scene, const FeatureLimits& limits) {
  std::vector<Feature> all;
  for (const assets::Control& control : scene.controls) all.push_back(controlFeature(scene, control, limits));
  return all;
}

std::vector<RemarkGroup> groupRemarks(const std::vector<Feature>& features) {
  std::vector<RemarkGroup> groups;
  std::map<std::string, std::pair<std::size_t, std::set<std::uint32_t>>>
      seen;  // by kind: index of the group, and its materials
  for (const Feature& feature : features) {
    for (const Remark& remark : feature.remarks) {
      const auto [it, isNew] = seen.try_emplace(remark.kind, groups.size(), std::set<std::uint32_t>{});
      if (isNew) groups.push_back({remark.kind, remark.text, feature.name, 0, 0});
      RemarkGroup& group = groups[it->second.first];
      ++group.features;
      if (feature.material != assets::kNone && it->second.second.insert(feature.material).second)
        ++group.materials;
    }
  }
  return groups;
}

std::vector<Feature> oneEachMaterial(const std::vector<Feature>& surfaces) {
  std::vector<Feature> each;
  std::map<std::uint32_t, std::pair<std::size_t, std::size_t>>
      seen;  // by material: index of the feature, and the number of further parts
  for (const Feature& feature : surfaces) {
    const auto [it, isNew] = seen.try_emplace(feature.material, each.size(), 0);
    if (isNew)
      each.push_back(feature);
    else
      ++it->second.second;
  }
  for (const auto& [material, place] : seen) {
    if (place.second == 0) continue;
    Feature& feature = each[place.first];
    feature.name += " and " + std::to_string(place.second) + " more";
    feature.part = feature.name;
  }
  return each;
}

std::string inOneLine(const Feature& feature) {
  std::string line = feature.name;
  if (!feature.kind.empty()) line += ", " + feature.kind;
  if (!feature.part.empty() && feature.part != feature.name) line += ", of " + feature.part;
  const char* between = ": ";
  for (const Effect& effect : feature.effects) {
    line += between;
    between = "; ";
    line += effect.name;
    if (!effect.text.empty()) line += " " + effect.text;
    bool first = effect.text.empty();
    for (const Quantity& quantity : effect.quantities) {
      line += first ? " " : ", ";
      first = false;
      if (quantity.name != effect.name) line += quantity.name + " ";
      line += number(quantity.value) + (quantity.unit.empty() ? "" : " " + quantity.unit);
    }
  }
  return line;
}

std::string jsonKey(const Quantity& quantity) {
  std::string key;
  for (const char c : quantity.name) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isupper(byte) != 0) key += '_';
    key += static_cast<char>(std::tolower(byte));
  }
  static const std::pair<const char*, const char*> kUnits[] = {{"m", "m"},
                                                               {"rad", "rad"},
                                                               {"N", "n"},
                                                               {"N·m", "nm"},
                                                               {"J", "j"},
                                                               {"N/m", "n_per_m"},
                                                               {"N·m/rad", "nm_per_rad"},
                                                               {"N·s/m", "ns_per_m"},
                                                               {"N·m·s/rad", "nms_per_rad"},
                                                               {"Hz", "hz"},
                                                               {"s", "s"},
                                                               {"kg", "kg"},
                                                               {"kg·m^2", "kgm2"}};
  for (const auto& [unit, suffix] : kUnits)
    if (quantity.unit == unit) return key + "_" + suffix;
  return key;
}

}  // namespace tandem::client
