#include "assets/gltf/gltf_decode.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include <draco/compression/decode.h>
#include <meshoptimizer.h>
#include <glm/common.hpp>

namespace tandem::assets {
namespace {

// The codecs' best ratios are 64 (meshopt's vertex codec) and 12 (its index codec). A larger ratio means a
// false count.
constexpr std::size_t kMaxMeshoptRatio = 256;
// A Draco connectivity symbol takes a fraction of a bit at best; real meshes spend 1 to 2 bits a face.
constexpr std::size_t kMaxDracoFacesPerByte = 256;

std::size_t fileBytes(const GltfDocument& document) {
  std::size_t size = document.file.size();
  for (const GltfSource* external : document.externals) size += external->size();
  return size;
}

std::size_t componentSize(int componentType, const std::string& place) {
  switch (componentType) {
    case kComponentByte:
    case kComponentUnsignedByte:
      return 1;
    case kComponentShort:
    case kComponentUnsignedShort:
      return 2;
    case kComponentUnsignedInt:
    case kComponentFloat:
      return 4;
  }
  throw GltfError(place, "component type " + std::to_string(componentType) + " is unknown");
}

/// Elements at a stride inside checked bytes.
struct Elements {
  GltfPiece data;  // from the first element to the last; nothing for those that are all zero
  std::size_t count = 0, stride = 0;

  const unsigned char* at(std::size_t i) const { return data.view().data() + i * stride; }
};

/// `count` elements from `offset` of a view; a stride of 0 means tightly packed.
Elements elementsIn(const GltfRange& view, std::size_t offset, std::size_t count, std::size_t stride,
                    std::size_t size, const std::string& place) {
  if (stride == 0) stride = size;
  if (stride < size) throw GltfError(place, "the stride is smaller than an element");
  // All factors are below 2^31, so the product cannot wrap.
  if (count > 0 && (offset > view.size || (count - 1) * stride + size > view.size - offset))
    throw GltfError(place, std::to_string(count) + " elements do not fit into its buffer view of " +
                               std::to_string(view.size) + " bytes");
  Elements elements;
  if (count > 0) elements.data = view.read(offset, (count - 1) * stride + size);
  elements.count = count;
  elements.stride = stride;
  return elements;
}

std::uint32_t readUnsigned(const unsigned char* at, std::size_t size) {
  std::uint32_t value = 0;  // little-endian, as glTF is
  std::memcpy(&value, at, size);
  return value;
}

void applySparse(const GltfDocument& document, std::size_t index, std::size_t size, Elements& base) {
  const GltfAccessor& accessor = document.model.accessors[index];
  const GltfSparse& sparse = accessor.sparse;
  const std::string place = placeName("accessors", index, "sparse");
  const std::size_t count = sparse.count;
  if (count > base.count) throw GltfError(place + ".count", "is larger than the accessor's");
  if (sparse.indicesComponentType == kComponentFloat)
    throw GltfError(place + ".indices", "must be unsigned integers");
  const std::size_t indexSize = componentSize(sparse.indicesComponentType, place + ".indices.componentType");
  const Elements indices = elementsIn(viewRange(document, sparse.indicesView), sparse.indicesOffset, count, 0,
                                      indexSize, place + ".indices");
  const Elements values = elementsIn(viewRange(document, sparse.valuesView), sparse.valuesOffset, count, 0,
                                     size, place + ".values");
  Bytes dense(base.count * size, 0);
  if (!base.data.view().empty())
    for (std::size_t i = 0; i < base.count; ++i) std::memcpy(dense.data() + i * size, base.at(i), size);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t target = readUnsigned(indices.at(i), indexSize);
    if (target >= base.count)
      throw GltfError(place + ".indices", "index " + std::to_string(target) + " is out of range");
    std::memcpy(dense.data() + target * size, values.at(i), size);
  }
  base.data = GltfPiece(std::move(dense));
  base.stride = size;
}

/// The elements of an accessor of `components` numbers each, with its sparse elements replaced.
Elements accessorElements(const GltfDocument& document, std::size_t index, GltfAccessor::Type type,
                          std::size_t components) {
  const GltfAccessor& accessor = document.model.accessors[index];
  const std::string place = placeName("accessors", index);
  if (accessor.type != type) throw GltfError(place + ".type", "is not the one needed here");
  const std::size_t size = components * componentSize(accessor.componentType, place + ".componentType");
  Elements elements;
  if (accessor.bufferView >= 0) {
    const auto view = static_cast<std::size_t>(accessor.bufferView);
    elements = elementsIn(viewRange(document, view), accessor.byteOffset, accessor.count,
                          document.model.bufferViews[view].byteStride, size, place);
  } else {
    // These elements are zeros without bytes in the file, so their count needs a separate bound.
    if (!accessor.sparse.present) throw GltfError(place, "has neither a buffer view nor sparse values");
    elements.count = elementCount(document, index);
  }
  if (accessor.sparse.present) applySparse(document, index, size, elements);
  return elements;
}

template <typename T>
void convertPositions(const Elements& elements, double divisor, std::vector<glm::dvec3>& out) {
  for (std::size_t i = 0; i < elements.count; ++i) {
    T values[3];
    std::memcpy(values, elements.at(i), sizeof values);
    const glm::dvec3 position(static_cast<double>(values[0]), static_cast<double>(values[1]),
                              static_cast<double>(values[2]));
    // The most negative value of a normalised signed integer means -1 too (glTF 2.0, 3.6.2.2).
    out.push_back(divisor == 1.0 ? position : glm::max(position / divisor, glm::dvec3(-1.0)));
  }
}

template <typename T>
void convertIntegers(const Elements& elements, bool normalized, std::vector<glm::dvec3>& out) {
  convertPositions<T>(elements, normalized ? static_cast<double>(std::numeric_limits<T>::max()) : 1.0, out);
}

template <typename T>
void convertTexCoords(const Elements& elements, float divisor, std::vector<glm::vec2>& out) {
  for (std::size_t i = 0; i < elements.count; ++i) {
    T values[2];
    std::memcpy(values, elements.at(i), sizeof values);
    out.push_back(glm::vec2(static_cast<float>(values[0]), static_cast<float>(values[1])) / divisor);
  }
}

void requireFinite(const std::vector<glm::dvec3>& positions, const std::string& place) {
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const glm::dvec3& p = positions[i];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
      throw GltfError(place, "position " + std::to_string(i) + " is not finite");
  }
}

