#include "haptics/scene/distance_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <type_traits>

namespace tandem::haptics {
namespace {

constexpr std::array<char, 8> kFieldMark = {'T', 'D', 'F', 'i', 'e', 'l', 'd', '3'};
// Half a unit in the last place of a point and of the result, and the rounding already in the caller's point.
constexpr float kReadRounding = 0x1p-22f;
/// Larger grids along an axis would be useless and exceed float indices.
constexpr std::uint32_t kMaxAlong = 1u << 14;

template <typename T>
void put(std::vector<std::byte>& bytes, const T* values, std::size_t count) {
  static_assert(std::is_standard_layout_v<T> && std::is_trivially_destructible_v<T>);
  const std::size_t at = bytes.size();
  bytes.resize(at + count * sizeof(T));
  if (count > 0) std::memcpy(bytes.data() + at, values, count * sizeof(T));
}

/// Reads values from the front of `bytes`; false, with nothing read, if there are too few.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <typename T>
  bool read(T* values, std::size_t count) {
    static_assert(std::is_standard_layout_v<T> && std::is_trivially_destructible_v<T>);
    if (count > bytes_.size() / sizeof(T)) return false;
    if (count > 0) std::memcpy(static_cast<void*>(values), bytes_.data(), count * sizeof(T));
    bytes_ = bytes_.subspan(count * sizeof(T));
    return true;
  }
  template <typename T>
  bool readAll(std::vector<T>& values, std::uint64_t count) {
    if (count > bytes_.size() / sizeof(T)) return false;
    values.resize(static_cast<std::size_t>(count));
    return read(values.data(), values.size());
  }
  bool atEnd() const { return bytes_.empty(); }

