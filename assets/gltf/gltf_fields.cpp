#include "assets/gltf/gltf_fields.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <numbers>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "assets/base/affine.h"
#include "assets/gltf/gltf_json.h"
#include "assets/scene/describe.h"
#include "assets/scene/value_ranges.h"

namespace tandem::assets {
namespace {

using FieldKind = ForceField::Kind;

constexpr double kTwoPi = 2.0 * std::numbers::pi;
// Tolerance of a node's even scale: the precision of single-precision matrices.
constexpr double kEvenScale = 1e-5;

/// Reads one field object, each property by its kind, in the node's units.
class FieldReader {
 public:
  /// Lengths become m with `scale`; directions of the file times `mirror`, 1 or -1, are directions of the
  /// field.
  FieldReader(const JsonObject& object, double scale, double mirror)
      : json_(object), scale_(scale), mirror_(mirror) {}

  ForceField read() {
    known_ = {"kind", "name", "maxForce", "region", "position", "rotation"};
    field_.name = cleanText(json_.text("name", ""));
    field_.kind = readKind();
    field_.maxForce = positive(json_, "maxForce", 3.0, 1.0);
    if (json_.has("region")) readRegion();
    readLaw();
    refuseUnknown(json_, known_);
    return field_;
  }

 private:
  static std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%g", value);
    return text;
  }

  /// > 0, times `scale`; without a fallback (0) the property is required.
  static double positive(const JsonObject& object, const char* key, double fallback, double scale) {
    if (!object.has(key) && fallback == 0.0) object.fail(key, "is missing");
    const double value = object.numberOr(key, fallback) * scale;
    if (!(value > 0.0)) object.fail(key, "must be positive");
    return value;
  }

  static void refuseUnknown(const JsonObject& object, const std::vector<std::string>& known) {
    for (const auto& [key, value] : object.raw().members()) {
      if (std::find(known.begin(), known.end(), key) != known.end()) continue;
      std::string list;
      for (const std::string& name : known) list += (list.empty() ? "" : ", ") + name;
      object.fail(key.substr(0, 40).c_str(), "is no property of this kind of field; it knows " + list);
    }
  }

  void know(std::initializer_list<const char*> names) {
    known_.insert(known_.end(), names.begin(), names.end());
  }

  FieldKind readKind() const {
    const std::string kind = json_.text("kind", "");
    const auto* known = std::find(std::begin(kFieldNames), std::end(kFieldNames), kind);
    if (known != std::end(kFieldNames)) return static_cast<FieldKind>(known - std::begin(kFieldNames));
    if (kind == "inertia" || kind == "acceleration" || kind == "mass")
      json_.fail("kind",
                 '\'' + kind +
                     "' depends on acceleration, which cannot be had: one step of a position quantised at "
                     "0.055 mm and read at 1 kHz is 55 m/s^2");
    json_.fail("kind", kind.empty()
                           ? "is missing"
                           : '\'' + kind.substr(0, 40) +
                                 "' is unknown; known are constant, spring, guide, damper, viscosity, "
                                 "waveform, gravity, potential");
  }

  void readRegion() {
    const JsonObject region = *json_.object("region");
    FieldRegion& out = field_.region;
    out.kind = region.choice<FieldRegion::Kind>("shape", region.has("size") ? "box" : "sphere", kRegionNames);
    double smallest = 0.0;
    if (out.kind == FieldRegion::Kind::box) {
      const auto size = region.vector("size");
      if (!size) region.fail("size", "is missing");
      out.halfSize = *size * (0.5 * scale_);
      smallest = std::min({out.halfSize.x, out.halfSize.y, out.halfSize.z});
      if (!(smallest > 0.0)) region.fail("size", "must be positive");
    } else {
      smallest = out.radius = positive(region, "radius", 0.0, scale_);
    }
    out.fade = region.has("fade") ? positive(region, "fade", 0.0, scale_) : 0.1 * smallest;
    if (out.fade > smallest * (1.0 + 1e-12))
      region.fail("fade", "is larger than the region reaches from its centre");
    refuseUnknown(region, {"shape", "size", "radius", "fade"});
  }

  void readLaw() {
    switch (field_.kind) {
      case FieldKind::constant:
        know({"force"});
        return readForce();
      case FieldKind::waveform:
        know({"force", "waveform"});
        readForce();
        return readWaveform();
      case FieldKind::spring:
        know({"to", "axis", "oneSided", "points", "closed", "curve", "stiffness", "damping", "radius",
              "range", "fade"});
        return readSpring();
      case FieldKind::guide:
        know({"points", "closed", "curve", "stiffness", "damping", "radius", "range", "fade", "drive"});
        return readSpring();
      case FieldKind::damper:
      case FieldKind::viscosity:
        know({"damping"});
        return readDamping();
      case FieldKind::gravity:
        know({"strength", "surfaceForce", "radius", "range", "fade"});
        return readGravity();
      case FieldKind::potential:
        know({"function"});
        return readPotential();
    }
  }

