#include "assets/gltf/gltf_surface.h"

#include <algorithm>
#include <initializer_list>
#include <map>
#include <numbers>
#include <optional>
#include <string_view>

#include "assets/gltf/embedded_data.h"
#include "assets/gltf/gltf_decode.h"
#include "assets/scene/value_ranges.h"

namespace tandem::assets {
namespace {

constexpr double kLargestAngle = std::numbers::pi;

void noteUnknown(const JsonObject& object, std::initializer_list<std::string_view> known,
                 UnknownProperties& unknown) {
  for (const std::string& key : object.raw().keys())
    if (std::find(known.begin(), known.end(), key) == known.end()) unknown.add(key);
}

SurfaceTexture::Pattern patternOf(const JsonObject& texture) {
  using Pattern = SurfaceTexture::Pattern;
  const std::string name = texture.text("function", "");
  if (name == "sine") return Pattern::sine;
  if (name == "grid") return Pattern::grid;
  if (name == "bumps") return Pattern::bumps;
  if (name == "noise") return Pattern::noise;
  texture.fail("function", "'" + name.substr(0, 40) + "' is not sine, grid, bumps or noise");
}

void readTexture(const JsonObject& haptic, JsonView document, SurfaceTexture& out,
                 UnknownProperties& unknown) {
  const auto texture = haptic.object("texture");
  if (!texture) return;
  const JsonView textures = document.member("textures");
  const std::size_t count = textures.isArray() ? textures.size() : 0;
  if (const auto image = texture->index("image", count, "textures")) {
    out.pattern = SurfaceTexture::Pattern::image;
    out.image = static_cast<std::uint32_t>(*image);
  } else {
    out.pattern = patternOf(*texture);
  }
  out.amplitude = texture->sizeOr("amplitude", 0.0);
  out.wavelength = texture->sizeOr("wavelength", 0.0);
  out.frictionScale = texture->sizeOr("frictionScale", 1.0);
  if (out.pattern != SurfaceTexture::Pattern::image && !(out.wavelength > 0.0))
    texture->fail("wavelength", "must be positive");
  noteUnknown(*texture, {"image", "function", "amplitude", "wavelength", "frictionScale"}, unknown);
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

/// Two numbers of one object, e.g. {"frequency": 80, "amplitude": 0.3}.
void readPair(const JsonObject& haptic, const char* key, const char* first, double& a, const char* second,
              double& b, UnknownProperties& unknown) {
  const auto object = haptic.object(key);
  if (!object) return;
  a = object->sizeOr(first, 0.0);
  b = object->sizeOr(second, 0.0);
  noteUnknown(*object, {first, second}, unknown);
}

/// "elastic", or an object: {"type": "plastic", "yield": 2, "hardening": 100}.
void readLaw(const JsonObject& haptic, Surface& out, UnknownProperties& unknown) {
  if (!haptic.has("law")) return;
  const std::optional<JsonObject> object = haptic.raw("law").isObject() ? haptic.object("law") : std::nullopt;
  const JsonObject& holder = object ? *object : haptic;
  const std::string name = object ? object->text("type", "") : haptic.text("law", "");
  if (name == "viscoelastic") {
    out.law = Surface::Law::viscoelastic;
    out.stiffness2 = holder.sizeOr("stiffness2", 0.0);
    out.relaxation = holder.sizeOr("relaxation", 0.0);
  } else if (name == "plastic") {
    out.law = Surface::Law::plastic;
    out.yieldForce = holder.sizeOr("yield", 0.0);
    out.hardening = holder.sizeOr("hardening", 0.0);
  } else if (name != "elastic") {
    haptic.fail("law", "'" + name.substr(0, 40) + "' is not elastic, viscoelastic or plastic");
  }
  if (object) noteUnknown(*object, {"type", "stiffness2", "relaxation", "yield", "hardening"}, unknown);
}

/// The bytes of an image that lies in a buffer view or a data URI.
std::optional<Bytes> imageBytes(const GltfDocument& document, JsonView image) {
  if (const JsonView view = image.member("bufferView")) {
    if (!view.isWhole() || view.whole() >= document.model.bufferViews.size()) return std::nullopt;
    const ByteView bytes = viewBytes(document, static_cast<std::size_t>(view.whole()));
    return Bytes(bytes.begin(), bytes.end());
  }
  const JsonView uri = image.member("uri");
  return uri.isText() ? decodeDataUri(uri.text()) : std::nullopt;
}

/// The `source` of a texture, if both are what the specification says.
JsonView sourceImage(JsonView document, std::size_t texture) {
  const JsonView source = document.member("textures").element(texture).member("source");
  const JsonView images = document.member("images");
  if (!source.isWhole() || !images.isArray() || source.whole() >= images.size()) return {};
  const JsonView image = images.element(static_cast<std::size_t>(source.whole()));
  return image.isObject() ? image : JsonView();
}

}  // namespace

void UnknownProperties::add(const std::string& name) {
  constexpr std::uint64_t kNamed = 4;
  if (++count > kNamed) return;
  if (!names.empty()) names += ", ";
  for (const char c : name.substr(0, 40)) names += c >= ' ' && c <= '~' ? c : '?';
}

void readSurface(const JsonObject& haptic, JsonView document, Surface& out, UnknownProperties& unknown) {
  noteUnknown(haptic, {"stiffness",       "damping",   "staticFriction",   "dynamicFriction",
                       "field",           "control",   "creaseAngle",      "viscosity",
                       "texture",         "vibration", "stickSlip",        "magnetic",
                       "popThrough",      "law",       "stiffness2",       "relaxation",
                       "yield",           "hardening", "textureAmplitude", "textureWavelength",
                       "popThroughForce", "tolerance"},
              unknown);
  out.creaseAngle = haptic.sizeOr("creaseAngle", 0.0);
  out.viscosity = haptic.sizeOr("viscosity", 0.0);
  readTexture(haptic, document, out.texture, unknown);
  readFlatTexture(haptic, out.texture);
  readPair(haptic, "vibration", "frequency", out.vibrationFrequency, "amplitude", out.vibrationAmplitude,
           unknown);
  readPair(haptic, "stickSlip", "force", out.stickSlipForce, "stiffness", out.stickSlipStiffness, unknown);
  readPair(haptic, "magnetic", "force", out.magneticForce, "distance", out.magneticDistance, unknown);
  out.popThroughForce = haptic.sizeOr("popThroughForce", 0.0);
  if (const auto popThrough = haptic.object("popThrough")) {
    out.popThroughForce = popThrough->sizeOr("force", out.popThroughForce);
    noteUnknown(*popThrough, {"force"}, unknown);
  }
  readLaw(haptic, out, unknown);
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
      const JsonView source = sourceImage(document.json.root(), texture.image);
      const std::optional<Bytes> bytes = source ? imageBytes(document, source) : std::nullopt;
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
