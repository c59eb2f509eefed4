#include "client/commands/check_measure.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <optional>
#include <vector>

#include "assets/base/json.h"
#include "client/commands/check_clashes.h"
#include "client/commands/command.h"
#include "client/review/clash_check.h"
#include "client/review/measure.h"
#include "haptics/scene/contact_scene.h"

namespace tandem::client {

namespace {

constexpr double kLargest = 1e6;  // m, of a coordinate

double degrees(double angle) { return angle * 180.0 / std::numbers::pi; }

/// "X,Y,Z"; nothing if it is anything else.
std::optional<glm::dvec3> placeOf(const std::string& text) {
  glm::dvec3 place(0.0);
  const char* at = text.c_str();
  for (int axis = 0; axis < 3; ++axis) {
    char* end = nullptr;
    place[axis] = std::strtod(at, &end);
    if (end == at || *end != (axis < 2 ? ',' : '\0') || !(std::abs(place[axis]) <= kLargest))
      return std::nullopt;
    at = end + 1;
  }
  return place;
}

Json toJson(const assets::Scene& scene, const MeasuredPlace& place) {
  Json json = {{"part", scene.parts[place.part].name},
               {"point_m", pointJson(place.point)},
               {"normal", pointJson(place.normal)},
               {"edge", nullptr},
               {"cylinder", nullptr}};
  if (place.edge)
    json["edge"] = {{"length_m", place.edge->length},
                    {"segments", place.edge->segments},
                    {"start_m", pointJson(place.edge->start)},
                    {"end_m", pointJson(place.edge->end)}};
  if (place.cylinder)
    json["cylinder"] = {{"diameter_m", 2.0 * place.cylinder->radius},
                        {"hollow", place.cylinder->hollow},
                        {"length_m", 2.0 * place.cylinder->halfLength},
                        {"middle_m", pointJson(place.cylinder->middle)},
                        {"axis", pointJson(place.cylinder->axis)}};
  return json;
}

Json toJson(const MeasuredPair& pair) {
  return {{"distance_m", pair.distance},
          {"angle_deg", degrees(pair.angle)},
          {"across_m", pair.across ? Json(*pair.across) : Json(nullptr)}};
}

void printMeasured(const assets::Scene& scene, const MeasuredPlace& place) {
  const glm::dvec3 &p = place.point, &n = place.normal;
  std::printf("%s at %.6g %.6g %.6g m\n", scene.parts[place.part].name.c_str(), p.x, p.y, p.z);
  std::printf("  faces %.6f %.6f %.6f\n", n.x, n.y, n.z);
  if (place.cylinder) {
    const glm::dvec3 &m = place.cylinder->middle, &a = place.cylinder->axis;
    std::printf(
        "  %s of diameter %.4f mm, %.4f mm long; its axis through %.6g %.6g %.6g m along %.6f %.6f %.6f\n",
        place.cylinder->hollow ? "bore" : "cylinder", 2e3 * place.cylinder->radius,
        2e3 * place.cylinder->halfLength, m.x, m.y, m.z, a.x, a.y, a.z);
  }
  if (place.edge)
    std::printf("  nearest edge: %.4f mm%s\n", 1e3 * place.edge->length,
                place.edge->start == place.edge->end ? ", closed" : "");
}

void printMeasured(const MeasuredPlace& a, const MeasuredPlace& b, const MeasuredPair& pair) {
  std::printf("from one to the other %.4f mm\n", 1e3 * pair.distance);
  const char* between = a.cylinder && b.cylinder   ? "axes"
                        : a.cylinder || b.cylinder ? "axis and face"
                                                   : "faces";
  std::printf("  %s at %.5f degrees", between, degrees(pair.angle));
  if (pair.across) std::printf(", %.4f mm apart", 1e3 * *pair.across);
  std::printf("\n");
}

/// Where the places are on different parts, also how near these are to each other.
void measureBetween(const haptics::ContactScene& contact, const MeasuredPlace& a, const MeasuredPlace& b,
                    Json* json) {
  const assets::Scene& scene = contact.scene();
  const MeasuredPair pair = measurePair(a, b);
  std::optional<Clash> parts;
  if (a.part != b.part)
    parts = measurePair(PartClosings(contact), a.part, scene.parts[a.part].worldFromPart, b.part,
                        scene.parts[b.part].worldFromPart);
  if (json == nullptr) {
    printMeasured(a, b, pair);
    if (parts) printClash(scene, *parts);
    return;
  }
  (*json)["between"] = toJson(pair);
  (*json)["parts"] = parts ? clashJson(scene, *parts) : Json(nullptr);
}

}  // namespace

int runMeasure(const assets::Scene& scene, const MeasureArguments& arguments) {
  if (arguments.places.size() > 2) return badInput(Error{"--measure: give one place or two"});
  const haptics::ContactScene contact(scene);
  std::vector<MeasuredPlace> places;
  Json list = Json::array();
  for (const std::string& text : arguments.places) {
    const std::optional<glm::dvec3> point = placeOf(text);
    if (!point) return badInput(Error{"--measure " + text + ": not a place, three numbers X,Y,Z in m"});
    const std::optional<MeasuredPlace> place = measurePlace(contact, *point);
    if (!place) return badInput(Error{"--measure: the scene has nothing that could be touched"});
    places.push_back(*place);
    list.push(toJson(scene, *place));
  }
  Json json;
  if (arguments.json)
    json["places"] = std::move(list);
  else
    for (const MeasuredPlace& place : places) printMeasured(scene, place);
  if (places.size() == 2) measureBetween(contact, places[0], places[1], arguments.json ? &json : nullptr);
  if (arguments.json) std::printf("%s\n", json.dump(2).c_str());
  return kExitDone;
}

}  // namespace tandem::client
