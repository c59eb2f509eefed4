#include "assets/gltf/gltf_surface.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <numbers>
#include <optional>
#include <set>

#include "assets/gltf/embedded_data.h"
#include "assets/gltf/gltf_decode.h"
#include "assets/scene/describe.h"
#include "assets/scene/value_ranges.h"

namespace tandem::assets {
namespace {

constexpr double kLargestAngle = std::numbers::pi;

/// A described property: "stickSlip.force" is "force" of the object "stickSlip"; a plain one belongs to no
/// group.
struct PropertyName {
  explicit PropertyName(const std::string& property) {
    const std::size_t dot = property.find('.');
    if (dot != std::string::npos) group = property.substr(0, dot);
    key = dot == std::string::npos ? property : property.substr(dot + 1);
  }

  std::string group, key;
};

using Keys = std::map<std::string, std::set<std::string>>;  // by group

/// Collects the keys that each object of extras.haptic may have.
struct KeyCollector {
  Keys keys;

  void number(const char* property, double, const Range&, bool = true) { add(property); }
  void choice(const char* property, const auto&, const auto&) { add(property); }
  void whole(const char* property, const auto&) { add(property); }
  void record(const char*, const auto& value) { describe(*this, value); }

  void add(const char* property) {
    const PropertyName name(property);
    keys[name.group].insert(name.key);
    if (!name.group.empty()) keys[""].insert(name.group);
  }
};

const Keys& knownKeys() {
  static const Keys known = [] {
    KeyCollector collector;
    const Surface any;
    describe(collector, any);
    Keys keys = std::move(collector.keys);
    // The numbers of a law may stand in extras.haptic itself, and some effects have a short form.
    for (const std::string& key : keys["law"])
      if (key != "type") keys[""].insert(key);
    keys[""].insert({"textureAmplitude", "textureWavelength", "popThroughForce"});
    // The material's own numbers, and what a node carries, are read elsewhere.
    keys[""].insert(
        {"stiffness", "damping", "staticFriction", "dynamicFriction", "field", "control", "tolerance"});
    return keys;
  }();
  return known;
}

void noteUnknown(const JsonObject& object, const std::set<std::string>& known, UnknownProperties& unknown) {
  for (const auto& [key, value] : object.raw().members())
    if (known.count(key) == 0) unknown.add(key);
}

SurfaceTexture::Pattern patternOf(const JsonObject& texture) {
  const std::string name = texture.text("function", "");
  for (std::size_t i = 0; i < std::size(kPatternNames); ++i)
    if (!name.empty() && name == kPatternNames[i]) return static_cast<SurfaceTexture::Pattern>(i);
  texture.fail("function", '\'' + name.substr(0, 40) + "' is not sine, grid, bumps or noise");
}

/// Reads the described numbers of one object.
struct NumberReader {
  const JsonObject& object;
  std::string group;

  void number(const char* property, double& value, const Range&, bool = true) {
    const PropertyName name(property);
    if (name.group == group) value = object.sizeOr(name.key.c_str(), value);
  }
  void choice(const char*, auto&, const auto&) {}
  void whole(const char*, auto&) {}
};

void readTexture(const JsonObject& haptic, const Json& document, SurfaceTexture& out,
                 UnknownProperties& unknown) {
  const auto texture = haptic.object("texture");
  if (!texture) return;
  const Json& textures = document.member("textures");
  const std::size_t count = textures.isArray() ? textures.size() : 0;
  if (const auto image = texture->index("image", count, "textures")) {
    out.pattern = SurfaceTexture::Pattern::image;
    out.image = static_cast<std::uint32_t>(*image);
  } else {
    out.pattern = patternOf(*texture);
  }
  NumberReader reader{*texture, "texture"};
  describe(reader, out);
  if (out.pattern != SurfaceTexture::Pattern::image && !(out.wavelength > 0.0))
    texture->fail("wavelength", "must be positive");
  noteUnknown(*texture, knownKeys().at("texture"), unknown);
}

/// The short form: an amplitude in N over a wave of some wavelength.
void readFlatTexture(const JsonObject& haptic, SurfaceTexture& out) {
  const double force = haptic.sizeOr("textureAmplitude", 0.0);
  const double wavelength = haptic.sizeOr("textureWavelength", 0.0);
  if (force == 0.0 || out.pattern != SurfaceTexture::Pattern::none) return;
  if (!(wavelength > 0.0)) haptic.fail("textureWavelength", "must be positive");
  out.pattern = SurfaceTexture::Pattern::grid;
  out.amplitudeForce = force;
  out.wavelength = wavelength;
}

/// Reads a Surface in the order of its describe(): a group's object is opened at the group's first property.
class SurfaceReader {
 public:
  SurfaceReader(const JsonObject& haptic, const Json& document, UnknownProperties& unknown)
      : haptic_(haptic), document_(document), unknown_(unknown) {}

