#pragma once

// Signed distance field of one mesh: a few loads return the distance to the surface and a bound of its error.
//
// 1. Cubes form a hierarchy of fixed branching: a grid of large cubes, which may hold 8 x 8 x 8 blocks, which
//    may hold blocks again. Each undivided cube has an affine model of the distance and a proven bound of its
//    error (cube_fit.h).
// 2. Immutable after construction and safe in every thread. Afterwards it needs neither the tree nor the
//    mesh. Cells beside edges, whose models are not exact, list the triangles that can be nearest there.
// 3. The result does not depend on the number of threads.
// 4. A part of implicit shapes needs no cells: a formula gives its distance everywhere.

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "assets/base/result.h"
#include "haptics/geometry/primitive_distance.h"

namespace tandem::haptics {

class TriangleBvh;

class DistanceField {
 public:
  static constexpr double kCellOfTolerance =
      80.0;  // tolerances that the smallest cell has, if it is not given

  struct Options {
    double tolerance = 0.0;  // m, wanted error where the surface is smooth; 0 = 2^-14 of the part's diagonal
    double smallestCell = 0.0;  // m, side; 0 = 80 tolerances, within 1/1024 and 1/128 of the diagonal
    double band = 0.0;          // m, around the surface where the tolerance matters; 0 = two smallest cells
    std::size_t memory = 64u << 20;  // bytes; smallestCell is doubled until the field fits
    bool onlyCulls = false;  // cells say how near the surface may be, and have no model of it: far less work
    int threads = 0;         // 0 = all cores
    std::function<void(double)> progress;     // share done, from the calling thread
    const std::atomic<bool>* stop = nullptr;  // once true, the bake ends early, and the field is of no use
  };

  /// |signed distance(p) - distance| <= error within the grid. The gradient is that of the cell's model: not
  /// normalised, and zero where the cell only culls.
  struct Reading {
    float distance;  // m, negative inside
    float error;     // m
    glm::vec3 gradient;
  };

  static constexpr std::size_t kMaxListed = 24;
  /// Triangles of the mesh, ascending, at most kMaxListed.
  using Triangles = std::span<const std::uint32_t>;

  /// Bakes the field. MeshSides defines the inside of a mesh with defects. The tree is not kept.
  DistanceField(const TriangleBvh& tree, const Options& options);

  /// Field of implicit shapes, exact but for rounding, everywhere: nothing is baked. Outside it is the
  /// distance to the nearest shape, and inside a single shape the depth in it. Where shapes overlap it is the
  /// depth in the shape that holds p deepest, a lower bound of the depth in their union. `tolerance` (m) is
  /// the part's tolerance in contact steps.
  DistanceField(std::span<const assets::ImplicitShape> shapes, const assets::Mesh& mesh, double tolerance);

  /// Reads the field at p, in m relative to origin(), part axes. Outside the grid the distance is a lower
  /// bound, with an error of 0 that means "at least". The result for a non-finite point is arbitrary. For
  /// ticks.
  Reading read(const glm::vec3& p) const {
    Triangles near;
    return read(p, near);
  }

  /// The same, and in `near` the triangles of which one is nearest to p; empty where they are not listed.
  Reading read(const glm::vec3& p, Triangles& near) const {
    near = {};
    if (!shapes_.empty()) return ofShapes(p);
    const std::uint32_t* const entry = entryOf(p);
    if (entry == nullptr) return beyond(p);
    const std::uint32_t cell = *entry & ~kLeaf;
    near = listOf(cell);
    return readingAt(cells_[cell], p);
  }

  static constexpr std::uint32_t kMaxAtOnce = 16;
  class Places;
  /// read() for up to kMaxAtOnce points, whose memory latencies overlap; latency is most of the cost of a
  /// reading.
  void read(const glm::vec3* points, std::uint32_t count, Reading* readings) const;

  // The same in three parts, between which the caller does other work while memory answers.

  void seek(const glm::vec3* points, std::uint32_t count, Places& places) const;
  void fetch(std::uint32_t count, Places& places) const;
  void read(const glm::vec3* points, std::uint32_t count, const Places& places, Reading* readings) const;

  glm::dvec3 origin() const { return origin_; }
  /// The shapes of an exact field, part frame; empty for a mesh.
  std::span<const Primitive> shapes() const { return shapes_; }
  /// Whether there is an inside. Otherwise the distance is nowhere negative.
  bool solid() const { return solid_; }
  std::size_t memory() const;
  std::size_t cells() const { return cells_.size(); }
  double tolerance() const { return tolerance_; }
  double smallestCell() const { return smallestCell_; }
  double band() const { return band_; }
  /// Whether the bake was stopped: the field cannot be read then.
  bool stopped() const { return stopped_; }
  /// Whether the memory allowed made the smallest cell larger than asked for.
  bool coarsened() const { return coarsened_; }
  /// The largest error, m, of a cell that the surface passes and where it turns by less than 20 degrees.
  /// Above tolerance() where the smallest cell is too large for a curve.
  double worstSmoothError() const { return worstSmoothError_; }

