#include "client/scene_features.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <initializer_list>
#include <utility>

namespace tandem::client {
namespace {

using assets::Surface;
using assets::SurfaceTexture;

constexpr double kTurn = 6.283185307179586;

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

/// Those that are not zero.
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
  static const char* const kNames[] = {"", "", "sine", "grid", "bumps", "noise"};
  if (texture.pattern == SurfaceTexture::Pattern::none) return;
  const bool isImage = texture.pattern == SurfaceTexture::Pattern::image;
  add(feature, "texture",
      {{"amplitude", texture.amplitude, "m"},
       {"amplitude", texture.amplitudeForce, "N"},
       {"wavelength", texture.wavelength, "m"},
       {"frictionScale", texture.frictionScale == 1.0 ? 0.0 : texture.frictionScale, ""}},
      isImage ? imageText(scene, texture) : kNames[static_cast<std::size_t>(texture.pattern)]);
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

void remark(Feature& feature, bool applies, std::string text) {
  if (applies) feature.remarks.push_back(std::move(text));
}

/// One number of a pair is zero, so that nothing comes of the other.
bool half(double a, double b) { return (a == 0.0) != (b == 0.0); }

void judgeMaterial(const assets::Material& m, const FeatureLimits& limits, Feature& feature) {
  remark(feature, limits.contact > 0.0 && m.stiffness > limits.contact,
         "stiffness is felt as " + number(limits.contact) + " N/m, the most on this device");
  remark(feature, m.dynamicFriction > m.staticFriction,
         "dynamic friction is more than static: what has begun to slide is held more firmly");
}

void judgeSurface(const assets::Material& m, const Surface& s, const FeatureLimits& limits,
                  Feature& feature) {
  const SurfaceTexture& t = s.texture;
  remark(feature, half(s.vibrationFrequency, s.vibrationAmplitude),
         "vibration needs a frequency and an amplitude: not felt");
  remark(feature, s.vibrationAmplitude > 0.0 && s.vibrationFrequency >= 0.5 * limits.tickRate,
         "vibration at " + number(s.vibrationFrequency) + " Hz cannot be shown at " +
             number(limits.tickRate) + " ticks a second: not felt");
  remark(feature, half(s.stickSlipForce, s.stickSlipStiffness),
         "stickSlip needs a force and a stiffness: not felt");
  remark(feature, half(s.magneticForce, s.magneticDistance),
         "magnetic needs a force and a distance: not felt");
  remark(feature, s.law == Surface::Law::viscoelastic && !(s.stiffness2 > 0.0 && s.relaxation > 0.0),
         "viscoelastic needs stiffness2 and relaxation: felt as elastic");
  remark(feature, s.law == Surface::Law::plastic && s.yieldForce == 0.0,
         "plastic without a yield force: every touch leaves a dent");
  remark(feature,
         t.pattern != SurfaceTexture::Pattern::none && t.amplitude == 0.0 && t.amplitudeForce == 0.0 &&
             t.frictionScale == 1.0,
         "texture without an amplitude or a frictionScale: not felt");
  remark(feature, t.wavelength > 0.0 && t.amplitude * kTurn > t.wavelength,
         "relief climbs more steeply than 45 degrees: it catches the tool more than it lifts it");
  remark(feature, limits.maxForce > 0.0 && s.popThroughForce > limits.maxForce,
         "popThrough at " + number(s.popThroughForce) + " N is more than the " + number(limits.maxForce) +
             " N of this device: felt only as the tool goes deeper than that force shows");
  remark(feature,
         s.law == Surface::Law::viscoelastic && limits.contact > 0.0 && m.stiffness <= limits.contact &&
             m.stiffness + s.stiffness2 > limits.contact,
         "stiffness and stiffness2 together are felt as " + number(limits.contact) +
             " N/m, the most on this device");
}

std::vector<std::uint16_t> materialsOf(const assets::Scene& scene, const assets::Part& part) {
  std::vector<std::uint16_t> used;
  for (const assets::ImplicitShape& shape : part.shapes) used.push_back(shape.material);
  if (part.shapes.empty() && part.mesh != assets::kNone) used = scene.meshes[part.mesh].triangleMaterial;
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  return used;
}

Feature materialFeature(const assets::Scene& scene, const assets::Part& part, const assets::Material& m,
                        const FeatureLimits& limits) {
  Feature feature{part.name, m.name, part.name, {}, {}};
  add(feature, "stiffness", {{"stiffness", m.stiffness, "N/m"}});
  add(feature, "damping", {{"damping", m.damping, "N·s/m"}});
  add(feature, "friction", {{"static", m.staticFriction, ""}, {"dynamic", m.dynamicFriction, ""}});
  judgeMaterial(m, limits, feature);
  if (m.surface >= scene.surfaces.size()) return feature;
  addEffects(scene, scene.surfaces[m.surface], feature);
  judgeSurface(m, scene.surfaces[m.surface], limits, feature);
  return feature;
}

std::string rolesText(std::uint32_t roles) {
  std::string text;
  for (const auto& [bit, name] : {std::pair{0u, "observer"}, {1u, "participant"}, {2u, "instructor"}})
    if ((roles >> bit & 1u) != 0) text += (text.empty() ? "" : ", ") + std::string(name);
  return text.empty() ? "nobody" : text;
}

Feature controlFeature(const assets::Scene& scene, const assets::Control& c, const FeatureLimits& limits) {
  const std::string way = turns(c) ? "rad" : "m", force = turns(c) ? "N·m" : "N";
  Feature feature{c.name, toString(c.kind), scene.parts[c.part].name, {}, {}};
  feature.effects.push_back({"range",
                             {{"min", c.min, way}, {"max", c.max, way}, {"value", c.initial, way}},
                             c.endless ? "endless" : ""});
  if (c.springStiffness > 0.0)
    feature.effects.push_back(
        {"spring", {{"stiffness", c.springStiffness, force + "/" + way}, {"rest", c.springRest, way}}});
  add(feature, "damping", {{"damping", c.damping, force + "·s/" + way}});
  add(feature, "friction", {{"friction", c.friction, force}});
  add(feature, "inertia", {{"inertia", c.inertia, turns(c) ? "kg·m^2" : "kg"}});
  if (c.detents.force > 0.0 && !c.detents.places.empty())
    add(feature, "detents", {{"force", c.detents.force, force}, {"width", c.detents.width, way}},
        std::to_string(c.detents.places.size()) + " places");
  if (c.click.drop > 0.0)
    feature.effects.push_back(
        {"click", {{"at", c.click.at, way}, {"drop", c.click.drop, force}, {"width", c.click.width, way}}});
  feature.effects.push_back({"roles", {}, rolesText(c.roles)});
  std::string shown;
  for (const PartId part : c.shows) shown += (shown.empty() ? "" : ", ") + scene.parts[part].name;
  if (!shown.empty()) feature.effects.push_back({"shows", {{"threshold", c.threshold, way}}, shown});
  remark(feature, (c.roles & 7u) == 0, "no role may move it");
  remark(feature, limits.maxForce > 0.0 && !turns(c) && c.click.drop > limits.maxForce,
         "its click of " + number(c.click.drop) + " N is more than the " + number(limits.maxForce) +
             " N of this device");
  return feature;
}

}  // namespace

std::vector<Feature> surfaceFeatures(const assets::Scene& scene, const FeatureLimits& limits) {
  std::vector<Feature> all;
  for (const assets::Part& part : scene.parts) {
    for (const std::uint16_t material : materialsOf(scene, part)) {
      if (material >= scene.materials.size()) continue;
      Feature feature = materialFeature(scene, part, scene.materials[material], limits);
      if (!feature.effects.empty() || !feature.remarks.empty()) all.push_back(std::move(feature));
    }
  }
  return all;
}

std::vector<Feature> fieldFeatures(const assets::Scene& scene, const FeatureLimits& limits) {
  std::vector<Feature> all;
  for (const assets::ForceField& field : scene.fields) {
    const double slope = assets::steepest(field);
    Feature feature{field.name,
                    assets::nameOf(field.kind),
                    field.part == kNoPart ? "" : scene.parts[field.part].name,
                    {},
                    {}};
    feature.effects.push_back({"energy", {}, assets::nameOf(assets::passivity(field))});
    feature.effects.push_back({"limit", {{"maxForce", field.maxForce, "N"}}});
    add(feature, "stiffness", {{"stiffness", slope, "N/m"}});
    remark(feature, limits.stiffest > 0.0 && slope > limits.stiffest,
           "stiffer than is stable on this device");
    remark(feature, limits.maxForce > 0.0 && field.maxForce > limits.maxForce,
           "gives up to " + number(field.maxForce) + " N, more than the " + number(limits.maxForce) +
               " N of this device");
    all.push_back(std::move(feature));
  }
  return all;
}

std::vector<Feature> controlFeatures(const assets::Scene& scene, const FeatureLimits& limits) {
  std::vector<Feature> all;
  for (const assets::Control& control : scene.controls) all.push_back(controlFeature(scene, control, limits));
  return all;
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