std::size_t wholeIn(const Json& object, const char* key, const std::string& place, bool required,
                    std::size_t limit) {
  const Json& value = object.member(key);
  if (value.isAbsent()) {
    if (required) throw GltfError(place + "." + key, "is missing");
    return 0;
  }
  const bool good = value.isNatural() && value.integer() <= limit;
  if (!good) throw GltfError(place + "." + key, "must be a whole number of at most " + std::to_string(limit));
  return static_cast<std::size_t>(value.integer());
}

/// `fallback` where the value is absent, empty where it is no text.
std::string textOr(const Json& value, const char* fallback) {
  if (value.isAbsent()) return fallback;
  return value.isText() ? value.text() : "";
}

void applyMeshoptFilter(const std::string& filter, Bytes& bytes, std::size_t count, std::size_t stride,
                        const std::string& place) {
  if (filter == "NONE") return;
  if (filter == "OCTAHEDRAL" && (stride == 4 || stride == 8))
    return meshopt_decodeFilterOct(bytes.data(), count, stride);
  if (filter == "QUATERNION" && stride == 8) return meshopt_decodeFilterQuat(bytes.data(), count, stride);
  if (filter == "EXPONENTIAL" && stride % 4 == 0) return meshopt_decodeFilterExp(bytes.data(), count, stride);
  throw GltfError(place + ".filter",
                  "'" + filter.substr(0, 40) + "' does not fit a stride of " + std::to_string(stride));
}

