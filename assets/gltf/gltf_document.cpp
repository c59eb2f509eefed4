#include "assets/gltf/gltf_document.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <optional>

#include "assets/gltf/embedded_data.h"
#include "assets/gltf/gltf_rules.h"

namespace tandem::assets {
namespace {

constexpr std::size_t kMaxTextBytes = 200;
constexpr double kJsonShare = 0.05;    // of the progress of loading
constexpr std::size_t kMostOpen = 64;  // files of buffers; a process has a thousand descriptors by default

std::string inMebibytes(std::size_t bytes) { return std::to_string((bytes + (1 << 20) - 1) >> 20); }

std::uint32_t readU32(ByteView bytes, std::size_t at) {
  std::uint32_t value;  // glTF and every machine this runs on are little-endian
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

struct Container {
  GltfRange json, binary;
  bool hasBinary = false;
};

Container splitGlb(const GltfSource& file) {
  if (file.size() < 20) throw GltfError("header", "the file is truncated");
  const GltfPiece header = file.read(0, 12);
  if (const std::uint32_t version = readU32(header.view(), 4); version != 2)
    throw GltfError("header", "version " + std::to_string(version) + " is not glTF 2.0");
  const std::size_t length = readU32(header.view(), 8);
  if (length > file.size())
    throw GltfError("header", "the file is truncated: " + std::to_string(file.size()) + " of " +
                                  std::to_string(length) + " bytes");
  Container container;
  for (std::size_t at = 12; at + 8 <= length;) {
    const GltfPiece start = file.read(at, 8);
    const std::size_t size = readU32(start.view(), 0);
    const std::uint32_t type = readU32(start.view(), 4);
    if (size > length - at - 8)
      throw GltfError("chunk at byte " + std::to_string(at), "reaches past the file's end");
    const GltfRange chunk{&file, at + 8, size};
    if (at == 12 && type != 0x4E4F534A) throw GltfError("header", "the first chunk is not JSON");
    if (at == 12) container.json = chunk;
    if (at != 12 && type == 0x004E4942 && !container.hasBinary) {
      container.binary = chunk;
      container.hasBinary = true;
    }
    at += 8 + size + (4 - size % 4) % 4;
  }
  return container;
}

Container splitContainer(const GltfSource& file) {
  if (file.size() >= 4 && std::memcmp(file.read(0, 4).view().data(), "glTF", 4) == 0) return splitGlb(file);
  if (file.size() == 0) throw GltfError("file", "is empty");
  Container container;
  container.json = {&file, 0, file.size()};
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

Json readJson(const GltfRange& range, const LoadOptions& options) {
  const GltfPiece piece = range.read(0, range.size);
  const std::string_view text(reinterpret_cast<const char*>(piece.view().data()), piece.view().size());
  if (text.size() > options.maxJsonBytes) {
    if (const std::size_t bytes = Json::structureBytes(text); bytes > options.maxJsonBytes)
      throw GltfError("json", "has " + inMebibytes(bytes) + " MiB without long texts; at most " +
                                  inMebibytes(options.maxJsonBytes) + " are read (--max-json)");
  }
  std::function<void(double)> progress;
  if (options.progress)
    progress = [&options](double share) { options.progress(kJsonShare * share, "reading the JSON"); };
  Result<Json> parsed = Json::parse(text, progress);
  if (!parsed) throw GltfError("json", parsed.error().message);
  return std::move(*parsed);
}

bool isMeshoptFallback(const Json& buffer) {
  const Json& fallback = findExtension(buffer, "EXT_meshopt_compression").member("fallback");
  return fallback.isBoolean() && fallback.boolean();
}

/// Fills buffers[i] from the GLB's chunk, a data URI or a file beside this one.
void openBuffer(GltfDocument& document, const Container& container, std::size_t i,
                const std::string* directory) {
  const Json& buffer = document.json.member("buffers").at(i);
  const std::string place = placeName("buffers", i);
  const std::size_t length = static_cast<std::size_t>(buffer.member("byteLength").integer());
  const Json& statedUri = buffer.member("uri");
  if (statedUri.isAbsent()) {
    if (i == 0 && container.hasBinary)
      document.buffers[i] = container.binary;
    else if (isMeshoptFallback(buffer))
      return;
    else
      throw GltfError(place, "has neither a uri nor a binary chunk");
  } else {
    const std::string& uri = statedUri.text();
    GltfSource& owned = document.ownedBuffers[i];
    if (uri.compare(0, 5, "data:") == 0) {
      std::optional<Bytes> bytes = decodeDataUri(uri);
      if (!bytes) throw GltfError(place + ".uri", "the data URI cannot be decoded");
      owned = GltfSource(std::move(*bytes));
    } else {
      if (directory == nullptr) throw GltfError(place + ".uri", "external files cannot be read from here");
      const bool keepOpen = document.externals.size() < kMostOpen;
      owned = GltfSource(externalPath(uri, *directory, place + ".uri").string(), place + ".uri", keepOpen);
      document.externals.push_back(&owned);
    }
    document.buffers[i] = {&owned, 0, owned.size()};
  }
  if (document.buffers[i].size < length)
    throw GltfError(place, "holds " + std::to_string(document.buffers[i].size) + " of its " +
                               std::to_string(length) + " bytes");
  document.buffers[i].size = length;
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

std::vector<std::string> extensionNames(const GltfDocument& document, const char* key) {
  std::vector<std::string> names;
  const Json& list = document.json.member(key);
  if (list.isAbsent()) return names;
  if (!list.isArray()) throw GltfError(key, "must be an array");
  for (const Json& name : list) {
    if (!name.isText()) throw GltfError(key, "must hold strings");
    names.push_back(name.text());
  }
  return names;
}

const Json& findExtension(const Json& object, const char* name) {
  const Json& extension = object.member("extensions").member(name);
  return extension.isObject() ? extension : Json::absent();
}

void GltfDocument::requireUnchanged() const {
  file.requireUnchanged();
  for (const GltfSource* external : externals) external->requireUnchanged();
}

void openGltf(GltfSource file, const std::string* directory, const LoadOptions& options,
              GltfDocument& document) {
  document.file = std::move(file);
  const Container container = splitContainer(document.file);
  document.json = readJson(container.json, options);
  const Json& root = document.json;
  if (!root.isObject()) throw GltfError("json", "is not an object");
  const Json& asset = root.member("asset");
  if (!asset.isObject()) throw GltfError("asset", "is missing");
  const Json& version = asset.member("version");
  if (!version.isText() || version.text().compare(0, 2, "2.") != 0)
    throw GltfError("asset.version", "is not glTF 2.x");
  checkRules(document.json);
  const std::size_t count = root.member("buffers").size();
  document.ownedBuffers.resize(count);
  document.buffers.resize(count);
  for (std::size_t i = 0; i < count; ++i) openBuffer(document, container, i, directory);
}

}  // namespace tandem::assets
