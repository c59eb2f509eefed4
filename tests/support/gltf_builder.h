#pragma once

// Builds small glTF files in memory. The document is JSON that a test may change at will before asking for
// the bytes, so that it can also build files that no honest tool writes.

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace tandem::tests {

class GltfBuilder {
 public:
  using Json = nlohmann::json;

  GltfBuilder() {
    json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}};
    json["scenes"] = Json::array({{{"nodes", Json::array()}}});
    for (const char* section : {"nodes", "meshes", "accessors", "bufferViews"}) json[section] = Json::array();
  }

  /// Appends bytes and a buffer view on them; returns the view's index.
  template <typename T>
  int addView(const std::vector<T>& values) {
    while (binary.size() % 4 != 0) binary.push_back(0);
    const std::size_t offset = binary.size(), length = values.size() * sizeof(T);
    binary.resize(offset + length);
    if (length > 0) std::memcpy(binary.data() + offset, values.data(), length);
    json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", length}});
    return static_cast<int>(json["bufferViews"].size()) - 1;
  }

  template <typename T>
  int addAccessor(const std::vector<T>& values, int componentType, const char* type, std::size_t components) {
    const int view = addView(values);
    json["accessors"].push_back({{"bufferView", view},
                                 {"componentType", componentType},
                                 {"count", values.size() / components},
                                 {"type", type}});
    return static_cast<int>(json["accessors"].size()) - 1;
  }

  int addPositions(const std::vector<float>& xyz) { return addAccessor(xyz, 5126, "VEC3", 3); }
  int addIndices(const std::vector<std::uint32_t>& indices) {
    return addAccessor(indices, 5125, "SCALAR", 1);
  }

  /// A mesh of one primitive; indices or material < 0 leave them out.
  int addMesh(int positions, int indices = -1, int mode = 4, int material = -1,
              const std::string& name = "") {
    Json primitive = {{"attributes", {{"POSITION", positions}}}, {"mode", mode}};
    if (indices >= 0) primitive["indices"] = indices;
    if (material >= 0) primitive["material"] = material;
    Json mesh = {{"primitives", Json::array({primitive})}};
    if (!name.empty()) mesh["name"] = name;
    json["meshes"].push_back(mesh);
    return static_cast<int>(json["meshes"].size()) - 1;
  }

  /// An axis-aligned box about the origin, twelve triangles seen from outside.
  int addBox(float x, float y, float z, const std::string& name = "") {
    std::vector<float> corners;
    for (int i = 0; i < 8; ++i) {
      corners.push_back((i & 1) != 0 ? x / 2 : -x / 2);
      corners.push_back((i & 2) != 0 ? y / 2 : -y / 2);
      corners.push_back((i & 4) != 0 ? z / 2 : -z / 2);
    }
    const int positions = addPositions(corners);  // first, so that tests know which accessor is which
    return addMesh(positions, addIndices(boxIndices()), 4, -1, name);
  }

  static std::vector<std::uint32_t> boxIndices() {
    return {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
            2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};
  }

  /// A node of the scene's top level.
  int addNode(const Json& node) {
    const int index = addOrphan(node);
    json["scenes"][0]["nodes"].push_back(index);
    return index;
  }

  /// A node that the test makes a child of another.
  int addOrphan(const Json& node) {
    json["nodes"].push_back(node);
    return static_cast<int>(json["nodes"].size()) - 1;
  }

  std::vector<unsigned char> glb() const {
    Json document = json;
    if (!document.contains("buffers")) document["buffers"] = Json::array({{{"byteLength", binary.size()}}});
    return wrapGlb(document.dump(), binary);
  }

  /// A .gltf without a binary chunk, its buffer in a data URI unless the test has set one.
  std::vector<unsigned char> gltf() const {
    Json document = json;
    if (!document.contains("buffers"))
      document["buffers"] = Json::array({{{"byteLength", binary.size()}, {"uri", dataUri(binary)}}});
    const std::string text = document.dump();
    return {text.begin(), text.end()};
  }

  static std::vector<unsigned char> wrapGlb(std::string text, std::vector<unsigned char> bytes) {
    while (text.size() % 4 != 0) text += ' ';
    while (bytes.size() % 4 != 0) bytes.push_back(0);
    std::vector<unsigned char> out;
    const auto u32 = [&](std::size_t value) {
      for (int i = 0; i < 4; ++i) out.push_back(static_cast<unsigned char>(value >> (8 * i)));
    };
    u32(0x46546C67);
    u32(2);
    u32(12 + 8 + text.size() + 8 + bytes.size());
    u32(text.size());
    u32(0x4E4F534A);
    out.insert(out.end(), text.begin(), text.end());
    u32(bytes.size());
    u32(0x004E4942);
    out.insert(out.end(), bytes.begin(), bytes.end());
    return out;
  }

  static std::string dataUri(const std::vector<unsigned char>& bytes) {
    static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out = "data:application/octet-stream;base64,";
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
      const std::size_t left = bytes.size() - i;
      const unsigned value = (unsigned{bytes[i]} << 16) | (left > 1 ? unsigned{bytes[i + 1]} << 8 : 0) |
                             (left > 2 ? unsigned{bytes[i + 2]} : 0);
      out += kDigits[value >> 18];
      out += kDigits[value >> 12 & 63];
      out += left > 1 ? kDigits[value >> 6 & 63] : '=';
      out += left > 2 ? kDigits[value & 63] : '=';
    }
    return out;
  }

  Json json;
  std::vector<unsigned char> binary;
};

}  // namespace tandem::tests