Bytes decodeMeshopt(const GltfDocument& document, const Json& extension, std::size_t viewLength,
                    const std::string& place) {
  constexpr std::size_t kMax = std::numeric_limits<std::int32_t>::max();
  const std::size_t bufferIndex = wholeIn(extension, "buffer", place, true, kMax);
  if (bufferIndex >= document.buffers.size()) throw GltfError(place + ".buffer", "is out of range");
  const GltfRange& buffer = document.buffers[bufferIndex];
  const std::size_t offset = wholeIn(extension, "byteOffset", place, false, kMax);
  const std::size_t length = wholeIn(extension, "byteLength", place, true, kMax);
  const std::size_t stride = wholeIn(extension, "byteStride", place, true, 256);
  const std::size_t count = wholeIn(extension, "count", place, true, kMax);
  if (offset > buffer.size || length > buffer.size - offset)
    throw GltfError(place, "reaches past the end of its buffer");
  if (count * stride != viewLength)
    throw GltfError(place, "count times byteStride is not the view's byteLength");
  if (viewLength == 0 || viewLength / kMaxMeshoptRatio > length)
    throw GltfError(place, "claims more data than its bytes can hold");
  const std::string mode = textOr(extension.member("mode"), "");
  const std::string filter = textOr(extension.member("filter"), "NONE");
  Bytes out(viewLength);
  const GltfPiece compressed = buffer.read(offset, length);
  const unsigned char* in = compressed.view().data();
  int failed = 1;
  if (mode == "ATTRIBUTES" && stride > 0 && stride % 4 == 0) {
    failed = meshopt_decodeVertexBuffer(out.data(), count, stride, in, length);
    if (failed == 0) applyMeshoptFilter(filter, out, count, stride, place);
  } else if (mode == "TRIANGLES" && (stride == 2 || stride == 4) && count % 3 == 0) {
    failed = meshopt_decodeIndexBuffer(out.data(), count, stride, in, length);
  } else if (mode == "INDICES" && (stride == 2 || stride == 4)) {
    failed = meshopt_decodeIndexSequence(out.data(), count, stride, in, length);
  } else {
    throw GltfError(place + ".mode",
                    "'" + mode.substr(0, 40) + "' does not fit a stride of " + std::to_string(stride));
  }
  if (failed != 0) throw GltfError(place, "the meshopt data cannot be decoded");
  return out;
}

/// Reads LEB128 numbers and bytes off a Draco header.
struct DracoHeader {
  ByteView bytes;
  std::size_t at = 0;

  unsigned byte(const std::string& place) {
    if (at >= bytes.size()) throw GltfError(place, "the Draco data is truncated");
    return bytes[at++];
  }
  std::uint64_t varint(const std::string& place) {
    std::uint64_t value = 0;
    for (int shift = 0; shift < 35; shift += 7) {
      const unsigned b = byte(place);
      value |= std::uint64_t(b & 127u) << shift;
      if ((b & 128u) == 0) return value;
    }
    throw GltfError(place, "the Draco header is broken");
  }
};

/// Checks the header's counts against the length of the data, because the decoder allocates by them before it
/// reaches the end of the data. Layout: Draco bitstream specification 2.2, sections 3 and 5; glTF allows no
/// other version.
void checkDracoHeader(ByteView bytes, const std::string& place) {
  DracoHeader header{bytes};
  for (const char expected : {'D', 'R', 'A', 'C', 'O'})
    if (header.byte(place) != static_cast<unsigned char>(expected))
      throw GltfError(place, "is not Draco data");
  const unsigned major = header.byte(place), minor = header.byte(place);
  if (major != 2 || minor != 2)
    throw GltfError(place,
                    "Draco version " + std::to_string(major) + "." + std::to_string(minor) + " is not 2.2");
  if (header.byte(place) != 1) throw GltfError(place, "is a Draco point cloud, not a mesh");
  const unsigned method = header.byte(place);
  const unsigned flags = header.byte(place) | header.byte(place) << 8;
  if ((flags & 0x8000u) != 0) throw GltfError(place, "carries Draco metadata, which is not supported");
  if (method > 1) throw GltfError(place, "Draco method " + std::to_string(method) + " is unknown");
  if (method == 1) header.byte(place);  // the edgebreaker's traversal type
  const std::uint64_t a = header.varint(place), b = header.varint(place);
  const std::uint64_t limit = std::uint64_t(bytes.size()) * kMaxDracoFacesPerByte;
  if (a > limit || b > limit) throw GltfError(place, "claims more faces than its bytes can hold");
}

/// One vector a point; false where one cannot be read.
bool readDraco(const draco::Mesh& mesh, const draco::PointAttribute& attribute,
               std::vector<glm::dvec3>& out) {
  out.resize(mesh.num_points());
  for (std::uint32_t i = 0; i < mesh.num_points(); ++i) {
    const draco::AttributeValueIndex value = attribute.mapped_index(draco::PointIndex(i));
    double numbers[3];
    if (value.value() >= attribute.size() || !attribute.ConvertValue<double, 3>(value, numbers)) return false;
    out[i] = {numbers[0], numbers[1], numbers[2]};
  }
  return true;
}

}  // namespace