 private:
  std::span<const std::byte> bytes_;
};

bool isFinite(const glm::vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

}  // namespace

DistanceField::DistanceField(std::span<const assets::ImplicitShape> shapes, const assets::Mesh& mesh,
                             double tolerance)
    : shapes_(primitivesOf(shapes, mesh)), tolerance_(tolerance) {
  origin_ = 0.5 * (mesh.bounds.min + mesh.bounds.max);
  boxLow_ = glm::vec3(mesh.bounds.min - origin_);
  boxHigh_ = glm::vec3(mesh.bounds.max - origin_);
  // The tolerance that contact compares errors with; no error of exact shapes comes near it.
  smallestCell_ = band_ = tolerance;
  // Computes the rows of a step, whose distances need doubles.
  worstSmoothError_ = 0x1p-50 * glm::length(glm::max(glm::abs(mesh.bounds.min), glm::abs(mesh.bounds.max)));
  for (const Primitive& shape : shapes_) solid_ = solid_ || shape.solid();
}

DistanceField::Reading DistanceField::ofShapes(const glm::vec3& p) const {
  const glm::dvec3 at = glm::dvec3(p) + origin_;
  SurfaceDistance least = shapes_.front().at(at);
  for (std::size_t i = 1; i < shapes_.size(); ++i) {
    const SurfaceDistance other = shapes_[i].at(at);
    if (other.distance < least.distance) least = other;
  }
  const float largest = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  const auto distance = static_cast<float>(least.distance);
  return {distance, kReadRounding * (largest + std::abs(distance)), glm::vec3(least.gradient)};
}

void DistanceField::ofShapes(const glm::vec3* points, std::uint32_t count, Reading* readings) const {
  for (std::uint32_t k = 0; k < count; ++k) readings[k] = ofShapes(points[k]);
}

std::size_t DistanceField::memory() const {
  return sizeof *this + shapes_.size() * sizeof(Primitive) +
         (top_.size() + blocks_.size() + listAt_.size() + lists_.size()) * sizeof(std::uint32_t) +
         cells_.size() * sizeof(Cell);
}

DistanceField::Reading DistanceField::beyond(const glm::vec3& p) const {
  const glm::vec3 off = p - glm::clamp(p, boxLow_, boxHigh_);
  const float length = glm::length(off);
  if (!(length > 0.0f)) return {0.0f, 0.0f, glm::vec3(0.0f)};
  // The box is rounded outwards; the factor covers the rounding of the length.
  return {length * (1.0f - 0x1p-20f), 0.0f, off / length};
}

std::vector<std::byte> DistanceField::pack() const {
  std::vector<std::byte> bytes;
  put(bytes, kFieldMark.data(), kFieldMark.size());
  put(bytes, &low_, 1);
  put(bytes, &perCell_, 1);
  put(bytes, count_, 3);
  put(bytes, &boxLow_, 1);
  put(bytes, &boxHigh_, 1);
  put(bytes, &origin_, 1);
  const std::array<double, 4> lengths = {tolerance_, smallestCell_, band_, worstSmoothError_};
  put(bytes, lengths.data(), lengths.size());
  const std::uint32_t flags = (solid_ ? 1u : 0u) | (coarsened_ ? 2u : 0u);
  put(bytes, &flags, 1);
  const std::array<std::uint64_t, 4> counts = {blocks_.size() / kBlock, cells_.size(), listAt_.size(),
                                               lists_.size()};
  put(bytes, counts.data(), counts.size());
  put(bytes, top_.data(), top_.size());
  put(bytes, blocks_.data(), blocks_.size());
  put(bytes, cells_.data(), cells_.size());
  put(bytes, listAt_.data(), listAt_.size());
  put(bytes, lists_.data(), lists_.size());
  return bytes;
}

Result<DistanceField> DistanceField::unpack(std::span<const std::byte> bytes, std::size_t triangles) {
  const auto refused = [](const char* why) { return Error{std::string("distance field: ") + why}; };
  Reader in(bytes);
  DistanceField field;
  std::array<char, 8> mark{};
  std::array<double, 4> lengths{};
  std::uint32_t flags = 0;
  std::array<std::uint64_t, 4> counts{};
  if (!in.read(mark.data(), mark.size()) || mark != kFieldMark) return refused("not one of this version");
  if (!in.read(&field.low_, 1) || !in.read(&field.perCell_, 1) || !in.read(field.count_, 3) ||
      !in.read(&field.boxLow_, 1) || !in.read(&field.boxHigh_, 1) || !in.read(&field.origin_, 1) ||
      !in.read(lengths.data(), lengths.size()) || !in.read(&flags, 1) ||
      !in.read(counts.data(), counts.size()))
    return refused("the bytes end too early");
  if (!isFinite(field.low_) || !isFinite(field.boxLow_) || !isFinite(field.boxHigh_) ||
      !(field.perCell_ > 0.0f) || !std::isfinite(field.perCell_) || !isFinite(glm::vec3(field.origin_)))
    return refused("a length is not finite");
  for (int axis = 0; axis < 3; ++axis)
    if (field.boxLow_[axis] > field.boxHigh_[axis]) return refused("the box is inside out");
  for (const double length : lengths)
    if (!(length >= 0.0) || !std::isfinite(length)) return refused("a length is not finite");
  std::uint64_t cubes = 1;
  for (int axis = 0; axis < 3; ++axis) {
    if (field.count_[axis] > kMaxAlong) return refused("the grid is too large");
    cubes *= field.count_[axis];
    field.size_[axis] = static_cast<float>(field.count_[axis] * kSpan);
  }
  if (flags > 3 || std::any_of(counts.begin(), counts.end(), [&](auto n) { return n > bytes.size(); }))
    return refused("a count is out of range");
  if (!in.readAll(field.top_, cubes) || !in.readAll(field.blocks_, counts[0] * kBlock) ||
      !in.readAll(field.cells_, counts[1]) || !in.readAll(field.listAt_, counts[2]) ||
      !in.readAll(field.lists_, counts[3]) || !in.atEnd())
    return refused("the bytes do not hold what they announce");
  field.solid_ = (flags & 1) != 0;
  field.coarsened_ = (flags & 2) != 0;
  field.tolerance_ = lengths[0];
  field.smallestCell_ = lengths[1];
  field.band_ = lengths[2];
  field.worstSmoothError_ = lengths[3];
  if (!field.entriesAreSound()) return refused("an entry leads nowhere");
  if (!field.listsAreSound(triangles)) return refused("a list of triangles is not one of this mesh");
  for (const Cell& cell : field.cells_)
    if (!isFinite(cell.gradient) || !std::isfinite(cell.offset) || !(cell.error >= 0.0f) ||
        !std::isfinite(cell.error))
      return refused("a cell is not finite");
  return field;
}

bool DistanceField::entriesAreSound() const {
  const std::size_t blockCount = blocks_.size() / kBlock;
  // Level 1 is a block of the grid's cubes; level 2 is a block within one, which has no blocks of its own.
  std::vector<std::uint8_t> level(blockCount, 0);
  const auto check = [&](std::uint32_t entry, std::uint8_t below) {
    if ((entry & kLeaf) != 0) return (entry & ~kLeaf) < cells_.size();
    if (entry >= blockCount || below > 2 || (level[entry] != 0 && level[entry] != below)) return false;
    level[entry] = below;
    return true;
  };
  for (const std::uint32_t entry : top_)
    if (!check(entry, 1)) return false;
  for (std::uint8_t pass = 1; pass <= 2; ++pass) {
    for (std::size_t block = 0; block < blockCount; ++block) {
      if (level[block] != pass) continue;
      for (std::size_t i = 0; i < kBlock; ++i)
        if (!check(blocks_[block * kBlock + i], static_cast<std::uint8_t>(pass + 1))) return false;
    }
  }
  return std::find(level.begin(), level.end(), 0) == level.end();
}

bool DistanceField::listsAreSound(std::size_t triangles) const {
  std::vector<bool> begins(lists_.size(), false);
  for (std::size_t at = 0; at < lists_.size(); at += 1 + std::size_t{lists_[at]}) {
    if (lists_[at] > kMaxListed || lists_[at] >= lists_.size() - at) return false;
    begins[at] = true;
    for (std::size_t k = 1; k <= lists_[at]; ++k)
      if (lists_[at + k] >= triangles) return false;
  }
  if (listAt_.size() > cells_.size()) return false;
  return std::all_of(listAt_.begin(), listAt_.end(),
                     [&](std::uint32_t at) { return at < begins.size() && begins[at]; });
}

}  // namespace tandem::haptics
