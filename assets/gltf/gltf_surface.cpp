#include "assets/gltf/gltf_surface.h"

#include <algorithm>
#include <initializer_list>
#include <map>
#include <numbers>
#include <optional>
#include <string_view>

#include "assets/gltf/gltf_decode.h"
#include "assets/scene/value_ranges.h"

namespace tandem::assets {
namespace {

using nlohmann::json;

constexpr double kLargestAngle = std::numbers::pi;

void noteUnknown(const JsonObject& object, std::initializer_list<std::string_view> known,
                 UnknownProperties& unknown) {
  for (const auto& [key, value] : object.raw().items())
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

void readTexture(const JsonObject& haptic, const json& document, SurfaceTexture& out,
                 UnknownProperties& unknown) {
  const auto texture = haptic.object("texture");
  if (!texture) return;
  const auto textures = document.find("textures");
  const std::size_t count = textures != document.end() && textures->is_array() ? textures->size() : 0;
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
  const json& law = haptic.raw()["law"];
  const std::optional<JsonObject> object = law.is_object() ? haptic.object("law") : std::nullopt;
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
std::optional<Bytes> imageBytes(const GltfDocument& document, const json& image) {
  if (const auto view = image.find("bufferView"); view != image.end()) {
    if (!view->is_number_unsigned() || view->get<std::uint64_t>() >= document.model.bufferViews.size())
      return std::nullopt;
    const ByteView bytes = viewBytes(document, view->get<std::size_t>());
    return Bytes(bytes.begin(), bytes.end());
  }
  const auto uri = image.find("uri");
  if (uri == image.end() || !uri->is_string()) return std::nullopt;
  const std::string text = uri->get<std::string>();
  Bytes bytes;
  std::string type;
  if (!tinygltf::IsDataURI(text) || !tinygltf::DecodeDataURI(&bytes, type, text, 0, false))
    return std::nullopt;
  return bytes;
}

/// The `source` of a texture, if both are what the specification says.
const json* sourceImage(const json& document, std::size_t texture) {
  const json& entry = document["textures"][texture];
  const auto images = document.find("images");
  const auto source = entry.is_object() ? entry.find("source") : entry.end();
  if (!entry.is_object() || source == entry.end() || !source->is_number_unsigned()) return nullptr;
  if (images == document.end() || !images->is_array() || source->get<std::uint64_t>() >= images->size())
    return nullptr;
  const json& image = (*images)[source->get<std::size_t>()];
  return image.is_object() ? &image : nullptr;
}

std::uint32_t bigEndian(const Bytes& bytes, std::size_t at, std::size_t size) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value = value << 8 | bytes[at + i];
  return value;
}

/// Whether the header states a size that may be decoded: a few bytes must not ask for gigabytes.
bool modestSize(const Bytes& bytes) {
  static constexpr unsigned char kPng[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  const auto fits = [](std::uint32_t side) { return side > 0 && side <= kMaxTextureSide; };
  if (bytes.size() >= 24 && std::equal(std::begin(kPng), std::end(kPng), bytes.begin()))
    return fits(bigEndian(bytes, 16, 4)) && fits(bigEndian(bytes, 20, 4));
  if (bytes.size() < 4 || bytes[0] != 0xff || bytes[1] != 0xd8) return false;
  // JPEG: a chain of segments; the size stands in the frame's (ITU T.81, B.2.2).
  for (std::size_t at = 2; at + 9 <= bytes.size() && bytes[at] == 0xff;) {
    const unsigned marker = bytes[at + 1];
    const bool frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (frame) return fits(bigEndian(bytes, at + 5, 2)) && fits(bigEndian(bytes, at + 7, 2));
    at += 2 + bigEndian(bytes, at + 2, 2);
  }
  return false;
}

std::optional<TextureImage> decodeImage(const Bytes& bytes) {
  if (!modestSize(bytes)) return std::nullopt;
  tinygltf::Image image;
  std::string error, warning;
  if (!tinygltf::LoadImageData(&image, 0, &error, &warning, 0, 0, bytes.data(),
                               static_cast<int>(bytes.size()), nullptr))
    return std::nullopt;
  const std::size_t count = std::size_t(std::max(image.width, 0)) * std::size_t(std::max(image.height, 0));
  const std::size_t channels = static_cast<std::size_t>(std::max(image.component, 0));
  const std::size_t step = channels * static_cast<std::size_t>(image.bits / 8);
  if (count == 0 || channels == 0 || (image.bits != 8 && image.bits != 16) ||
      image.image.size() < count * step)
    return std::nullopt;
  TextureImage out;
  out.width = static_cast<std::uint32_t>(image.width);
  out.height = static_cast<std::uint32_t>(image.height);
  out.texels.resize(count);
  // The red channel: height maps are grey. Of 16 bits the upper eight, which come second in memory.
  const std::size_t high = image.bits == 16 ? 1 : 0;
  for (std::size_t i = 0; i < count; ++i) out.texels[i] = image.image[i * step + high];
  return out;
}

}  // namespace

void UnknownProperties::add(const std::string& name) {
  constexpr std::uint64_t kNamed = 4;
  if (++count > kNamed) return;
  if (!names.empty()) names += ", ";
  for (const char c : name.substr(0, 40)) names += c >= ' ' && c <= '~' ? c : '?';
}

void readSurface(const JsonObject& haptic, const json& document, Surface& out, UnknownProperties& unknown) {
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
      const json* source = sourceImage(document.json, texture.image);
      const std::optional<Bytes> bytes = source != nullptr ? imageBytes(document, *source) : std::nullopt;
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
