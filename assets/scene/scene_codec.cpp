#include "assets/scene/scene_codec.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <type_traits>

#include "assets/scene/describe.h"
#include "assets/scene/scene_check.h"

namespace tandem::assets {
namespace {

static_assert(std::endian::native == std::endian::little, "the codec writes numbers as they stand in memory");

/// Thrown by the reader, caught by decodeScene().
struct Truncated {
  const char* reason;
};

constexpr std::size_t kPiece = 1 << 20;  // bytes that are collected before they are passed on
constexpr std::size_t kAhead = 1 << 16;  // bytes that are read at once at least

class Writer {
 public:
  explicit Writer(const ByteSink* sink = nullptr) : sink_(sink) {}

  template <typename T>
  void number(const T& value) {
    static_assert(std::is_standard_layout_v<T> && std::is_trivially_destructible_v<T>);
    raw(&value, sizeof value);
  }
  void flag(const bool& value) { number(static_cast<std::uint8_t>(value)); }
  void text(const std::string& value) {
    number(static_cast<std::uint32_t>(value.size()));
    raw(value.data(), value.size());
  }
  /// Announces an array; `minimum` bytes an element follow at least.
  template <typename T>
  void count(const std::vector<T>& values, std::size_t /*minimum*/) {
    number(static_cast<std::uint32_t>(values.size()));
  }

  std::byte* room(std::size_t size) {
    if (sink_ != nullptr && bytes_.size() >= kPiece) passOn();
    bytes_.resize(bytes_.size() + size);
    return bytes_.data() + bytes_.size() - size;
  }
  std::vector<std::byte> bytes() && { return std::move(bytes_); }
  void passOn() {
    (*sink_)(bytes_);
    bytes_.clear();
  }

 private:
  void raw(const void* data, std::size_t size) {
    if (size > 0) std::memcpy(room(size), data, size);
  }

  const ByteSink* sink_;  // null: all bytes are kept
  std::vector<std::byte> bytes_;
};

class Reader {
 public:
  Reader(std::uint64_t size, const ByteSource& source) : source_(source), left_(size) {}

  template <typename T>
  void number(T& value) {
    static_assert(std::is_standard_layout_v<T> && std::is_trivially_destructible_v<T>);
    std::memcpy(static_cast<void*>(&value), next(sizeof value), sizeof value);
  }
  void flag(bool& value) {
    std::uint8_t byte = 0;
    number(byte);
    if (byte > 1) throw Truncated{"a flag is neither 0 nor 1"};
    value = byte == 1;
  }
  void text(std::string& value) {
    std::uint32_t size = 0;
    number(size);
    const std::byte* data = next(size);
    value.assign(reinterpret_cast<const char*>(data), size);
  }
  template <typename T>
  void count(std::vector<T>& values, std::size_t minimum) {
    std::uint32_t size = 0;
    number(size);
    if (std::uint64_t(size) * minimum > left_)
      throw Truncated{"a count is larger than the bytes that are left"};
    values.resize(size);
  }

  /// The next `size` bytes, which count as read; there until the next call.
  const std::byte* next(std::size_t size) {
    if (size > left_) throw Truncated{"the bytes end too early"};
    if (size > bytes_.size() - at_) fetch(size);
    left_ -= size;
    at_ += size;
    return bytes_.data() + at_ - size;
  }
  bool atEnd() const { return left_ == 0; }

 private:
  void fetch(std::size_t size) {
    bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(at_));
    at_ = 0;
    const std::size_t had = bytes_.size();
    bytes_.resize(std::max<std::size_t>(size, std::min<std::uint64_t>(left_, kAhead)));
    if (!source_(std::span(bytes_).subspan(had))) throw Truncated{"the bytes end too early"};
  }