  glm::dvec3 direction(const JsonObject& object, const char* key) const {
    const glm::dvec3 axis = object.vector(key).value_or(glm::dvec3(0.0, 1.0, 0.0));
    const double length = glm::length(axis);
    if (!(length > 1e-9 && length < 1e9)) object.fail(key, "must not be zero");
    return axis * (mirror_ / length);
  }

  void readForce() {
    const auto force = json_.vector("force");
    if (!force) json_.fail("force", "is missing");
    field_.force = *force * mirror_;
    withinMaximum("force", glm::length(field_.force));
  }

  /// Refuses a law whose largest force, where it is known, exceeds maxForce.
  void withinMaximum(const char* key, double force) const {
    if (!(force <= field_.maxForce * (1.0 + 1e-12)))
      json_.fail(key, "gives up to " + number(force) + " N, more than maxForce, which is " +
                          number(field_.maxForce) + " N");
  }

  void readWaveform() {
    const auto object = json_.object("waveform");
    if (!object) json_.fail("waveform", "is missing");
    const JsonObject& w = *object;
    FieldWaveform& out = field_.waveform;
    out.kind = w.choice<FieldWaveform::Kind>("shape", "sine", kWaveformNames);
    std::vector<std::string> known{"shape", "frequency", "phase", "start", "stop"};
    out.frequency = positive(w, "frequency", 0.0, 1.0);
    out.phase = w.numberOr("phase", 0.0);
    out.start = w.numberOr("start", 0.0);
    out.stop = w.numberOr("stop", 1e300);
    if (!(out.stop > out.start)) w.fail("stop", "must be later than start");
    if (out.kind == FieldWaveform::Kind::square) {
      out.width = w.sizeOr("edge", 0.05 / out.frequency);
      if (out.width > 0.5 / out.frequency) w.fail("edge", "is longer than half a period");
      known.push_back("edge");
    } else if (out.kind == FieldWaveform::Kind::chirp) {
      out.endFrequency = positive(w, "endFrequency", 0.0, 1.0);
      out.sweep = positive(w, "sweep", 1.0, 1.0);
      known.insert(known.end(), {"endFrequency", "sweep"});
    } else if (out.kind == FieldWaveform::Kind::pulses) {
      out.width = positive(w, "width", 0.0, 1.0);
      if (out.width > 1.0 / out.frequency) w.fail("width", "is longer than a period");
      known.push_back("width");
    }
    refuseUnknown(w, known);
  }

  void readDamping() {
    if (!json_.has("damping")) json_.fail("damping", "is missing");
    if (json_.raw("damping").isArray())
      field_.damping = *json_.vector("damping");
    else
      field_.damping = glm::dvec3(json_.sizeOr("damping", 0.0));
    if (field_.kind == FieldKind::viscosity && field_.region.kind == FieldRegion::Kind::everywhere)
      json_.fail("region", "is missing: a viscosity fills a volume");
  }

  void readRange() {
    if (!json_.has("range")) {
      if (json_.has("fade")) json_.fail("fade", "needs a range");
      return;
    }
    field_.range = positive(json_, "range", 0.0, scale_);
    if (!(field_.range > field_.radius)) json_.fail("range", "must be larger than radius");
    const double room = field_.range - (field_.kind == FieldKind::gravity ? 0.0 : field_.radius);
    field_.fade = json_.has("fade") ? positive(json_, "fade", 0.0, scale_) : 0.25 * room;
    if (field_.fade > room * (1.0 + 1e-12)) json_.fail("fade", "is larger than range leaves room for");
  }

  void readSpring() {
    using Anchor = ForceField::Anchor;
    field_.anchor =
        field_.kind == FieldKind::guide ? Anchor::path : json_.choice<Anchor>("to", "point", kAnchorNames);
    field_.stiffness = positive(json_, "stiffness", 0.0, 1.0);
    field_.damping.x = json_.sizeOr("damping", 0.0);
    field_.radius = json_.sizeOr("radius", 0.0) * scale_;
    field_.oneSided = json_.flag("oneSided", false);
    if (field_.oneSided && field_.anchor != Anchor::plane) json_.fail("oneSided", "is for planes only");
    if (field_.anchor == Anchor::line || field_.anchor == Anchor::plane)
      field_.axis = direction(json_, "axis");
    else if (json_.has("axis"))
      json_.fail("axis", "is for lines and planes only");
    field_.drive = json_.numberOr("drive", 0.0);
    withinMaximum("drive", std::abs(field_.drive));
    readRange();
    if (field_.anchor == Anchor::path)
      readPath();
    else if (json_.has("points"))
      json_.fail("points", "are for paths only");
  }