GltfRange viewRange(const GltfDocument& document, std::size_t index) {
  if (index < document.ownedViews.size() && document.ownedViews[index].size() > 0)
    return {&document.ownedViews[index], 0, document.ownedViews[index].size()};
  const GltfBufferView& view = document.model.bufferViews[index];
  const GltfRange& buffer = document.buffers[view.buffer];
  if (view.byteOffset > buffer.size || view.byteLength > buffer.size - view.byteOffset)
    throw GltfError(placeName("bufferViews", index),
                    "reaches past the end of its buffer (" + std::to_string(view.byteOffset) + " + " +
                        std::to_string(view.byteLength) + " of " + std::to_string(buffer.size) + " bytes)");
  return {buffer.source, buffer.at + view.byteOffset, view.byteLength};
}

void decodeMeshoptViews(GltfDocument& document) {
  const std::size_t count = document.model.bufferViews.size();
  document.ownedViews.resize(count);
  const Json& views = document.json.member("bufferViews");
  for (std::size_t i = 0; i < count; ++i) {
    const Json& extension = findExtension(views.at(i), "EXT_meshopt_compression");
    if (extension.isAbsent()) continue;
    document.ownedViews[i] =
        GltfSource(decodeMeshopt(document, extension, document.model.bufferViews[i].byteLength,
                                 placeName("bufferViews", i, "EXT_meshopt_compression")));
  }
}

std::size_t elementCount(const GltfDocument& document, std::size_t index) {
  const GltfAccessor& accessor = document.model.accessors[index];
  // An element has at least one byte. Elements without a buffer view have none; they may not outnumber the
  // file's bytes.
  const std::size_t available = accessor.bufferView >= 0
                                    ? viewRange(document, static_cast<std::size_t>(accessor.bufferView)).size
                                    : fileBytes(document);
  if (accessor.count > available)
    throw GltfError(
        placeName("accessors", index),
        std::to_string(accessor.count) + " elements do not fit into " + std::to_string(available) + " bytes");
  return accessor.count;
}

std::vector<glm::dvec3> readPositions(const GltfDocument& document, std::size_t accessor) {
  const Elements elements = accessorElements(document, accessor, GltfAccessor::Type::vec3, 3);
  const bool normalized = document.model.accessors[accessor].normalized;
  std::vector<glm::dvec3> positions;
  positions.reserve(elements.count);
  switch (document.model.accessors[accessor].componentType) {
    case kComponentFloat:
      convertPositions<float>(elements, 1.0, positions);
      break;
    case kComponentByte:
      convertIntegers<std::int8_t>(elements, normalized, positions);
      break;
    case kComponentUnsignedByte:
      convertIntegers<std::uint8_t>(elements, normalized, positions);
      break;
    case kComponentShort:
      convertIntegers<std::int16_t>(elements, normalized, positions);
      break;
    case kComponentUnsignedShort:
      convertIntegers<std::uint16_t>(elements, normalized, positions);
      break;
    default:
      throw GltfError(placeName("accessors", accessor, "componentType"), "positions cannot be of this type");
  }
  requireFinite(positions, placeName("accessors", accessor));
  return positions;
}

std::vector<glm::dvec3> readNormals(const GltfDocument& document, std::size_t index, std::size_t count) {
  const GltfAccessor& accessor = document.model.accessors[index];
  const bool integers = accessor.componentType == kComponentByte || accessor.componentType == kComponentShort;
  if (accessor.type != GltfAccessor::Type::vec3 || accessor.count != count ||
      !(accessor.componentType == kComponentFloat || (integers && accessor.normalized)))
    return {};
  const Elements elements = accessorElements(document, index, GltfAccessor::Type::vec3, 3);
  std::vector<glm::dvec3> normals;
  normals.reserve(elements.count);
  if (accessor.componentType == kComponentFloat)
    convertPositions<float>(elements, 1.0, normals);
  else if (accessor.componentType == kComponentByte)
    convertIntegers<std::int8_t>(elements, true, normals);
  else
    convertIntegers<std::int16_t>(elements, true, normals);
  return normals;
}