  const ByteSource& source_;
  std::uint64_t left_;  // not read
  std::vector<std::byte> bytes_;
  std::size_t at_ = 0;  // into bytes_: what is before has been read
};

// --- arrays in planes

/// Signed differences as small unsigned numbers; a bijection of 32 bits.
std::uint32_t zigzag(std::uint32_t d) { return (d << 1) ^ (0u - (d >> 31)); }
std::uint32_t unzigzag(std::uint32_t z) { return (z >> 1) ^ (0u - (z & 1u)); }

template <typename T>
void toPlanes(const T* values, std::size_t count, std::byte* out) {
  for (std::size_t i = 0; i < count; ++i) {
    unsigned char bytes[sizeof(T)];
    std::memcpy(bytes, values + i, sizeof(T));
    for (std::size_t b = 0; b < sizeof(T); ++b) out[b * count + i] = std::byte{bytes[b]};
  }
}

template <typename T>
void fromPlanes(const std::byte* in, std::size_t count, T* values) {
  for (std::size_t i = 0; i < count; ++i) {
    unsigned char bytes[sizeof(T)];
    for (std::size_t b = 0; b < sizeof(T); ++b) bytes[b] = static_cast<unsigned char>(in[b * count + i]);
    std::memcpy(values + i, bytes, sizeof(T));
  }
}

using Triples = std::vector<std::array<std::uint32_t, 3>>;

/// Writes triples as differences: to the corner before (own = false), or to the index of the triple itself
/// (own = true), which suits neighbours, since meshes list near triangles one after the other. The
/// differences wrap, so that kNone needs no case of its own.
void putTriples(Writer& out, const Triples& values, bool own) {
  std::vector<std::uint32_t> differences(values.size() * 3);
  std::uint32_t previous = 0;
  for (std::size_t t = 0; t < values.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      differences[t * 3 + k] = zigzag(values[t][k] - (own ? static_cast<std::uint32_t>(t) : previous));
      previous = values[t][k];
    }
  toPlanes(differences.data(), differences.size(), out.room(differences.size() * 4));
}

void getTriples(Reader& in, Triples& values, std::size_t count, bool own) {
  const std::byte* bytes = in.next(count * 12);
  std::vector<std::uint32_t> differences(count * 3);
  fromPlanes(bytes, differences.size(), differences.data());
  values.resize(count);
  std::uint32_t previous = 0;
  for (std::size_t t = 0; t < count; ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      values[t][k] = unzigzag(differences[t * 3 + k]) + (own ? static_cast<std::uint32_t>(t) : previous);
      previous = values[t][k];
    }
}

bool fitsFloat(const std::vector<glm::dvec3>& positions) {
  for (const glm::dvec3& p : positions)
    for (int i = 0; i < 3; ++i)
      // Compared as bits, so that -0.0 and tiny numbers come back as they were.
      if (std::bit_cast<std::uint64_t>(static_cast<double>(static_cast<float>(p[i]))) !=
          std::bit_cast<std::uint64_t>(p[i]))
        return false;
  return true;
}

template <typename T>
void putPositions(Writer& out, const std::vector<glm::dvec3>& positions) {
  std::vector<T> numbers(positions.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < positions.size(); ++i) numbers[i] = static_cast<T>(positions[i][axis]);
    toPlanes(numbers.data(), numbers.size(), out.room(numbers.size() * sizeof(T)));
  }
}

template <typename T>
void getPositions(Reader& in, std::vector<glm::dvec3>& positions) {
  std::vector<T> numbers(positions.size());
  for (int axis = 0; axis < 3; ++axis) {
    fromPlanes(in.next(numbers.size() * sizeof(T)), numbers.size(), numbers.data());
    for (std::size_t i = 0; i < positions.size(); ++i) positions[i][axis] = static_cast<double>(numbers[i]);
  }
}

// --- one function a type, for both directions: the Writer visits const values, the Reader mutable ones ---

/// The smallest size of an element of a list in bytes: that of a default element, whose texts and lists are
/// empty.
template <typename T, typename Each>
std::size_t leastBytes(const Each& each) {
  Writer writer;
  const T element{};
  each(writer, element);
  return std::move(writer).bytes().size();
}

/// An array of things that are written one by one by each(archive, thing).
template <typename Archive, typename List, typename Each>
void list(Archive& a, List& values, const Each& each) {
  static const std::size_t least = leastBytes<typename std::remove_cvref_t<List>::value_type>(each);
  a.count(values, least);
  for (auto& value : values) each(a, value);
}

/// An array of plain numbers.
template <typename Archive, typename Numbers>
void plainNumbers(Archive& a, Numbers& values) {
  list(a, values, [](auto& archive, auto& value) { archive.number(value); });
}

template <typename Archive, typename Record>
void described(Archive& a, Record& record);

/// Writes or reads the members of a record in the order of its describe().
template <typename Archive>
struct Described {
  Archive& archive;

  void number(const char*, auto& value, const Range&, bool = true) { archive.number(value); }
  void bound(const char*, auto& value, const Range&) { archive.number(value); }
  void vector(const char*, auto& value, const Range&) { archive.number(value); }
  void direction(const char*, auto& value) { archive.number(value); }
  void numbers(const char*, auto& values, const Range&) { plainNumbers(archive, values); }
  void choice(const char*, auto& value, const auto&) { archive.number(value); }
  void flag(const char*, auto& value) { archive.flag(value); }
  void whole(const char*, auto& value) { archive.number(value); }
  void wholes(const char*, auto& values) { plainNumbers(archive, values); }
  void record(const char*, auto& value) { describe(*this, value); }
  void records(const char*, auto& values) {
    list(archive, values, [](auto& a, auto& value) { described(a, value); });
  }
};