  void readPath() {
    const Json& points = json_.raw("points");
    const std::string reason =
        "must be an array of 2 to " + std::to_string(kMaxPathPoints) + " points [x, y, z]";
    if (!points.isArray() || points.size() < 2 || points.size() > kMaxPathPoints)
      json_.fail("points", reason);
    for (const Json& entry : points) {
      if (!entry.isArray() || entry.size() != 3) json_.fail("points", reason);
      glm::dvec3 p;
      for (int i = 0; i < 3; ++i) {
        const Json& value = entry.at(static_cast<std::size_t>(i));
        if (!value.isNumber() || !std::isfinite(value.number())) json_.fail("points", reason);
        p[i] = value.number() * scale_ * mirror_;
      }
      if (!field_.points.empty() && field_.points.back() == p)
        json_.fail("points", "two in a row are the same");
      field_.points.push_back(p);
    }
    constexpr const char* kCurves[] = {"catmull-rom", "polyline"};
    field_.smooth = json_.choice<int>("curve", "catmull-rom", kCurves) == 0;
    field_.closed = json_.flag("closed", false);
    if (field_.closed && (field_.points.size() < 3 || field_.points.front() == field_.points.back()))
      json_.fail("closed", "needs three points at least, of which the last is not the first");
  }

  void readGravity() {
    field_.radius = positive(json_, "radius", 0.0, scale_);
    if (json_.has("strength") == json_.has("surfaceForce"))
      json_.fail("strength", "needs either strength (N*m^2) or surfaceForce (N, at the radius)");
    field_.strength = json_.has("strength")
                          ? json_.numberOr("strength", 0.0)
                          : json_.numberOr("surfaceForce", 0.0) * field_.radius * field_.radius;
    readRange();
  }

  void readPotential() {
    using Potential = ForceField::Potential;
    field_.potential = json_.choice<Potential>("function", "", kPotentialNames);
    if (field_.potential == Potential::gaussian) {
      know({"depth", "sigma"});
      readDepth();
      if (json_.raw("sigma").isArray())
        field_.sigma = *json_.vector("sigma") * scale_;
      else
        field_.sigma = glm::dvec3(positive(json_, "sigma", 0.0, scale_));
      const double least = std::min({field_.sigma.x, field_.sigma.y, field_.sigma.z});
      if (!(least > 0.0)) json_.fail("sigma", "must be positive");
      withinMaximum("depth", std::abs(field_.depth) / least * std::exp(-0.5));
    } else if (field_.potential == Potential::ripple) {
      know({"depth", "wavelength", "axis"});
      readDepth();
      field_.axis = direction(json_, "axis");
      field_.sigma = glm::dvec3(positive(json_, "wavelength", 0.0, scale_), 0.0, 0.0);
      withinMaximum("depth", std::abs(field_.depth) * kTwoPi / field_.sigma.x);
    } else {
      know({"terms"});
      readTerms();
    }
  }

  void readDepth() {
    if (!json_.has("depth")) json_.fail("depth", "is missing");
    field_.depth = json_.numberOr("depth", 0.0);
  }

  void readTerms() {
    const std::vector<JsonObject> terms = json_.objects("terms");
    if (terms.empty() || terms.size() > kMaxPotentialTerms)
      json_.fail("terms", "must be 1 to " + std::to_string(kMaxPotentialTerms) + " objects");
    for (const JsonObject& entry : terms) {
      PotentialTerm term;
      term.coefficient = entry.numberOr("coefficient", 0.0);
      const auto powers = entry.numbers("powers", 3);
      if (!powers) entry.fail("powers", "is missing");
      int sum = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        const double power = (*powers)[i];
        if (!(power >= 0.0 && power <= kMaxPotentialPower && power == std::floor(power)))
          entry.fail("powers", "must be whole numbers from 0 to " + std::to_string(kMaxPotentialPower));
        term.powers[i] = static_cast<std::uint8_t>(power);
        sum += static_cast<int>(power);
      }
      if (mirror_ < 0.0 && sum % 2 != 0) term.coefficient = -term.coefficient;
      refuseUnknown(entry, {"coefficient", "powers"});
      field_.terms.push_back(term);
    }
  }

