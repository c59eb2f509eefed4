#include "assets/gltf/gltf_controls.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include <glm/geometric.hpp>

#include "assets/base/affine.h"
#include "assets/base/constants.h"
#include "assets/gltf/gltf_json.h"
#include "assets/scene/describe.h"
#include "assets/scene/value_ranges.h"

namespace tandem::assets {
namespace {

/// The shortest rotation from X to a unit direction.
glm::dquat fromX(const glm::dvec3& direction) {
  const glm::dvec3 x(1.0, 0.0, 0.0);
  const double cosine = glm::dot(x, direction);
  if (cosine < -1.0 + 1e-12) return {0.0, 0.0, 0.0, 1.0};  // half a turn about Z
  const glm::dvec3 axis = glm::cross(x, direction);
  return glm::normalize(glm::dquat(1.0 + cosine, axis.x, axis.y, axis.z));
}

/// Inertia of a part along or about the axis of its control.
double inertiaOf(const Part& part, const Control& control) {
  const MassProperties& m = part.massProperties;
  if (!turns(control)) return m.mass;
  const glm::dvec3 axis = transformVector(inverse(part.worldFromPart), axisOf(control));
  const glm::dvec3 centre = transformPoint(part.worldFromPart, m.centreOfMass);
  const glm::dvec3 arm = glm::cross(axisOf(control), centre - control.worldFromAxis.position);
  return glm::dot(axis, m.inertia * axis) + m.mass * glm::dot(arm, arm);
}

class ControlReader {
 public:
  ControlReader(const Scene& scene, const std::vector<FlatNode>& nodes, const std::vector<PartId>& partOfNode,
                double unitScale)
      : scene_(scene), nodes_(nodes), partOfNode_(partOfNode), unitScale_(unitScale) {
    for (std::size_t i = 0; i < nodes.size(); ++i) flatOf_[nodes[i].gltfNode] = i;
  }

  Control read(const JsonObject& object, std::size_t flat) const {
    Control control;
    control.part = partOfNode_[flat];
    if (control.part == kNoPart || !scene_.parts[control.part].movable)
      throw GltfError(object.place(), "its node must be a body with a motion");
    control.name = cleanText(object.text("name", scene_.parts[control.part].name));
    control.kind = object.choice<ControlKind>("kind", "", kControlNames);
    // Angles are in rad in every file; lengths are in the file's unit.
    const double scale = turns(control) ? 1.0 : unitScale_;
    const bool joined = readJoint(object, control);
    if (!joined) readAxis(object, flat, scale, control);
    readStops(object, scale, joined, control);
    readFeel(object, scale, control);
    readRoles(object, control);
    readShows(object, scale, control);
    refuseFault(outOfRange(control), object.place());
    return control;
  }

 private:
  // --- axis

  /// Sets the frame with X along the axis, and the part's pose in it, from their present poses.
  void place(const glm::dvec3& origin, const glm::dvec3& direction, Control& control) const {
    control.worldFromAxis = {origin, fromX(direction)};
    control.axisFromPart = Pose{};
    const Pose worldFromAxisNow = poseAt(control, control.initial);
    control.axisFromPart = inverse(worldFromAxisNow) * scene_.parts[control.part].worldFromPart;
  }

  void readAxis(const JsonObject& object, std::size_t flat, double scale, Control& control) const {
    const auto axis = object.vector("axis");
    if (!axis)
      object.fail("axis", "is missing, and no joint with one free axis holds the part to something fixed");
    const glm::dmat4& worldFromNode = nodes_[flat].worldFromNode;
    const glm::dvec3 direction(worldFromNode * glm::dvec4(*axis, 0.0));
    const double length = glm::length(direction);
    if (!(length > 0.0) || !std::isfinite(length)) object.fail("axis", "must not be zero");
    const glm::dvec3 origin(worldFromNode *
                            glm::dvec4(object.vector("origin").value_or(glm::dvec3(0.0)), 1.0));
    control.initial = object.numberOr("value", 0.0) * scale;
    place(origin, direction / length, control);
  }

  /// The one free axis of a joint, 0..2, linear or angular as the control needs. Nothing unless all other
  /// axes are locked.
  static std::optional<int> freeAxis(const Joint& joint, bool angular) {
    std::uint8_t locked[2] = {0, 0};  // linear, angular
    for (const JointLimit& limit : joint.limits)
      if (limit.min == limit.max && limit.stiffness == 0.0)
        locked[limit.angular] = static_cast<std::uint8_t>(locked[limit.angular] | limit.axes);
    const unsigned open = ~unsigned{locked[angular]} & 7u;
    if (locked[!angular] != 7 || (open != 1 && open != 2 && open != 4)) return std::nullopt;
    return open == 4 ? 2 : static_cast<int>(open) - 1;
  }