template <typename Archive, typename Record>
void described(Archive& a, Record& record) {
  Described<Archive> visitor{a};
  describe(visitor, record);
}

template <typename Archive, typename Pose_>
void pose(Archive& a, Pose_& p) {
  a.number(p.position);
  a.number(p.orientation.w);
  a.number(p.orientation.x);
  a.number(p.orientation.y);
  a.number(p.orientation.z);
}

template <typename Archive, typename Material_>
void material(Archive& a, Material_& m) {
  a.text(m.name);
  a.number(m.baseColour);
  a.number(m.metallic);
  a.number(m.roughness);
  described(a, m);
  a.number(m.surface);
}

void texture(Writer& out, const TextureImage& image) {
  out.number(image.width);
  out.number(image.height);
  out.count(image.texels, 1);
  if (!image.texels.empty())
    std::memcpy(out.room(image.texels.size()), image.texels.data(), image.texels.size());
}

void texture(Reader& in, TextureImage& image) {
  in.number(image.width);
  in.number(image.height);
  in.count(image.texels, 1);
  const std::size_t size = image.texels.size();
  if (size > 0) std::memcpy(image.texels.data(), in.next(size), size);
}

template <typename Archive, typename Shape_>
void shape(Archive& a, Shape_& s) {
  a.number(s.kind);
  pose(a, s.partFromShape);
  described(a, s);
  a.number(s.material);
}

template <typename Archive, typename Part_>
void part(Archive& a, Part_& p) {
  a.text(p.name);
  a.number(p.treeNode);
  a.number(p.mesh);
  list(a, p.shapes, [](auto& archive, auto& s) { shape(archive, s); });
  pose(a, p.worldFromPart);
  a.flag(p.movable);
  a.flag(p.kinematic);
  a.number(p.massProperties.mass);
  a.number(p.massProperties.centreOfMass);
  a.number(p.massProperties.inertia);
  a.number(p.gravityFactor);
  a.number(p.filter.memberOf);
  a.number(p.filter.collidesWith);
  a.number(p.contactTolerance);
}

template <typename Archive, typename Joint_>
void joint(Archive& a, Joint_& j) {
  a.text(j.name);
  a.number(j.partA);
  a.number(j.partB);
  pose(a, j.aFromJoint);
  pose(a, j.bFromJoint);
  described(a, j);
}

template <typename Archive, typename Field_>
void field(Archive& a, Field_& f) {
  a.text(f.name);
  a.number(f.kind);
  a.number(f.part);
  pose(a, f.partFromField);
  described(a, f);
}

template <typename Archive, typename Control_>
void control(Archive& a, Control_& c) {
  a.text(c.name);
  a.number(c.part);
  a.number(c.kind);
  pose(a, c.worldFromAxis);
  pose(a, c.axisFromPart);
  described(a, c);
}

template <typename Archive, typename Mesh_>
void meshHead(Archive& a, Mesh_& m) {
  a.number(m.shellCount);
  a.flag(m.closed);
  a.number(m.volume);
  a.number(m.bounds.min);
  a.number(m.bounds.max);
}

/// Attributes of the corners of all triangles, `Floats` floats a triangle, or none.
template <std::size_t Floats, typename Corners>
void putCorners(Writer& out, const std::vector<Corners>& corners) {
  static_assert(sizeof(Corners) == Floats * sizeof(float));
  out.count(corners, sizeof(Corners));
  const float* numbers = reinterpret_cast<const float*>(corners.data());
  toPlanes(numbers, corners.size() * Floats, out.room(corners.size() * sizeof(Corners)));
}

template <std::size_t Floats, typename Corners>
void getCorners(Reader& in, std::vector<Corners>& corners) {
  in.count(corners, sizeof(Corners));
  float* numbers = reinterpret_cast<float*>(corners.data());
  fromPlanes(in.next(corners.size() * sizeof(Corners)), corners.size() * Floats, numbers);
}