  const JsonObject& json_;
  const double scale_, mirror_;
  std::vector<std::string> known_;
  ForceField field_;
};

/// A rigid frame and the one factor by which its lengths are scaled; `mirror` is -1 where the map mirrors.
struct EvenFrame {
  Pose rigid;
  double scale = 1.0, mirror = 1.0;
};

EvenFrame evenFrame(const glm::dmat4& map, const std::string& place) {
  const std::optional<RigidSplit> split = splitRigid(map);
  if (!split) throw GltfError(place, "the node is scaled to zero");
  const double scale = split->residual[0][0];
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r)
      if (!(std::abs(split->residual[c][r] - (c == r ? scale : 0.0)) <= kEvenScale * std::abs(scale)))
        throw GltfError(place, "the node is scaled unevenly, which a field cannot be");
  return {split->rigid, std::abs(scale), scale < 0.0 ? -1.0 : 1.0};
}

class FieldsReader {
 public:
  FieldsReader(const GltfDocument& document, const std::vector<FlatNode>& nodes, double unitScale)
      : document_(document), nodes_(nodes), unitScale_(unitScale) {}

  std::vector<PlacedField> read() {
    for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
      const std::size_t node = nodes_[i].gltfNode;
      const Json& field = hapticOf("nodes", node).member("field");
      if (field.isAbsent()) continue;
      const std::string place = placeName("nodes", node, "extras.haptic.field");
      readEach(field, place, nodes_[i].worldFromNode, i, document_.model.nodes[node].name);
    }
    const auto scene = static_cast<std::size_t>(std::max(0, document_.model.defaultScene));
    const Json& fields = hapticOf("scenes", scene).member("fields");
    if (!fields.isAbsent())
      readEach(fields, placeName("scenes", scene, "extras.haptic.fields"),
               glm::scale(glm::dmat4(1.0), glm::dvec3(unitScale_)), kNone, "");
    return std::move(out_);
  }

 private:
  /// extras.haptic of an element of a section.
  const Json& hapticOf(const char* section, std::size_t index) const {
    const Json& list = document_.json.member(section);
    if (!list.isArray() || index >= list.size()) return Json::absent();
    return list.at(index).member("extras").member("haptic");
  }

  void readEach(const Json& value, const std::string& place, const glm::dmat4& worldFromNode,
                std::uint32_t flatNode, const std::string& name) {
    if (value.isObject()) return readOne(JsonObject(value, place), worldFromNode, flatNode, name);
    if (!value.isArray()) throw GltfError(place, "must be an object or an array of objects");
    for (std::size_t i = 0; i < value.size(); ++i)
      readOne(JsonObject(value.at(i), place + "[" + std::to_string(i) + "]"), worldFromNode, flatNode, name);
  }

  void readOne(const JsonObject& object, const glm::dmat4& worldFromNode, std::uint32_t flatNode,
               const std::string& name) {
    if (out_.size() == kMaxForceFields)
      throw GltfError(object.place(), "more than " + std::to_string(kMaxForceFields) + " fields in a scene");
    const EvenFrame frame = evenFrame(worldFromNode, object.place());
    PlacedField placed;
    placed.field = FieldReader(object, frame.scale, frame.mirror).read();
    placed.field.partFromField = frame.rigid * ownPose(object, frame.scale * frame.mirror);
    placed.flatNode = flatNode;
    placed.place = object.place();
    if (placed.field.name.empty()) placed.field.name = cleanText(name);
    if (placed.field.name.empty()) placed.field.name = "field " + std::to_string(out_.size() + 1);
    refuseFault(outOfRange(placed.field), placed.place);
    out_.push_back(std::move(placed));
  }

  /// `position` and `rotation` of the field within its node.
  static Pose ownPose(const JsonObject& object, double scale) {
    Pose pose;
    pose.position = object.vector("position").value_or(glm::dvec3(0.0)) * scale;
    if (const auto q = object.numbers("rotation", 4)) {
      const glm::dquat rotation((*q)[3], (*q)[0], (*q)[1], (*q)[2]);
      const double length = glm::length(rotation);
      if (!(length > 1e-9 && length < 1e9)) object.fail("rotation", "is not a rotation");
      pose.orientation = rotation / length;
    }
    return pose;
  }

  const GltfDocument& document_;
  const std::vector<FlatNode>& nodes_;
  const double unitScale_;
  std::vector<PlacedField> out_;
};

}  // namespace

std::vector<PlacedField> readFields(const GltfDocument& document, const std::vector<FlatNode>& nodes,
                                    double unitScale) {
  return FieldsReader(document, nodes, unitScale).read();
}

}  // namespace tandem::assets