  bool readJoint(const JsonObject& object, Control& control) const {
    for (const Joint& joint : scene_.joints) {
      if (joint.partA != control.part && joint.partB != control.part) continue;
      const bool isA = joint.partA == control.part;
      if ((isA ? joint.partB : joint.partA) != kNoPart) continue;
      const auto axis = freeAxis(joint, turns(control));
      if (!axis) continue;
      for (const char* key : {"axis", "origin", "value"})
        if (object.has(key)) object.fail(key, "is given by the joint '" + joint.name + "'");
      const Pose& part = scene_.parts[control.part].worldFromPart;
      const Pose worldFromA = (isA ? part : Pose{}) * joint.aFromJoint;
      const Pose worldFromB = (isA ? Pose{} : part) * joint.bFromJoint;
      // The extension measures B relative to A (its appendix on limits), so a control that is A moves the
      // opposite way.
      glm::dvec3 unit(0.0);
      unit[*axis] = 1.0;
      const glm::dvec3 direction = transformVector(worldFromA, unit);
      const Pose aFromB = inverse(worldFromA) * worldFromB;
      control.initial = turns(control)
                            ? 2.0 * std::atan2(glm::dot(glm::dvec3(aFromB.orientation.x, aFromB.orientation.y,
                                                                   aFromB.orientation.z),
                                                        unit),
                                               aFromB.orientation.w)
                            : aFromB.position[*axis];
      if (control.initial > kPi) control.initial -= 2.0 * kPi;
      for (const JointLimit& limit : joint.limits)
        if (limit.angular == turns(control) && (limit.axes >> *axis & 1) != 0)
          control.min = limit.min, control.max = limit.max;
      place((isA ? worldFromB : worldFromA).position, isA ? -direction : direction, control);
      return true;
    }
    return false;
  }

  // --- stops

  void readStops(const JsonObject& object, double scale, bool joined, Control& control) const {
    const bool hasMin = object.has("min"), hasMax = object.has("max");
    if (!joined && !hasMax && (hasMin || !turns(control))) object.fail("max", "is missing");
    if (hasMin) control.min = *object.number("min") * scale;
    if (hasMax) control.max = *object.number("max") * scale;
    const bool bounded = std::abs(control.min) < 1e299 && std::abs(control.max) < 1e299;
    if (turns(control) && (!bounded || (control.min == control.max && !hasMin && !hasMax))) {
      control.endless = true;
      control.min = -kPi;
      control.max = kPi;
      return;
    }
    if (!bounded || !(control.min < control.max)) object.fail("max", "must be larger than min");
    if (turns(control) && !(control.max - control.min < 2.0 * kPi - 1e-3))
      object.fail("max", "a dial with stops turns less than once; leave both out for an endless one");
    const double slack = 1e-6 * (control.max - control.min);
    if (control.initial < control.min - slack || control.initial > control.max + slack)
      object.fail("value", "the part does not stand between min and max");
    const double inside = std::clamp(control.initial, control.min, control.max);
    control.initial = inside;
  }

  // --- feel

  void readFeel(const JsonObject& object, double scale, Control& control) const {
    control.inertia = object.sizeOr("inertia", inertiaOf(scene_.parts[control.part], control));
    if (!(control.inertia > 0.0)) object.fail("inertia", "must be positive, or its part have a mass");
    control.damping = object.sizeOr("damping", 0.0);
    control.friction = object.sizeOr("friction", 0.0);
    if (const auto spring = object.object("spring")) {
      control.springStiffness = spring->sizeOr("stiffness", 0.0);
      control.springRest = spring->has("rest") ? *spring->number("rest") * scale : control.min;
    }
    if (const auto click = object.object("click")) readClick(*click, scale, control);
    if (const auto detents = object.object("detents")) readDetents(*detents, scale, control);
  }

  static void readClick(const JsonObject& object, double scale, Control& control) {
    const double range = control.max - control.min;
    control.click.at = object.numberOr("at", (control.min + 0.5 * range) / scale) * scale;
    control.click.drop = object.sizeOr("drop", 0.0);
    control.click.width = object.sizeOr("width", 0.2 * range / scale) * scale;
    if (control.click.at <= control.min || control.click.at >= control.max)
      object.fail("at", "must lie between min and max");
    if (!(control.click.width > 0.0)) object.fail("width", "must be positive");
    if (control.endless && control.click.drop > 0.0)
      object.fail("drop", "an endless dial has no click; give it detents");
  }

