#include "assets/gltf/gltf_rules.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <nlohmann/json.hpp>

#include "assets/gltf/gltf_error.h"

namespace tandem::assets {
namespace {

using nlohmann::json;

constexpr std::int64_t kMaxWhole = std::numeric_limits<std::int32_t>::max();

enum class Kind { whole, wholes, numbers3, numbers4, numbers16, text, flag, object, objects, wholeMap };

/// One property that the loader relies on: where, of what type, and which section it indexes.
struct Rule {
  const char* section;
  const char* key;
  Kind kind;
  bool required = false;
  const char* refersTo = nullptr;
};

constexpr Rule kRules[] = {
    {"buffers", "byteLength", Kind::whole, true},
    {"buffers", "uri", Kind::text},
    {"bufferViews", "buffer", Kind::whole, true, "buffers"},
    {"bufferViews", "byteOffset", Kind::whole},
    {"bufferViews", "byteLength", Kind::whole, true},
    {"bufferViews", "byteStride", Kind::whole},
    {"accessors", "bufferView", Kind::whole, false, "bufferViews"},
    {"accessors", "byteOffset", Kind::whole},
    {"accessors", "componentType", Kind::whole, true},
    {"accessors", "count", Kind::whole, true},
    {"accessors", "type", Kind::text, true},
    {"accessors", "normalized", Kind::flag},
    {"accessors", "sparse", Kind::object},
    {"meshes", "name", Kind::text},
    {"meshes", "primitives", Kind::objects, true},
    {"nodes", "name", Kind::text},
    {"nodes", "mesh", Kind::whole, false, "meshes"},
    {"nodes", "children", Kind::wholes, false, "nodes"},
    {"nodes", "matrix", Kind::numbers16},
    {"nodes", "translation", Kind::numbers3},
    {"nodes", "rotation", Kind::numbers4},
    {"nodes", "scale", Kind::numbers3},
    {"scenes", "name", Kind::text},
    {"scenes", "nodes", Kind::wholes, false, "nodes"},
    {"materials", "name", Kind::text},
    {"materials", "pbrMetallicRoughness", Kind::object},
};

constexpr Rule kPrimitiveRules[] = {
    {"primitives", "attributes", Kind::wholeMap, true, "accessors"},
    {"primitives", "indices", Kind::whole, false, "accessors"},
    {"primitives", "material", Kind::whole, false, "materials"},
    {"primitives", "mode", Kind::whole},
};

constexpr Rule kSparseRules[] = {
    {"sparse", "count", Kind::whole, true},
    {"sparse", "indices", Kind::object, true},
    {"sparse", "values", Kind::object, true},
};

constexpr Rule kSparsePartRules[] = {
    {"sparse", "bufferView", Kind::whole, true, "bufferViews"},
    {"sparse", "byteOffset", Kind::whole},
    {"sparse", "componentType", Kind::whole},
};

std::size_t sectionSize(const json& document, const char* section) {
  const auto it = document.find(section);
  return it == document.end() ? 0 : it->size();
}

/// Checks a whole number in [0, 2^31) and that it is an index of `refersTo`. 3.0 is a legal way of writing 3.
void checkWhole(json& value, const std::string& place, const char* refersTo, const json& document) {
  if (value.is_number_float()) {
    const double number = value.get<double>();
    if (number == std::floor(number) && std::abs(number) <= 1e15) value = static_cast<std::int64_t>(number);
  }
  if (!value.is_number_integer()) throw GltfError(place, "must be a whole number");
  const bool tooLarge = value.is_number_unsigned() ? value.get<std::uint64_t>() > std::uint64_t(kMaxWhole)
                                                   : value.get<std::int64_t>() > kMaxWhole;
  if (tooLarge) throw GltfError(place, value.dump() + " is too large");
  if (value.get<std::int64_t>() < 0) throw GltfError(place, value.dump() + " is negative");
  if (refersTo == nullptr) return;
  const std::size_t size = sectionSize(document, refersTo);
  if (value.get<std::size_t>() >= size)
    throw GltfError(
        place, "index " + value.dump() + " is out of range (" + std::to_string(size) + " " + refersTo + ")");
}

void checkNumbers(const json& value, std::size_t count, const std::string& place) {
  const bool good = value.is_array() && value.size() == count &&
                    std::all_of(value.begin(), value.end(), [](const json& v) { return v.is_number(); });
  if (!good) throw GltfError(place, "must be an array of " + std::to_string(count) + " numbers");
}

void checkKind(json& value, const Rule& rule, const std::string& place, const json& document) {
  switch (rule.kind) {
    case Kind::whole:
      return checkWhole(value, place, rule.refersTo, document);
    case Kind::wholes:
      if (!value.is_array()) throw GltfError(place, "must be an array");
      for (std::size_t i = 0; i < value.size(); ++i)
        checkWhole(value[i], place + "[" + std::to_string(i) + "]", rule.refersTo, document);
      return;
    case Kind::wholeMap:
      if (!value.is_object()) throw GltfError(place, "must be an object");
      for (auto& [key, entry] : value.items()) checkWhole(entry, place + "." + key, rule.refersTo, document);
      return;
    case Kind::numbers3:
      return checkNumbers(value, 3, place);
    case Kind::numbers4:
      return checkNumbers(value, 4, place);
    case Kind::numbers16:
      return checkNumbers(value, 16, place);
    case Kind::text:
      if (!value.is_string()) throw GltfError(place, "must be a string");
      return;
    case Kind::flag:
      if (!value.is_boolean()) throw GltfError(place, "must be true or false");
      return;
    case Kind::object:
      if (!value.is_object()) throw GltfError(place, "must be an object");
      return;
    case Kind::objects:
      if (!value.is_array()) throw GltfError(place, "must be an array");
      for (const json& entry : value)
        if (!entry.is_object()) throw GltfError(place, "must hold objects");
      return;
  }
}

void checkRule(json& object, const Rule& rule, const std::string& place, const json& document) {
  const auto it = object.find(rule.key);
  const std::string where = place + "." + rule.key;
  if (it != object.end()) return checkKind(*it, rule, where, document);
  if (rule.required) throw GltfError(where, "is missing");
}

void checkPrimitives(json& mesh, const std::string& place, const json& document) {
  json& primitives = mesh["primitives"];
  for (std::size_t i = 0; i < primitives.size(); ++i)
    for (const Rule& rule : kPrimitiveRules)
      checkRule(primitives[i], rule, place + ".primitives[" + std::to_string(i) + "]", document);
}

void checkSparse(json& accessor, const std::string& place, const json& document) {
  const auto sparse = accessor.find("sparse");
  if (sparse == accessor.end()) return;
  const std::string where = place + ".sparse";
  for (const Rule& rule : kSparseRules) checkRule(*sparse, rule, where, document);
  for (const char* part : {"indices", "values"})
    for (const Rule& rule : kSparsePartRules) checkRule((*sparse)[part], rule, where + "." + part, document);
  if (!(*sparse)["indices"].contains("componentType"))
    throw GltfError(where + ".indices.componentType", "is missing");
}

}  // namespace

void checkRules(JsonTree& tree) {
  json& document = tree.mutableRoot();
  for (const char* section :
       {"buffers", "bufferViews", "accessors", "meshes", "nodes", "scenes", "materials"}) {
    const auto it = document.find(section);
    if (it == document.end()) continue;
    if (!it->is_array()) throw GltfError(section, "must be an array");
    for (std::size_t i = 0; i < it->size(); ++i)
      if (!(*it)[i].is_object()) throw GltfError(placeName(section, i), "must be an object");
  }
  for (const Rule& rule : kRules) {
    const auto it = document.find(rule.section);
    if (it == document.end()) continue;
    for (std::size_t i = 0; i < it->size(); ++i)
      checkRule((*it)[i], rule, placeName(rule.section, i), document);
  }
  for (std::size_t i = 0; i < sectionSize(document, "meshes"); ++i)
    checkPrimitives(document["meshes"][i], placeName("meshes", i), document);
  for (std::size_t i = 0; i < sectionSize(document, "accessors"); ++i)
    checkSparse(document["accessors"][i], placeName("accessors", i), document);
  if (const auto scene = document.find("scene"); scene != document.end())
    checkWhole(*scene, "scene", "scenes", document);
}

}  // namespace tandem::assets
