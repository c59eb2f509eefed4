#include "assets/gltf/gltf_rules.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "assets/gltf/gltf_error.h"

namespace tandem::assets {
namespace {

constexpr std::uint64_t kMaxWhole = std::numeric_limits<std::int32_t>::max();

enum class RuleKind { whole, wholes, numbers3, numbers4, numbers16, text, flag, object, objects, wholeMap };

/// One property that the loader relies on: where, of what type, and which section it indexes.
struct Rule {
  const char* section;
  const char* key;
  RuleKind kind;
  bool required = false;
  const char* refersTo = nullptr;
};

constexpr Rule kRules[] = {
    {"buffers", "byteLength", RuleKind::whole, true},
    {"buffers", "uri", RuleKind::text},
    {"bufferViews", "buffer", RuleKind::whole, true, "buffers"},
    {"bufferViews", "byteOffset", RuleKind::whole},
    {"bufferViews", "byteLength", RuleKind::whole, true},
    {"bufferViews", "byteStride", RuleKind::whole},
    {"accessors", "bufferView", RuleKind::whole, false, "bufferViews"},
    {"accessors", "byteOffset", RuleKind::whole},
    {"accessors", "componentType", RuleKind::whole, true},
    {"accessors", "count", RuleKind::whole, true},
    {"accessors", "type", RuleKind::text, true},
    {"accessors", "normalized", RuleKind::flag},
    {"accessors", "sparse", RuleKind::object},
    {"meshes", "name", RuleKind::text},
    {"meshes", "primitives", RuleKind::objects, true},
    {"nodes", "name", RuleKind::text},
    {"nodes", "mesh", RuleKind::whole, false, "meshes"},
    {"nodes", "children", RuleKind::wholes, false, "nodes"},
    {"nodes", "matrix", RuleKind::numbers16},
    {"nodes", "translation", RuleKind::numbers3},
    {"nodes", "rotation", RuleKind::numbers4},
    {"nodes", "scale", RuleKind::numbers3},
    {"scenes", "name", RuleKind::text},
    {"scenes", "nodes", RuleKind::wholes, false, "nodes"},
    {"materials", "name", RuleKind::text},
    {"materials", "pbrMetallicRoughness", RuleKind::object},
};

constexpr Rule kPrimitiveRules[] = {
    {"primitives", "attributes", RuleKind::wholeMap, true, "accessors"},
    {"primitives", "indices", RuleKind::whole, false, "accessors"},
    {"primitives", "material", RuleKind::whole, false, "materials"},
    {"primitives", "mode", RuleKind::whole},
};

constexpr Rule kSparseRules[] = {
    {"sparse", "count", RuleKind::whole, true},
    {"sparse", "indices", RuleKind::object, true},
    {"sparse", "values", RuleKind::object, true},
};

constexpr Rule kSparsePartRules[] = {
    {"sparse", "bufferView", RuleKind::whole, true, "bufferViews"},
    {"sparse", "byteOffset", RuleKind::whole},
    {"sparse", "componentType", RuleKind::whole},
};

std::size_t sectionSize(const Json& document, const char* section) { return document.member(section).size(); }

/// Checks a whole number in [0, 2^31) and that it is an index of `refersTo`. 3.0 is a legal way of writing 3.
void checkWhole(Json& value, const std::string& place, const char* refersTo, const Json& document) {
  if (value.isNumber() && !value.isInteger()) {
    const double number = value.number();
    if (number == std::floor(number) && std::abs(number) <= 1e15) value = static_cast<std::int64_t>(number);
  }
  if (!value.isInteger()) throw GltfError(place, "must be a whole number");
  if (!value.isNatural() && value.signedInteger() < 0) throw GltfError(place, value.dump() + " is negative");
  if (value.integer() > kMaxWhole) throw GltfError(place, value.dump() + " is too large");
  if (refersTo == nullptr) return;
  const std::size_t size = sectionSize(document, refersTo);
  if (value.integer() >= size)
    throw GltfError(
        place, "index " + value.dump() + " is out of range (" + std::to_string(size) + " " + refersTo + ")");
}

void checkNumbers(const Json& value, std::size_t count, const std::string& place) {
  const bool good = value.isArray() && value.size() == count &&
                    std::all_of(value.begin(), value.end(), [](const Json& v) { return v.isNumber(); });
  if (!good) throw GltfError(place, "must be an array of " + std::to_string(count) + " numbers");
}

void checkKind(Json& value, const Rule& rule, const std::string& place, const Json& document) {
  switch (rule.kind) {
    case RuleKind::whole:
      return checkWhole(value, place, rule.refersTo, document);
    case RuleKind::wholes:
      if (!value.isArray()) throw GltfError(place, "must be an array");
      for (std::size_t i = 0; Json & entry : value)
        checkWhole(entry, place + "[" + std::to_string(i++) + "]", rule.refersTo, document);
      return;
    case RuleKind::wholeMap:
      if (!value.isObject()) throw GltfError(place, "must be an object");
      for (auto& [key, entry] : value.members())
        checkWhole(entry, place + "." + key, rule.refersTo, document);
      return;
    case RuleKind::numbers3:
      return checkNumbers(value, 3, place);
    case RuleKind::numbers4:
      return checkNumbers(value, 4, place);
    case RuleKind::numbers16:
      return checkNumbers(value, 16, place);
    case RuleKind::text:
      if (!value.isText()) throw GltfError(place, "must be a string");
      return;
    case RuleKind::flag:
      if (!value.isBoolean()) throw GltfError(place, "must be true or false");
      return;
    case RuleKind::object:
      if (!value.isObject()) throw GltfError(place, "must be an object");
      return;
    case RuleKind::objects:
      if (!value.isArray()) throw GltfError(place, "must be an array");
      for (const Json& entry : value)
        if (!entry.isObject()) throw GltfError(place, "must hold objects");
      return;
  }
}

void checkRule(Json& object, const Rule& rule, const std::string& place, const Json& document) {
  const std::string where = place + "." + rule.key;
  if (Json* value = object.find(rule.key)) return checkKind(*value, rule, where, document);
  if (rule.required) throw GltfError(where, "is missing");
}

void checkPrimitives(Json& mesh, const std::string& place, const Json& document) {
  for (std::size_t i = 0; Json & primitive : mesh["primitives"]) {
    const std::string where = place + ".primitives[" + std::to_string(i++) + "]";
    for (const Rule& rule : kPrimitiveRules) checkRule(primitive, rule, where, document);
  }
}

void checkSparse(Json& accessor, const std::string& place, const Json& document) {
  Json* sparse = accessor.find("sparse");
  if (sparse == nullptr) return;
  const std::string where = place + ".sparse";
  for (const Rule& rule : kSparseRules) checkRule(*sparse, rule, where, document);
  for (const char* part : {"indices", "values"})
    for (const Rule& rule : kSparsePartRules) checkRule((*sparse)[part], rule, where + "." + part, document);
  if (!(*sparse)["indices"].contains("componentType"))
    throw GltfError(where + ".indices.componentType", "is missing");
}

}  // namespace

void checkRules(Json& document) {
  for (const char* section :
       {"buffers", "bufferViews", "accessors", "meshes", "nodes", "scenes", "materials"}) {
    const Json& list = document.member(section);
    if (list.isAbsent()) continue;
    if (!list.isArray()) throw GltfError(section, "must be an array");
    for (std::size_t i = 0; i < list.size(); ++i)
      if (!list.at(i).isObject()) throw GltfError(placeName(section, i), "must be an object");
  }
  const auto forEach = [&](const char* section, const auto& check) {
    if (Json* list = document.find(section))
      for (std::size_t i = 0; Json & object : *list) check(object, placeName(section, i++));
  };
  for (const Rule& rule : kRules)
    forEach(rule.section,
            [&](Json& object, const std::string& place) { checkRule(object, rule, place, document); });
  forEach("meshes", [&](Json& mesh, const std::string& place) { checkPrimitives(mesh, place, document); });
  forEach("accessors",
          [&](Json& accessor, const std::string& place) { checkSparse(accessor, place, document); });
  if (Json* scene = document.find("scene")) checkWhole(*scene, "scene", "scenes", document);
}

}  // namespace tandem::assets