void mesh(Writer& out, const Mesh& mesh) {
  meshHead(out, mesh);
  const bool asFloat = fitsFloat(mesh.positions);
  out.flag(asFloat);
  out.count(mesh.positions, 12);
  if (asFloat)
    putPositions<float>(out, mesh.positions);
  else
    putPositions<double>(out, mesh.positions);
  const std::size_t count = mesh.triangles.size();
  out.count(mesh.triangles, 33);
  putTriples(out, mesh.triangles, false);
  putTriples(out, mesh.neighbours, true);
  std::vector<std::uint32_t> shells(count);
  for (std::size_t t = 0; t < count; ++t)
    shells[t] = zigzag(mesh.triangleShell[t] - (t > 0 ? mesh.triangleShell[t - 1] : 0));
  toPlanes(shells.data(), count, out.room(count * 4));
  toPlanes(mesh.triangleMaterial.data(), count, out.room(count * 2));
  if (count > 0) std::memcpy(out.room(count * 3), mesh.edgeFlags.data(), count * 3);
  putCorners<6>(out, mesh.triangleUv);
  putCorners<9>(out, mesh.triangleNormal);
}

void mesh(Reader& in, Mesh& mesh) {
  meshHead(in, mesh);
  bool asFloat = false;
  in.flag(asFloat);
  in.count(mesh.positions, asFloat ? 12 : 24);
  if (asFloat)
    getPositions<float>(in, mesh.positions);
  else
    getPositions<double>(in, mesh.positions);
  in.count(mesh.triangles, 33);
  const std::size_t count = mesh.triangles.size();
  getTriples(in, mesh.triangles, count, false);
  getTriples(in, mesh.neighbours, count, true);
  mesh.triangleShell.resize(count);
  fromPlanes(in.next(count * 4), count, mesh.triangleShell.data());
  for (std::size_t t = 0; t < count; ++t)
    mesh.triangleShell[t] = unzigzag(mesh.triangleShell[t]) + (t > 0 ? mesh.triangleShell[t - 1] : 0);
  mesh.triangleMaterial.resize(count);
  fromPlanes(in.next(count * 2), count, mesh.triangleMaterial.data());
  mesh.edgeFlags.resize(count);
  const std::byte* flags = in.next(count * 3);
  if (count > 0) std::memcpy(mesh.edgeFlags.data(), flags, count * 3);
  getCorners<6>(in, mesh.triangleUv);
  getCorners<9>(in, mesh.triangleNormal);
}

template <typename Archive, typename Finding_>
void finding(Archive& a, Finding_& f) {
  a.number(f.severity);
  a.text(f.code);
  a.text(f.where);
  a.number(f.count);
  a.text(f.message);
}

template <typename Archive, typename Scene_>
void sceneBody(Archive& a, Scene_& s) {
  a.text(s.name);
  a.number(s.gravity);
  a.number(s.bounds.min);
  a.number(s.bounds.max);
  list(a, s.materials, [](auto& archive, auto& x) { material(archive, x); });
  list(a, s.surfaces, [](auto& archive, auto& x) { described(archive, x); });
  list(a, s.textures, [](auto& archive, auto& x) { texture(archive, x); });
  list(a, s.meshes, [](auto& archive, auto& x) { mesh(archive, x); });
  list(a, s.tree, [](auto& archive, auto& n) {
    archive.text(n.name);
    archive.number(n.parent);
  });
  list(a, s.parts, [](auto& archive, auto& x) { part(archive, x); });
  list(a, s.joints, [](auto& archive, auto& x) { joint(archive, x); });
  list(a, s.fields, [](auto& archive, auto& x) { field(archive, x); });
  list(a, s.controls, [](auto& archive, auto& x) { control(archive, x); });
  list(a, s.findings, [](auto& archive, auto& x) { finding(archive, x); });
}

}  // namespace

std::vector<std::byte> encodeScene(const Scene& scene) {
  Writer writer;
  sceneBody(writer, scene);
  return std::move(writer).bytes();
}

void encodeScene(const Scene& scene, const ByteSink& sink) {
  Writer writer(&sink);
  sceneBody(writer, scene);
  writer.passOn();
}

Result<Scene> decodeScene(std::uint64_t size, const ByteSource& source) {
  Scene scene;
  try {
    Reader reader(size, source);
    sceneBody(reader, scene);
    if (!reader.atEnd()) return Error{"bytes are left over"};
  } catch (const Truncated& e) {
    return Error{e.reason};
  }
  if (Status status = checkScene(scene); !status) return status.error();
  return scene;
}

Result<Scene> decodeScene(std::span<const std::byte> bytes) {
  std::size_t at = 0;
  return decodeScene(bytes.size(), [&](std::span<std::byte> piece) {
    if (piece.size() > bytes.size() - at) return false;
    if (!piece.empty()) std::memcpy(piece.data(), bytes.data() + at, piece.size());
    at += piece.size();
    return true;
  });
}

}  // namespace tandem::assets