  /// Serialises the field for a cache, for machines of this byte order.
  std::vector<std::byte> pack() const;
  /// Reads a field of a mesh of so many triangles from untrusted `bytes`. Inconsistent data is refused, and
  /// read() of an accepted field is safe.
  static Result<DistanceField> unpack(std::span<const std::byte> bytes, std::size_t triangles);

 private:
  friend class FieldBake;

  static constexpr std::uint32_t kLeaf =
      0x80000000u;  // an entry's other bits are a cell's index, else a block's
  static constexpr std::uint32_t kBlock = 512;
  static constexpr std::uint32_t kSpan = 64;  // smallest cells along a cube of the grid

  /// distance(p) = dot(gradient, p) + offset, taken about the origin so that the level is irrelevant. `error`
  /// includes the float rounding of that.
  struct Cell {
    glm::vec3 gradient;
    float offset;  // m
    float error;   // m
  };

  DistanceField() = default;
  static std::uint32_t inBlock(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    return (z & 7u) << 6 | (y & 7u) << 3 | (x & 7u);
  }
  /// The entry of the cell that contains a point, not read yet; null outside the grid.
  const std::uint32_t* entryOf(const glm::vec3& p) const {
    const float x = (p.x - low_.x) * perCell_, y = (p.y - low_.y) * perCell_, z = (p.z - low_.z) * perCell_;
    if (!(x >= 0.0f && y >= 0.0f && z >= 0.0f && x < size_.x && y < size_.y && z < size_.z)) return nullptr;
    const auto ix = static_cast<std::uint32_t>(x), iy = static_cast<std::uint32_t>(y),
               iz = static_cast<std::uint32_t>(z);
    const std::uint32_t* const top = &top_[((iz >> 6) * count_[1] + (iy >> 6)) * count_[0] + (ix >> 6)];
    if ((*top & kLeaf) != 0) return top;
    const std::uint32_t* const middle = &blocks_[*top * kBlock + inBlock(ix >> 3, iy >> 3, iz >> 3)];
    return (*middle & kLeaf) != 0 ? middle : &blocks_[*middle * kBlock + inBlock(ix, iy, iz)];
  }
  static Reading readingAt(const Cell& cell, const glm::vec3& p) {
    return {glm::dot(cell.gradient, p) + cell.offset, cell.error, cell.gradient};
  }
  Triangles listOf(std::uint32_t cell) const {
    if (cell >= listAt_.size()) return {};
    const std::uint32_t* const list = &lists_[listAt_[cell]];
    return {list + 1, *list};
  }
  Reading beyond(const glm::vec3& p) const;
  Reading ofShapes(const glm::vec3& p) const;
  void ofShapes(const glm::vec3* points, std::uint32_t count, Reading* readings) const;
  bool entriesAreSound() const;
  bool listsAreSound(std::size_t triangles) const;

  glm::vec3 low_{0.0f, 0.0f, 0.0f};     // m, corner of the grid relative to the origin
  float perCell_ = 0.0f;                // 1 / m
  glm::vec3 size_{0.0f, 0.0f, 0.0f};    // smallest cells along each axis
  std::uint32_t count_[3] = {0, 0, 0};  // cubes of the grid along each axis
  std::vector<Primitive> shapes_;
  std::vector<std::uint32_t> top_;
  std::vector<std::uint32_t> blocks_;  // kBlock entries each
  std::vector<Cell> cells_;
  // lists_ holds lists of triangles, each as its count and then its indices. Cells that have a list come
  // first in cells_: listAt_ holds, for each of these, where in lists_ its list begins. Cells may share one.
  std::vector<std::uint32_t> listAt_, lists_;
  glm::vec3 boxLow_{0.0f, 0.0f, 0.0f}, boxHigh_{0.0f, 0.0f, 0.0f};  // m, of the mesh, relative to the origin
  glm::dvec3 origin_{0.0, 0.0, 0.0};                                // m, part frame
  double tolerance_ = 0.0, smallestCell_ = 0.0, band_ = 0.0, worstSmoothError_ = 0.0;  // m
  bool solid_ = false, coarsened_ = false, stopped_ = false;
};

}  // namespace tandem::haptics

#include "haptics/scene/distance_field_places.h"
