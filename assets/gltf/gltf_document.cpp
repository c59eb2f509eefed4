#include "assets/gltf/gltf_document.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

namespace tandem::assets {
namespace {

using nlohmann::json;

constexpr std::int64_t kMaxWhole = std::numeric_limits<std::int32_t>::max();
// Far beyond any real file; keeps everything that recurses over JSON (copying, tinygltf) off the stack's end.
constexpr int kMaxJsonDepth = 96;
constexpr std::size_t kMaxTextBytes = 200;

enum class Kind { whole, wholes, numbers3, numbers4, numbers16, text, flag, object, objects, wholeMap };

/// One property that the loader or tinygltf relies on: where, of what type, and which section it indexes.
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

// What tinygltf gets to see. Images, textures, skins, animations and cameras say nothing about shape, so that
// a broken one never keeps a scene from loading.
constexpr const char* kModelSections[] = {"bufferViews", "accessors", "meshes",
                                          "nodes",       "scenes",    "materials"};

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

void checkSections(json& document) {
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

void checkDepth(std::string_view text) {
  int depth = 0;
  bool inString = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (inString) {
      if (c == '\\') ++i;
      if (c == '"') inString = false;
    } else if (c == '"') {
      inString = true;
    } else if (c == '{' || c == '[') {
      if (++depth > kMaxJsonDepth)
        throw GltfError("json", "is nested deeper than " + std::to_string(kMaxJsonDepth) + " levels");
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
}

json parseJson(std::string_view text) {
  checkDepth(text);
  try {
    return json::parse(text.begin(), text.end());
  } catch (const json::exception& e) {
    std::string reason = e.what();
    // "[json.exception.parse_error.101] parse error at line 1 ..." names nlohmann's classes, which help
    // nobody.
    if (const auto bracket = reason.find("] "); bracket != std::string::npos) reason.erase(0, bracket + 2);
    std::replace_if(
        reason.begin(), reason.end(), [](unsigned char c) { return c < 32; }, ' ');
    throw GltfError("json", reason);
  }
}

std::uint32_t readU32(ByteView bytes, std::size_t at) {
  std::uint32_t value;  // glTF and every machine this runs on are little-endian
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

struct Container {
  std::string_view json;
  ByteView binary;
  bool hasBinary = false;
};

Container splitGlb(ByteView file) {
  if (file.size() < 20) throw GltfError("header", "the file is truncated");
  if (readU32(file, 4) != 2)
    throw GltfError("header", "version " + std::to_string(readU32(file, 4)) + " is not glTF 2.0");
  const std::size_t length = readU32(file, 8);
  if (length > file.size())
    throw GltfError("header", "the file is truncated: " + std::to_string(file.size()) + " of " +
                                  std::to_string(length) + " bytes");
  Container container;
  for (std::size_t at = 12; at + 8 <= length;) {
    const std::size_t size = readU32(file, at);
    const std::uint32_t type = readU32(file, at + 4);
    if (size > length - at - 8)
      throw GltfError("chunk at byte " + std::to_string(at), "reaches past the file's end");
    const ByteView chunk = file.subspan(at + 8, size);
    if (at == 12 && type != 0x4E4F534A) throw GltfError("header", "the first chunk is not JSON");
    if (at == 12) container.json = {reinterpret_cast<const char*>(chunk.data()), chunk.size()};
    if (at != 12 && type == 0x004E4942 && !container.hasBinary) {
      container.binary = chunk;
      container.hasBinary = true;
    }
    at += 8 + size + (4 - size % 4) % 4;
  }
  return container;
}

Container splitContainer(ByteView file) {
  if (file.size() >= 4 && std::memcmp(file.data(), "glTF", 4) == 0) return splitGlb(file);
  if (file.empty()) throw GltfError("file", "is empty");
  Container container;
  container.json = {reinterpret_cast<const char*>(file.data()), file.size()};
  return container;
}

std::string percentDecoded(const std::string& uri) {
  const auto hex = [](char c) {
    return c >= '0' && c <= '9' ? c - '0' : (c | 32) >= 'a' && (c | 32) <= 'f' ? (c | 32) - 'a' + 10 : -1;
  };
  std::string out;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] == '%' && i + 2 < uri.size() && hex(uri[i + 1]) >= 0 && hex(uri[i + 2]) >= 0) {
      out += static_cast<char>(hex(uri[i + 1]) * 16 + hex(uri[i + 2]));
      i += 2;
    } else {
      out += uri[i];
    }
  }
  return out;
}

/// Where a relative URI lies, if that is inside the file's own directory.
std::filesystem::path externalPath(const std::string& uri, const std::string& directory,
                                   const std::string& place) {
  const std::filesystem::path relative(percentDecoded(uri));
  const bool hasScheme = uri.find(':') != std::string::npos && uri.find(':') < uri.find('/');
  const bool escapes =
      relative.is_absolute() || std::find(relative.begin(), relative.end(), "..") != relative.end() ||
      relative.string().find('\0') != std::string::npos || relative.string().find('\\') != std::string::npos;
  if (hasScheme || escapes || relative.empty())
    throw GltfError(place, "'" + uri.substr(0, 80) + "' does not lie in the directory of the file");
  return std::filesystem::path(directory) / relative;
}

bool isMeshoptFallback(const json& buffer) {
  const json* extension = findExtension(buffer, "EXT_meshopt_compression");
  return extension != nullptr && extension->value("fallback", json(false)) == json(true);
}

/// Fills buffers[i] from the GLB's chunk, a data URI or a file beside this one.
void openBuffer(GltfDocument& document, const Container& container, std::size_t i,
                const std::string* directory) {
  const json& buffer = document.json["buffers"][i];
  const std::string place = placeName("buffers", i);
  const std::size_t length = buffer["byteLength"].get<std::size_t>();
  const auto uriAt = buffer.find("uri");
  if (uriAt == buffer.end()) {
    if (i == 0 && container.hasBinary)
      document.buffers[i] = container.binary;
    else if (isMeshoptFallback(buffer))
      return;
    else
      throw GltfError(place, "has neither a uri nor a binary chunk");
  } else {
    const std::string uri = uriAt->get<std::string>();
    Bytes& owned = document.ownedBuffers[i];
    if (uri.compare(0, 5, "data:") == 0) {
      std::string mimeType;
      if (!tinygltf::IsDataURI(uri) || !tinygltf::DecodeDataURI(&owned, mimeType, uri, 0, false))
        throw GltfError(place + ".uri", "the data URI cannot be decoded");
    } else {
      if (directory == nullptr) throw GltfError(place + ".uri", "external files cannot be read from here");
      owned = readWholeFile(externalPath(uri, *directory, place + ".uri").string(), place + ".uri");
      document.externals.push_back(owned);
    }
    document.buffers[i] = owned;
  }
  if (document.buffers[i].size() < length)
    throw GltfError(place, "holds " + std::to_string(document.buffers[i].size()) + " of its " +
                               std::to_string(length) + " bytes");
  document.buffers[i] = document.buffers[i].first(length);
}

void stripObject(json& object) {
  object.erase("extensions");
  object.erase("extras");
}

/// The part of the document that tinygltf is given.
json modelJson(const json& document) {
  json out = {{"asset", {{"version", "2.0"}}}};
  for (const char* section : kModelSections)
    if (const auto it = document.find(section); it != document.end()) out[section] = *it;
  if (const auto it = document.find("scene"); it != document.end()) out["scene"] = *it;
  for (const char* section : kModelSections)
    if (const auto it = out.find(section); it != out.end())
      for (json& object : *it) stripObject(object);
  if (const auto meshes = out.find("meshes"); meshes != out.end())
    for (json& mesh : *meshes)
      for (json& primitive : mesh["primitives"]) {
        stripObject(primitive);
        primitive.erase("targets");
        // tinygltf refuses index accessors without a buffer view, which are legal where they are sparse or
        // where Draco holds the data; the decoder takes them from the JSON instead.
        primitive.erase("indices");
      }
  return out;
}

}  // namespace

std::string placeName(const char* section, std::size_t index, const char* key) {
  return std::string(section) + "[" + std::to_string(index) + "]" +
         (key != nullptr ? std::string(".") + key : "");
}

std::string cleanText(std::string text) {
  if (text.size() > kMaxTextBytes) {
    text.resize(kMaxTextBytes);
    // Not in the middle of a UTF-8 character.
    while (!text.empty() && (static_cast<unsigned char>(text.back()) & 0xc0u) == 0x80u) text.pop_back();
    if (!text.empty() && static_cast<unsigned char>(text.back()) >= 0xc0u) text.pop_back();
  }
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 32 || c == 127; }, '_');
  return text;
}

