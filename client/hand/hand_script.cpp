#include "client/hand/hand_script.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include "assets/base/assert.h"
#include "assets/base/json.h"
#include "assets/document/entry_check.h"
#include "client/base/json_input.h"
#include "haptics/base/minimum_jerk.h"
#include "haptics/geometry/primitive_distance.h"
#include "sync/wire/limits.h"

namespace tandem::client {

namespace {

constexpr double kApproachSpeed = 0.25;    // m/s, mean, when a hand goes to a part
constexpr double kApproachShortest = 0.3;  // s

// Far beyond any session, yet small enough that nothing computed from them overflows.
constexpr double kLongest = 1e5;   // s
constexpr double kMaxAngle = 1e4;  // rad
constexpr double kMaxHz = 500.0;   // half the rate of the loop

/// A field's number within +-most; throws a message for a person.
double number(const Json& step, const char* key, double most = kFarthest) {
  if (!step.contains(key)) throw std::string("lacks \"") + key + "\"";
  if (!step.at(key).isNumber() || !std::isfinite(step.at(key).number()))
    throw std::string("\"") + key + "\" must be a finite number";
  const double value = step.at(key).number();
  if (std::abs(value) > most)
    throw std::string("\"") + key + "\" must be at most " + std::to_string(static_cast<int>(most)) +
        " in size";
  return value;
}

double duration(const Json& step, const char* key) {
  const double seconds = number(step, key, kLongest);
  if (seconds < 0.0) throw std::string("\"") + key + "\" must not be negative";
  return seconds;
}

glm::dvec3 vectorOf(const Json& list, const char* key) {
  if (!list.isArray() || list.size() != 3) throw std::string("needs \"") + key + "\": [x, y, z]";
  glm::dvec3 value;
  for (int i = 0; i < 3; ++i) {
    const Json& entry = list.at(static_cast<std::size_t>(i));
    if (!entry.isNumber() || !std::isfinite(entry.number()))
      throw std::string("\"") + key + "\" must hold three finite numbers";
    if (std::abs(entry.number()) > kFarthest)
      throw std::string("\"") + key + "\" must be within " + std::to_string(static_cast<int>(kFarthest));
    value[i] = entry.number();
  }
  return value;
}

glm::dvec3 vector(const Json& step, const char* key) {
  if (!step.contains(key)) throw std::string("needs \"") + key + "\": [x, y, z]";
  return vectorOf(step.at(key), key);
}

glm::dvec3 axis(const Json& step) {
  if (step.contains("axis") && step.at("axis").isText()) {
    const std::string name = step.at("axis").text();
    if (name == "x") return {1.0, 0.0, 0.0};
    if (name == "y") return {0.0, 1.0, 0.0};
    if (name == "z") return {0.0, 0.0, 1.0};
    throw std::string("\"axis\" must be x, y, z or [x, y, z]");
  }
  const glm::dvec3 value = vector(step, "axis");
  if (glm::length(value) < 1e-12) throw std::string("\"axis\" must not be zero");
  return glm::normalize(value);
}

/// Without a scene (null) any name will do: it is looked up once the scene is there.
PartId namedPart(const Json& value, const char* key, const assets::Scene* scene) {
  if (!value.isText()) throw std::string("needs \"") + key + "\": \"NAME\"";
  if (scene == nullptr) return kNoPart;
  const std::string name = value.text();
  const PartId id = assets::findPart(*scene, name);
  if (id == kNoPart) throw "no part is named \"" + name + "\"";
  return id;
}

PartId part(const Json& step, const assets::Scene* scene) {
  return namedPart(step.contains("part") ? step.at("part") : Json(), "part", scene);
}

PartId controlPart(const Json& step, const assets::Scene* scene) {
  if (!step.contains("control") || !step.at("control").isText())
    throw std::string("needs \"control\": \"NAME\"");
  if (scene == nullptr) return kNoPart;
  const std::string name = step.at("control").text();
  for (const assets::Control& control : scene->controls)
    if (control.name == name || scene->parts[control.part].name == name) return control.part;
  throw "no control is named \"" + name + "\"";
}

/// A misspelt key would silently do something else.
void refuseUnknown(const Json& step) {
  static const char* const known[] = {
      "t",  "do",    "part",   "over_s",  "to",    "by",     "axis", "angle",  "amplitude",
      "hz", "for_s", "depth",  "control", "value", "text",   "name", "status", "measures",
      "at", "parts", "planes", "what",    "from",  "factor", "on"};
  for (const auto& item : step.members())
    if (std::find(std::begin(known), std::end(known), item.first) == std::end(known))
      throw "does not know \"" + item.first + "\"";
}

std::string text(const Json& step, const char* key, std::size_t limit) {
  if (!step.contains(key) || !step.at(key).isText() || step.at(key).text().empty())
    throw std::string("needs \"") + key + "\": \"...\"";
  document::Note note;
  note.text = step.at(key).text();
  if (note.text.size() > limit || !document::check(note))
    throw std::string("\"") + key + "\" must be at most " + std::to_string(limit) +
        " bytes of text without control characters";
  return note.text;
}

document::NoteStatus status(const Json& step) {
  const std::string name = text(step, "status", document::kMaxName);
  for (std::size_t i = 0; i < document::kNoteStatusNames.size(); ++i)
    if (name == document::kNoteStatusNames[i]) return static_cast<document::NoteStatus>(i);
  throw std::string("\"status\" must be open, in progress, resolved or closed");
}

std::vector<PartId> twoParts(const Json& step, const assets::Scene* scene) {
  const bool two = step.contains("parts") && step.at("parts").isArray() && step.at("parts").size() == 2;
  if (!two) throw std::string("needs \"parts\": [\"NAME\", \"NAME\"]");
  std::vector<PartId> parts;
  for (std::size_t i = 0; i < 2; ++i) parts.push_back(namedPart(step.at("parts").at(i), "parts", scene));
  if (scene != nullptr && parts[0] == parts[1]) throw std::string("\"parts\" names one part twice");
  return parts;
}

void parseJudge(const Json& entry, const assets::Scene* scene, ScriptStep& step) {
  const std::string name = text(entry, "status", document::kMaxName);
  const auto known = std::find(document::kClashStatusNames.begin(), document::kClashStatusNames.end(), name);
  if (known == document::kClashStatusNames.end())
    throw std::string("\"status\" must be new, active, reviewed, approved or resolved");
  step.verb = ScriptStep::Verb::judge;
  step.clash = static_cast<document::ClashStatus>(known - document::kClashStatusNames.begin());
  step.parts = twoParts(entry, scene);
  if (entry.contains("text")) step.text = text(entry, "text", document::kMaxText / 2);
}

std::vector<glm::dvec3> placesAt(const Json& entry, std::size_t most) {
  if (!entry.at("at").isArray() || entry.at("at").size() > most)
    throw "\"at\" must be a list of at most " + std::to_string(most) + " [x, y, z]";
  std::vector<glm::dvec3> places;
  for (const Json& place : entry.at("at")) places.push_back(vectorOf(place, "at"));
  return places;
}

void parseMeasure(const Json& entry, const assets::Scene* scene, ScriptStep& step) {
  const std::string kind = text(entry, "measures", document::kMaxName);
  const auto known = std::find(kFigureNames.begin(), kFigureNames.end(), kind);
  if (known == kFigureNames.end())
    throw std::string("\"measures\" must be length, diameter, distance, across, angle or clearance");
  step.verb = ScriptStep::Verb::measure;
  step.figure = static_cast<FigureKind>(known - kFigureNames.begin());
  if (entry.contains("name")) step.text = text(entry, "name", document::kMaxName);
  if (entry.contains("at")) step.places = placesAt(entry, placesOf(step.figure));
  if (!entry.contains("parts")) return;
  if (step.figure != FigureKind::clearance || entry.contains("at"))
    throw std::string("\"parts\" names two parts, of a clearance");
  step.parts = twoParts(entry, scene);
}

/// A step that writes in the session's document; false if the verb is another one.
bool parseWriting(const Json& entry, const std::string& verb, const assets::Scene* scene, ScriptStep& step) {
  using Verb = ScriptStep::Verb;
  const bool answers = verb == "reply" || verb == "status";
  if (answers && entry.contains("to")) step.to = text(entry, "to", document::kMaxText);
  if (verb == "note") {
    step.verb = Verb::note;
    step.text = text(entry, "text", document::kMaxText);
    if (entry.contains("part")) step.part = part(entry, scene);
  } else if (verb == "reply") {
    step.verb = Verb::reply;
    step.text = text(entry, "text", document::kMaxText);
  } else if (verb == "status") {
    step.verb = Verb::status;
    step.status = status(entry);
  } else if (verb == "view") {
    step.verb = Verb::view;
    step.text = text(entry, "name", document::kMaxName);
  } else if (verb == "measure") {
    parseMeasure(entry, scene, step);
  } else if (verb == "find_clashes") {
    step.verb = Verb::findClashes;
  } else if (verb == "judge") {
    parseJudge(entry, scene, step);
  } else if (verb == "undo" || verb == "redo") {
    step.verb = verb == "undo" ? Verb::undo : Verb::redo;
  } else {
    return false;
  }
  return true;
}

std::vector<document::SectionPlane> planes(const Json& step) {
  if (!step.contains("planes") || !step.at("planes").isArray() ||
      step.at("planes").size() > document::kMaxSections)
    throw std::string("needs \"planes\": at most ") + std::to_string(document::kMaxSections) +
        " of [nx, ny, nz, m]";
  std::vector<document::SectionPlane> planes;
  for (std::size_t i = 0; i < step.at("planes").size(); ++i) {
    const Json& plane = step.at("planes").at(i);
    std::array<double, 4> numbers{};
    const bool four = plane.isArray() && plane.size() == numbers.size();
    for (std::size_t n = 0; four && n < numbers.size(); ++n)
      numbers[n] = plane.at(n).isNumber() ? plane.at(n).number() : std::nan("");
    const glm::dvec3 normal(numbers[0], numbers[1], numbers[2]);
    const double length = glm::length(normal);
    if (!four || !(length > 1e-9 && length < kFarthest) || !(std::abs(numbers[3]) <= kFarthest))
      throw std::string("each of \"planes\" must be [nx, ny, nz, m]: a direction, and how far along it");
    planes.push_back({numbers[3] * normal / length, normal / length});
  }
  return planes;
}

sync::Shares shares(const Json& step) {
  const std::string what = text(step, "what", document::kMaxName);
  const auto named = std::find(sync::kSharesNames.begin(), sync::kSharesNames.end(), what);
  if (named == sync::kSharesNames.end()) throw std::string("\"what\" must be nothing, sections or view");
  return static_cast<sync::Shares>(named - sync::kSharesNames.begin());
}

std::vector<PartId> parts(const Json& step, const assets::Scene* scene) {
  if (!step.contains("parts") || !step.at("parts").isArray()) throw std::string("needs \"parts\": [...]");
  std::vector<PartId> parts;
  for (std::size_t i = 0; i < step.at("parts").size(); ++i)
    parts.push_back(namedPart(step.at("parts").at(i), "parts", scene));
  return parts;
}

/// A step that changes how parts are drawn; false if the verb is another one.
bool parseStyle(const Json& entry, const std::string& verb, const assets::Scene* scene, ScriptStep& step) {
  using Verb = ScriptStep::Verb;
  if (verb == "explode") {
    step.verb = Verb::explode;
    step.style.explode = number(entry, "factor", 1.0);
    if (step.style.explode < 0.0) throw std::string("\"factor\" must be 0 to 1");
    if (entry.contains("parts")) step.style.apart = parts(entry, scene);
    if (step.style.apart.size() > document::kMaxApart) throw std::string("\"parts\" has too many parts");
  } else if (verb == "colour") {
    step.verb = Verb::colour;
    const std::string what = text(entry, "what", document::kMaxName);
    const std::optional<document::PartColouring> colouring = document::colouringNamed(what);
    if (!colouring) throw std::string("\"what\" must be as made, body, material or owner");
    step.style.colouring = *colouring;
  } else if (verb == "ghosts") {
    step.verb = Verb::ghosts;
    if (!entry.contains("on") || !entry.at("on").isBoolean())
      throw std::string("needs \"on\": true or false");
    step.style.ghosts = entry.at("on").boolean();
  } else {
    return false;
  }
  return true;
}

/// A step that the others see; false if the verb is another one.
bool parseShowing(const Json& entry, const std::string& verb, const assets::Scene* scene, ScriptStep& step) {
  using Verb = ScriptStep::Verb;
  if (verb == "section") {
    step.verb = Verb::section;
    step.planes = planes(entry);
  } else if (verb == "share" || verb == "follow") {
    step.verb = verb == "share" ? Verb::share : Verb::follow;
    step.shares = shares(entry);
  } else if (verb == "hide") {
    step.verb = Verb::hide;
    step.parts = parts(entry, scene);
  } else if (verb == "select" || verb == "point") {
    step.verb = verb == "select" ? Verb::select : Verb::point;
    if (verb == "select" || entry.contains("part")) step.part = part(entry, scene);
  } else if (verb == "inspect") {
    step.verb = Verb::inspect;
    if (entry.contains("parts")) step.parts = twoParts(entry, scene);
    if (entry.contains("at")) step.places = placesAt(entry, sync::kMaxMarks);
  } else if (verb == "look") {
    step.verb = Verb::look;
    step.from = vector(entry, "from");
    step.vector = vector(entry, "to");
    if (glm::length(step.from - step.vector) < 1e-6) throw std::string("\"from\" and \"to\" are one place");
  } else if (verb == "say") {
    step.verb = Verb::say;
    step.text = text(entry, "text", sync::kMaxSayLength);
  } else {
    return false;
  }
  return true;
}

ScriptStep parseStep(const Json& entry, const assets::Scene* scene) {
  using Verb = ScriptStep::Verb;
  if (!entry.isObject()) throw std::string("must be an object");
  refuseUnknown(entry);
  ScriptStep step;
  step.at = duration(entry, "t");
  if (!entry.contains("do") || !entry.at("do").isText()) throw std::string("needs \"do\": \"VERB\"");
  const std::string verb = entry.at("do").text();
  if (verb == "grasp") {
    step.verb = Verb::grasp;
    step.part = part(entry, scene);
    step.over = entry.contains("over_s") ? duration(entry, "over_s") : -1.0;
  } else if (verb == "release") {
    step.verb = Verb::release;
  } else if (verb == "move" || verb == "move_relative") {
    step.verb = verb == "move" ? Verb::move : Verb::moveRelative;
    step.vector = vector(entry, verb == "move" ? "to" : "by");
    step.over = duration(entry, "over_s");
  } else if (verb == "turn") {
    step.verb = Verb::turn;
    step.vector = axis(entry);
    step.amount = number(entry, "angle", kMaxAngle);
    step.over = duration(entry, "over_s");
  } else if (verb == "sine") {
    step.verb = Verb::sine;
    step.vector = axis(entry);
    step.amount = number(entry, "amplitude");
    step.hz = number(entry, "hz", kMaxHz);
    step.over = duration(entry, "for_s");
  } else if (verb == "hold") {
    step.verb = Verb::hold;
  } else if (verb == "press") {
    step.verb = Verb::press;
    step.part = part(entry, scene);
    step.amount = number(entry, "depth");
    step.over = entry.contains("over_s") ? duration(entry, "over_s") : -1.0;
  } else if (verb == "set") {
    step.verb = Verb::set;
    step.part = controlPart(entry, scene);
    step.amount = number(entry, "value");
  } else if (verb == "let_go") {
    step.verb = Verb::letGo;
  } else if (!parseWriting(entry, verb, scene, step) && !parseStyle(entry, verb, scene, step) &&
             !parseShowing(entry, verb, scene, step)) {
    throw "does not know \"" + verb +
        "\"; verbs: grasp release move move_relative turn sine hold press set let_go note reply status view "
        "measure find_clashes judge undo redo section share follow hide explode colour ghosts select "
        "inspect look point say";
  }
  return step;
}

/// Closest point of a triangle (Ericson 2005, section 5.1.5).
glm::dvec3 closestOnTriangle(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b,
                             const glm::dvec3& c) {
  const glm::dvec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
  if (d1 <= 0.0 && d2 <= 0.0) return a;
  const glm::dvec3 bp = p - b;
  const double d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
  if (d3 >= 0.0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return a + ab * (d1 / (d1 - d3));
  const glm::dvec3 cp = p - c;
  const double d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
  if (d6 >= 0.0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return a + ac * (d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0)
    return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
  const double scale = 1.0 / (va + vb + vc);
  return a + ab * (vb * scale) + ac * (vc * scale);
}

/// Minimum-jerk progress and its first two derivatives at s in [0, 1].
struct Progress {
  double value, rate, acceleration;
};
Progress progressAt(double s) {
  if (s <= 0.0) return {0.0, 0.0, 0.0};
  if (s >= 1.0) return {1.0, 0.0, 0.0};
  return {haptics::minimumJerk(s), 30.0 * s * s * (1.0 - s) * (1.0 - s),
          60.0 * s * (1.0 - s) * (1.0 - 2.0 * s)};
}

}  // namespace

namespace {

Result<Json> parseSteps(const std::string& text, const std::string& source) {
  Result<Json> document = parseJson(text, source);
  if (!document) return document;
  Json steps = document->isObject() && document->contains("script") ? (*document)["script"] : *document;
  if (!steps.isArray()) return Error{source + ": a script is a list of steps"};
  return steps;
}

Result<HandScript> parseScript(const std::string& text, const std::string& source,
                               const assets::Scene* scene) {
  const Result<Json> parsed = parseSteps(text, source);
  if (!parsed) return parsed.error();
  const Json& steps = *parsed;
  HandScript script;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    try {
      script.steps.push_back(parseStep(steps.at(i), scene));
    } catch (const std::string& reason) {
      return Error{source + ": step " + std::to_string(i + 1) + ": " + reason};
    }
  }
  std::stable_sort(script.steps.begin(), script.steps.end(),
                   [](const ScriptStep& a, const ScriptStep& b) { return a.at < b.at; });
  return script;
}

}  // namespace

Status checkHandScript(const std::string& path) {
  const Result<std::string> text = readTextFile(path);
  if (!text) return text.error();
  const Result<HandScript> script = parseScript(*text, path, nullptr);
  return script ? Status{} : Status{script.error()};
}

Result<HandScript> parseHandScript(const std::string& text, const std::string& source,
                                   const assets::Scene& scene) {
  return parseScript(text, source, &scene);
}

Result<HandScript> loadHandScript(const std::string& path, const assets::Scene& scene) {
  const Result<std::string> text = readTextFile(path);
  if (!text) return text.error();
  return parseHandScript(*text, path, scene);
}

namespace {

/// Of planes, which may have no end, only their own point counts.
SurfacePoint nearestOfShapes(const assets::Part& part, const Pose& worldFromPart, const glm::dvec3& from) {
  const glm::dvec3 p = transformPoint(inverse(worldFromPart), from);
  SurfacePoint nearest{{0.0, 0.0, 0.0}, {0.0, 1.0, 0.0}};
  double least = 1e300;
  for (const assets::ImplicitShape& shape : part.shapes) {
    if (shape.kind == assets::ImplicitShape::Kind::plane) continue;
    const haptics::SurfaceDistance d = haptics::Primitive(shape).at(p);
    if (d.distance >= least) continue;
    least = d.distance;
    nearest = {p - d.distance * d.gradient, d.gradient};
  }
  return {transformPoint(worldFromPart, nearest.point), transformVector(worldFromPart, nearest.normal)};
}

}  // namespace

SurfacePoint nearestSurfacePoint(const assets::Scene& scene, PartId partId, const Pose& worldFromPart,
                                 const glm::dvec3& from) {
  const assets::Part& part = scene.parts[partId];
  if (part.mesh == assets::kNone) return nearestOfShapes(part, worldFromPart, from);
  const assets::Mesh& mesh = scene.meshes[part.mesh];
  const glm::dvec3 p = transformPoint(inverse(worldFromPart), from);
  double best = 1e300;
  SurfacePoint result;
  for (const auto& triangle : mesh.triangles) {
    const glm::dvec3 &a = mesh.positions[triangle[0]], &b = mesh.positions[triangle[1]],
                     &c = mesh.positions[triangle[2]];
    const glm::dvec3 q = closestOnTriangle(p, a, b, c);
    const double distance = glm::dot(p - q, p - q);
    if (distance >= best) continue;
    best = distance;
    result = {q, glm::cross(b - a, c - a)};
  }
  const double length = glm::length(result.normal);
  result.normal = length > 0.0 ? result.normal / length : glm::dvec3(0.0, 1.0, 0.0);
  // From outside, the closest feature may be an edge; the direction to the hand is then the better normal.
  const double distance = std::sqrt(best);
  if (distance > 1e-9 && glm::dot(p - result.point, result.normal) > 0.0)
    result.normal = (p - result.point) / distance;
  return {transformPoint(worldFromPart, result.point), transformVector(worldFromPart, result.normal)};
}

ScriptedPerson::ScriptedPerson(const assets::Scene& scene, HandScript script, const Pose& worldFromStart)
    : scene_(scene), script_(std::move(script)), from_(worldFromStart), to_(worldFromStart) {}

void ScriptedPerson::moveTo(const Pose& goal, double start, double over) {
  from_ = evaluate(start).target.worldFromTarget;
  to_ = goal;
  motion_ = Motion::straight;
  motionStart_ = start;
  motionLength_ = over;
}

void ScriptedPerson::begin(const ScriptStep& step, const Pose& worldFromHand, const Pose& worldFromPart) {
  const Pose present = evaluate(step.at).target.worldFromTarget;
  Pose goal = present;
  switch (step.verb) {
    case ScriptStep::Verb::grasp:
    case ScriptStep::Verb::press: {
      const SurfacePoint surface =
          nearestSurfacePoint(scene_, step.part, worldFromPart, worldFromHand.position);
      const bool press = step.verb == ScriptStep::Verb::press;
      goal.position = surface.point + surface.normal * (script_.toolRadius - (press ? step.amount : 0.0));
      const double path = glm::length(goal.position - present.position);
      const double over = step.over >= 0.0 ? step.over : std::max(kApproachShortest, path / kApproachSpeed);
      moveTo(goal, step.at, over);
      if (!press) {
        wish_ = step.part;
        buttonDownAt_ = step.at + over;
      }
      break;
    }
    case ScriptStep::Verb::release:
      button_ = false;
      buttonDownAt_ = -1.0;
      wish_ = kNoPart;
      break;
    case ScriptStep::Verb::move:
      goal.position = step.vector;
      moveTo(goal, step.at, step.over);
      break;
    case ScriptStep::Verb::moveRelative:
      goal.position += step.vector;
      moveTo(goal, step.at, step.over);
      break;
    case ScriptStep::Verb::turn:
      moveTo(present, step.at, step.over);
      to_.orientation = glm::normalize(glm::angleAxis(step.amount, step.vector) * present.orientation);
      axis_ = step.vector;
      amount_ = step.amount;
      motion_ = Motion::turn;
      break;
    case ScriptStep::Verb::sine:
      moveTo(present, step.at, step.over);
      axis_ = step.vector;
      amount_ = step.amount;
      hz_ = step.hz;
      motion_ = Motion::sine;
      break;
    case ScriptStep::Verb::hold:
      goal.position = worldFromHand.position;
      moveTo(goal, step.at, 0.0);
      break;
    case ScriptStep::Verb::set:
      control_ = {step.part, step.amount, control_.count + 1};
      break;
    case ScriptStep::Verb::letGo:
      holdsStylus_ = false;
      break;
    default:
      ASSERT(step.writes());
      ++written_;
      break;
  }
}

ScriptedPerson::Intent ScriptedPerson::evaluate(double t) {
  if (buttonDownAt_ >= 0.0 && t >= buttonDownAt_) {
    button_ = true;
    buttonDownAt_ = -1.0;
  }
  Intent intent;
  intent.graspButton = button_;
  intent.wish = wish_;
  intent.control = control_;
  intent.written = written_;
  haptics::HandTarget& target = intent.target;
  target.holdsStylus = holdsStylus_;
  const double since = t - motionStart_;
  const bool over = since >= motionLength_;
  const double length = std::max(motionLength_, 1e-9);
  const Progress p = progressAt(over ? 1.0 : since / length);
  target.worldFromTarget = to_;
  switch (motion_) {
    case Motion::still:
      break;
    case Motion::straight: {
      const glm::dvec3 path = to_.position - from_.position;
      target.worldFromTarget.position = from_.position + path * p.value;
      target.velocity = path * (p.rate / length);
      target.acceleration = path * (p.acceleration / (length * length));
      break;
    }
    case Motion::turn:
      target.worldFromTarget.orientation =
          glm::normalize(glm::angleAxis(amount_ * p.value, axis_) * from_.orientation);
      break;
    case Motion::sine: {
      if (over) break;
      const double omega = glm::two_pi<double>() * hz_;
      target.worldFromTarget.position += axis_ * (amount_ * std::sin(omega * since));
      target.velocity = axis_ * (amount_ * omega * std::cos(omega * since));
      target.acceleration = axis_ * (-amount_ * omega * omega * std::sin(omega * since));
      break;
    }
  }
  return intent;
}

}  // namespace tandem::client