  static std::vector<double> detentPlaces(const JsonObject& object, double scale, const Control& control) {
    if (object.has("count") == object.has("positions"))
      object.fail("count", "needs either count or positions");
    std::vector<double> places;
    if (object.has("count")) {
      const std::size_t count = object.requiredIndex("count", kMaxDetents + 1, "detents");
      if (count < 2) object.fail("count", "must be at least 2");
      // On an endless dial the first place follows the last one.
      const double gap =
          (control.max - control.min) / static_cast<double>(control.endless ? count : count - 1);
      for (std::size_t i = 0; i < count; ++i) places.push_back(control.min + gap * static_cast<double>(i));
      if (!control.endless) places.back() = control.max;
      return places;
    }
    const std::size_t size = object.count("positions");
    if (size > kMaxDetents) object.fail("positions", "are more than 4096");
    places = object.numbers("positions", size).value();
    for (double& place : places) place *= scale;
    return places;
  }

  static void readDetents(const JsonObject& object, double scale, Control& control) {
    Detents& detents = control.detents;
    detents.places = detentPlaces(object, scale, control);
    detents.force = object.sizeOr("force", 0.0);
    detents.width = object.sizeOr("width", 0.0) * scale;
    const char* key = object.has("count") ? "count" : "positions";
    for (std::size_t i = 0; i < detents.places.size(); ++i) {
      if (detents.places[i] < control.min || detents.places[i] > control.max)
        object.fail(key, "a detent lies outside of min and max");
      if (i > 0 && !(detents.places[i] > detents.places[i - 1])) object.fail(key, "must ascend");
    }
    if (detents.places.empty()) object.fail(key, "must not be empty");
    if (detents.places.size() == 1 && !(detents.width > 0.0) && !control.endless)
      object.fail("width", "is missing: a single detent has no neighbour to take it from");
  }

  // --- roles and layers

  static void readRoles(const JsonObject& object, Control& control) {
    if (!object.has("roles")) return;
    static constexpr const char* kRoles[] = {"observer", "participant", "instructor"};
    control.roles = 0;
    for (const std::string& name : object.texts("roles")) {
      const std::size_t at =
          static_cast<std::size_t>(std::find(std::begin(kRoles), std::end(kRoles), name) - kRoles);
      if (at == std::size(kRoles)) object.fail("roles", '\'' + cleanText(name) + "' is not a role");
      if (at == 0) object.fail("roles", "an observer sets nothing");
      control.roles |= 1u << at;
    }
  }

  void readShows(const JsonObject& object, double scale, Control& control) const {
    const bool layer = control.kind == ControlKind::layer;
    if (layer != object.has("shows")) object.fail("shows", layer ? "is missing" : "only a layer shows parts");
    if (!layer) return;
    control.threshold = object.numberOr("threshold", 0.5 * (control.min + control.max) / scale) * scale;
    const Json& list = object.raw("shows");
    if (!list.isArray()) object.fail("shows", "must be an array of nodes");
    for (const Json& entry : list) {
      const auto flat = entry.isNatural() ? flatOf_.find(entry.integer()) : flatOf_.end();
      const PartId part = flat == flatOf_.end() ? kNoPart : partOfNode_[flat->second];
      if (part == kNoPart) object.fail("shows", "names a node that is no part of the scene");
      if (part == control.part) object.fail("shows", "a layer cannot show itself");
      control.shows.push_back(part);
    }
  }

  const Scene& scene_;
  const std::vector<FlatNode>& nodes_;
  const std::vector<PartId>& partOfNode_;
  const double unitScale_;
  std::map<std::size_t, std::size_t> flatOf_;  // glTF node to flat node
};

}  // namespace

std::vector<Control> readControls(const GltfDocument& document, const Scene& scene,
                                  const std::vector<FlatNode>& nodes, const std::vector<PartId>& partOfNode,
                                  double unitScale) {
  std::vector<Control> controls;
  const Json& list = document.json.member("nodes");
  const ControlReader reader(scene, nodes, partOfNode, unitScale);
  for (std::size_t flat = 0; flat < nodes.size(); ++flat) {
    const std::size_t node = nodes[flat].gltfNode;
    const Json& control = list.at(node).member("extras").member("haptic").member("control");
    if (control.isAbsent()) continue;
    controls.push_back(
        reader.read(JsonObject(control, placeName("nodes", node, "extras.haptic.control")), flat));
  }
  return controls;
}

}  // namespace tandem::assets