  void number(const char* property, double& value, const Range&, bool applies = true) {
    const PropertyName name(property);
    if (name.group.empty()) return read(haptic_, name.key, value);
    if (name.group == "popThrough") read(haptic_, "popThroughForce", value);  // the short form
    enter(name.group);
    if (object_)
      read(*object_, name.key, value, applies);
    else if (name.group == "law")
      read(haptic_, name.key, value, applies);
  }

  /// "elastic", or an object: {"type": "plastic", "yield": 2, "hardening": 100}.
  void choice(const char*, Surface::Law& law, const auto& names) {
    if (!haptic_.has("law")) return;
    if (haptic_.raw("law").isObject()) enter("law");
    const std::string name = object_ ? object_->text("type", "") : haptic_.text("law", "");
    const auto* known = std::find(std::begin(names), std::end(names), name);
    if (known == std::end(names))
      haptic_.fail("law", '\'' + name.substr(0, 40) + "' is not elastic, viscoelastic or plastic");
    law = static_cast<Surface::Law>(known - std::begin(names));
  }

  void record(const char*, SurfaceTexture& texture) {
    readTexture(haptic_, document_, texture, unknown_);
    readFlatTexture(haptic_, texture);
  }

 private:
  static void read(const JsonObject& object, const std::string& key, double& value, bool applies = true) {
    if (applies) value = object.sizeOr(key.c_str(), value);
  }

  void enter(const std::string& group) {
    if (group == group_) return;
    group_ = group;
    object_.reset();
    if (group == "law" && !haptic_.raw("law").isObject()) return;
    object_ = haptic_.object(group.c_str());
    if (object_) noteUnknown(*object_, knownKeys().at(group), unknown_);
  }

  const JsonObject& haptic_;
  const Json& document_;
  UnknownProperties& unknown_;
  std::string group_;
  std::optional<JsonObject> object_;  // of group_, if it is there
};

/// The bytes of an image that lies in a buffer view or a data URI.
std::optional<Bytes> imageBytes(const GltfDocument& document, const Json& image) {
  const Json& view = image.member("bufferView");
  if (!view.isAbsent()) {
    if (!view.isNatural() || view.integer() >= document.model.bufferViews.size()) return std::nullopt;
    const GltfRange range = viewRange(document, static_cast<std::size_t>(view.integer()));
    const GltfPiece bytes = range.read(0, range.size);
    return Bytes(bytes.view().begin(), bytes.view().end());
  }
  const Json& uri = image.member("uri");
  return uri.isText() ? decodeDataUri(uri.text()) : std::nullopt;
}

/// The `source` of a texture; absent unless both have the types of the specification.
const Json& sourceImage(const Json& document, std::size_t texture) {
  const Json& source = document.member("textures").at(texture).member("source");
  const Json& images = document.member("images");
  if (!source.isNatural() || !images.isArray() || source.integer() >= images.size()) return Json::absent();
  const Json& image = images.at(static_cast<std::size_t>(source.integer()));
  return image.isObject() ? image : Json::absent();
}

}  // namespace

void UnknownProperties::add(const std::string& name) {
  constexpr std::uint64_t kNamed = 4;
  if (++count > kNamed) return;
  if (!names.empty()) names += ", ";
  for (const char c : name.substr(0, 40)) names += c >= ' ' && c <= '~' ? c : '?';
}

void readSurface(const JsonObject& haptic, const Json& document, Surface& out, UnknownProperties& unknown) {
  noteUnknown(haptic, knownKeys().at(""), unknown);
  SurfaceReader reader(haptic, document, unknown);
  describe(reader, out);
  refuseFault(outOfRange(out), haptic.place());
  out.creaseAngle = std::min(out.creaseAngle, kLargestAngle);
}

std::vector<TextureImage> readTextures(const GltfDocument& document, std::vector<Surface>& surfaces,
                                       std::uint64_t& unread) {
  std::vector<TextureImage> images;
  std::map<std::uint32_t, std::uint32_t> known;  // glTF texture to its place in `images`, or kNoTexture
  for (Surface& surface : surfaces) {
    SurfaceTexture& texture = surface.texture;
    if (texture.pattern != SurfaceTexture::Pattern::image) continue;
    const auto [it, isNew] = known.emplace(texture.image, kNoTexture);
    if (isNew) {
      const Json& source = sourceImage(document.json, texture.image);
      const std::optional<Bytes> bytes = source.isAbsent() ? std::nullopt : imageBytes(document, source);
      if (std::optional<TextureImage> image = bytes ? decodeImage(*bytes) : std::nullopt) {
        it->second = static_cast<std::uint32_t>(images.size());
        images.push_back(std::move(*image));
      }
    }
    texture.image = it->second;
    if (it->second != kNoTexture) continue;
    texture = SurfaceTexture{};
    ++unread;
  }
  return images;
}

}  // namespace tandem::assets