std::vector<glm::vec2> readTexCoords(const GltfDocument& document, std::size_t accessor) {
  const Elements elements = accessorElements(document, accessor, GltfAccessor::Type::vec2, 2);
  const bool normalized = document.model.accessors[accessor].normalized;
  std::vector<glm::vec2> out;
  out.reserve(elements.count);
  switch (document.model.accessors[accessor].componentType) {
    case kComponentFloat:
      convertTexCoords<float>(elements, 1.0f, out);
      break;
    case kComponentUnsignedByte:
      convertTexCoords<std::uint8_t>(elements, normalized ? 255.0f : 1.0f, out);
      break;
    case kComponentUnsignedShort:
      convertTexCoords<std::uint16_t>(elements, normalized ? 65535.0f : 1.0f, out);
      break;
    default:
      throw GltfError(placeName("accessors", accessor, "componentType"),
                      "texture coordinates cannot be of this type");
  }
  for (const glm::vec2& uv : out)
    if (!std::isfinite(uv.x) || !std::isfinite(uv.y))
      throw GltfError(placeName("accessors", accessor), "a texture coordinate is not finite");
  return out;
}

std::vector<std::uint32_t> readIndices(const GltfDocument& document, std::size_t accessor) {
  const int componentType = document.model.accessors[accessor].componentType;
  if (componentType != kComponentUnsignedByte && componentType != kComponentUnsignedShort &&
      componentType != kComponentUnsignedInt)
    throw GltfError(placeName("accessors", accessor, "componentType"), "indices must be unsigned integers");
  const Elements elements = accessorElements(document, accessor, GltfAccessor::Type::scalar, 1);
  const std::size_t size = componentSize(componentType, "");
  std::vector<std::uint32_t> indices(elements.count);
  for (std::size_t i = 0; i < elements.count; ++i) indices[i] = readUnsigned(elements.at(i), size);
  return indices;
}

DracoMesh decodeDraco(const GltfDocument& document, const Json& extension, const std::string& place) {
  constexpr std::size_t kMax = std::numeric_limits<std::int32_t>::max();
  const std::size_t view = wholeIn(extension, "bufferView", place, true, kMax);
  if (view >= document.model.bufferViews.size()) throw GltfError(place + ".bufferView", "is out of range");
  const Json& attributes = extension.member("attributes");
  if (!attributes.isObject()) throw GltfError(place + ".attributes", "is missing");
  const std::size_t positionId = wholeIn(attributes, "POSITION", place + ".attributes", true, kMax);
  const GltfRange range = viewRange(document, view);
  const GltfPiece compressed = range.read(0, range.size);
  const ByteView bytes = compressed.view();
  checkDracoHeader(bytes, place);

  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok())
    throw GltfError(place, std::string("the Draco data cannot be decoded: ") + decoded.status().error_msg());
  const draco::Mesh& mesh = *decoded.value();
  const draco::PointAttribute* position = mesh.GetAttributeByUniqueId(static_cast<std::uint32_t>(positionId));
  if (position == nullptr || position->num_components() != 3)
    throw GltfError(place, "has no positions of three components");

  DracoMesh out;
  if (!readDraco(mesh, *position, out.positions))
    throw GltfError(place, "has a position that cannot be read");
  requireFinite(out.positions, place);
  if (!attributes.member("NORMAL").isAbsent()) {
    const std::size_t normalId = wholeIn(attributes, "NORMAL", place + ".attributes", false, kMax);
    const draco::PointAttribute* normal = mesh.GetAttributeByUniqueId(static_cast<std::uint32_t>(normalId));
    if (normal == nullptr || normal->num_components() != 3 || !readDraco(mesh, *normal, out.normals))
      out.normals.clear();
  }
  out.indices.reserve(std::size_t(mesh.num_faces()) * 3);
  for (std::uint32_t f = 0; f < mesh.num_faces(); ++f)
    for (const draco::PointIndex& corner : mesh.face(draco::FaceIndex(f))) {
      if (corner.value() >= mesh.num_points()) throw GltfError(place, "has an index out of range");
      out.indices.push_back(corner.value());
    }
  return out;
}

}  // namespace tandem::assets