Bytes readWholeFile(const std::string& path, const std::string& place) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) throw GltfError(place, "'" + path + "' does not exist");
  if (!std::filesystem::is_regular_file(status))
    throw GltfError(place, "'" + path + "' is not a regular file");
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) throw GltfError(place, "'" + path + "' cannot be read: " + error.message());
  if (size > std::uintmax_t(kMaxWhole)) throw GltfError(place, "'" + path + "' is larger than 2 GiB");
  Bytes bytes(size);
  std::ifstream in(path, std::ios::binary);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (!in) throw GltfError(place, "'" + path + "' cannot be read");
  return bytes;
}

std::vector<std::string> extensionNames(const GltfDocument& document, const char* key) {
  std::vector<std::string> names;
  const auto it = document.json.find(key);
  if (it == document.json.end()) return names;
  if (!it->is_array()) throw GltfError(key, "must be an array");
  for (const json& name : *it) {
    if (!name.is_string()) throw GltfError(key, "must hold strings");
    names.push_back(name.get<std::string>());
  }
  return names;
}

const json* findExtension(const json& object, const char* name) {
  const auto extensions = object.find("extensions");
  if (extensions == object.end() || !extensions->is_object()) return nullptr;
  const auto it = extensions->find(name);
  return it != extensions->end() && it->is_object() ? &*it : nullptr;
}

void openGltf(Bytes file, const std::string* directory, GltfDocument& document) {
  document.file = std::move(file);
  const Container container = splitContainer(document.file);
  document.json = parseJson(container.json);
  if (!document.json.is_object()) throw GltfError("json", "is not an object");
  const auto asset = document.json.find("asset");
  if (asset == document.json.end() || !asset->is_object()) throw GltfError("asset", "is missing");
  const auto version = asset->find("version");
  if (version == asset->end() || !version->is_string() ||
      version->get<std::string>().compare(0, 2, "2.") != 0)
    throw GltfError("asset.version", "is not glTF 2.x");
  checkSections(document.json);
  const std::size_t count = sectionSize(document.json, "buffers");
  document.ownedBuffers.resize(count);
  document.buffers.resize(count);
  for (std::size_t i = 0; i < count; ++i) openBuffer(document, container, i, directory);
}

void parseModel(GltfDocument& document) {
  const std::string text = modelJson(document.json).dump();
  tinygltf::TinyGLTF reader;
  std::string error, warning;
  const bool good =
      reader.LoadASCIIFromString(&document.model, &error, &warning, text.c_str(),
                                 static_cast<unsigned int>(text.size()), "", tinygltf::NO_REQUIRE);
  if (good) return;
  std::replace(error.begin(), error.end(), '\n', ' ');
  throw GltfError("json", error.empty() ? "tinygltf refuses it" : error);
}

}  // namespace tandem::assets
