// Bakes a distance field: cubes of a grid in parallel, each divided into eighths until the model of a cube is
// good enough. The triangles of a cube are those of its parent that can still be nearest.

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <thread>
#include <unordered_map>
#include <utility>

#include <glm/common.hpp>

#include "assets/base/assert.h"
#include "haptics/base/fixed_vector.h"
#include "haptics/base/in_parallel.h"
#include "haptics/geometry/mesh_sides.h"
#include "haptics/geometry/outward.h"
#include "haptics/geometry/slit_caps.h"
#include "haptics/geometry/triangle_bvh.h"
#include "haptics/scene/cube_fit.h"
#include "haptics/scene/distance_field.h"

namespace tandem::haptics {
namespace {

constexpr double kTolerance = 0x1p-14;                            // of the diagonal
constexpr double kSmallestCell = 0x1p-10, kLargestCell = 0x1p-7;  // smallest cell, of the diagonal
constexpr double kBandCells = 2.0;
/// Sufficient error as a fraction of the distance within the band, and of the excess beyond it.
constexpr double kNearShare = 1.0 / 8.0;
constexpr double kFarShare = 0.25;
/// Fraction of the grid's diagonal that bounds the rounding of readings: the index of the cell, and the sum
/// about the origin, each some units in the last place of a float.
constexpr double kRounding = 0x1p-20;
constexpr std::size_t kMaxCubes = std::size_t{1} << 18;
constexpr double kSmoothTurn = 0.94;  // cosine of 20 degrees
/// More triangles than this are queried through the tree.
constexpr std::size_t kMany = 48;
constexpr int kLevels = 7;  // sides of 64, 32 .. 1 smallest cells

/// Slits up to this fraction of the diagonal are closed before baking.
constexpr double kWidestSlit = 0x1p-14;
/// Error of a cap of width 1: the cap does not exist, and the side may change behind it.
constexpr double kErrorOfWidth = 4.0;
/// A cube of two smallest cells is not divided where the surface is further away than this many of its radii.
constexpr double kAlone = 3.0;
/// A model this many times worse than allowed may still become good enough along the mean of the faces'
/// normals.
constexpr double kSecondTry = 4.0;

/// Triangles are listed where contact asks for them: at an error of more tolerances than this.
constexpr double kListedError = 2.0;
/// A bit of an entry, until the pieces are joined: the index is one of Piece::listed, not of Piece::cells.
constexpr std::uint32_t kListed = 0x40000000u;
/// Of more triangles than this too many would be left.
constexpr std::size_t kWorthListing = 128;

/// Balls about the triangles, m relative to the origin: a first bound of a triangle's distance.
struct Ball {
  glm::vec3 centre;
  float radius;
  glm::vec3 normal;  // of the triangle's plane, not longer than 1
};

int threadsOf(const DistanceField::Options& options) {
  return options.threads > 0 ? options.threads
                             : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

/// A mesh with caps over its slits, and its tree.
struct CappedMesh {
  assets::Mesh mesh;
  std::unique_ptr<TriangleBvh> tree;
  std::size_t firstCap = 0;
  std::vector<double> error;  // m, of each triangle; empty if there are no caps

  CappedMesh(const TriangleBvh& bare, int threads) {
    const assets::Mesh& given = bare.mesh();
    const SlitCaps caps = capSlits(given, kWidestSlit * glm::distance(bare.bounds().min, bare.bounds().max));
    firstCap = given.triangles.size();
    if (caps.triangles.empty()) return;
    mesh.positions = given.positions;
    mesh.triangles = given.triangles;
    mesh.triangles.insert(mesh.triangles.end(), caps.triangles.begin(), caps.triangles.end());
    mesh.triangleMaterial.assign(mesh.triangles.size(), 0);
    mesh.bounds = given.bounds;
    tree = std::make_unique<TriangleBvh>(mesh, threads);
    error.assign(firstCap, 0.0);
    for (const double width : caps.width) error.push_back(kErrorOfWidth * width);
  }
};

}  // namespace

class FieldBake {
 public:
  FieldBake(const TriangleBvh& tree, const DistanceField::Options& options, DistanceField& field)
      : capped_(tree, options.threads),
        tree_(capped_.tree != nullptr ? *capped_.tree : tree),
        options_(options),
        field_(field),
        sides_(tree_, capped_.firstCap, threadsOf(options)),
        fit_(tree_, sides_) {}

  void run();

 private:
  /// The result of one cube of the grid, with indices of its own.
  struct Piece {
    std::uint32_t root = 0;
    std::vector<std::uint32_t> blocks;
    std::vector<DistanceField::Cell> cells, listed;  // without and with a list of triangles
    std::vector<std::uint32_t> listAt, lists;        // as in a DistanceField
    double worstSmooth = 0.0;

    std::size_t memory() const {
      return (blocks.size() + listAt.size() + lists.size()) * sizeof(std::uint32_t) +
             (cells.size() + listed.size()) * sizeof(DistanceField::Cell) + sizeof(std::uint32_t);
    }
  };
  /// A cube of the recursion.
  struct Job {
    FieldCube cube;
    std::array<std::uint32_t, 3> at;  // smallest cells from the corner of the grid's cube
    std::uint32_t side;               // smallest cells
    int level;
  };
  /// State inherited from the parent cube.
  struct Known {
    glm::dvec3 centre{0.0, 0.0, 0.0};
    double distance = -1.0;
    MeshSides::Side side{1.0, false};
    glm::dvec3 point{0.0, 0.0, 0.0};  // of the surface, at that distance
  };
  using Lists = std::array<std::vector<std::uint32_t>, kLevels>;
  struct Worker {
    Lists near;
    std::vector<std::pair<std::uint32_t, double>> measured;  // scratch: triangles and distances
    std::vector<std::uint32_t> listed;                       // scratch, of one cube
    std::vector<std::uint32_t> shared;                       // the same, of eight smallest cells
    bool sharedIsKnown = false;
    std::unordered_map<std::uint64_t, std::uint32_t> known;  // lists of the present piece, by their hash
  };

  void setLengths();
  void setGrid();
  bool isStopped() const {
    return options_.stop != nullptr && options_.stop->load(std::memory_order_relaxed);
  }
  bool bakePieces(std::vector<Piece>& pieces);
  void join(std::vector<Piece>& pieces);
  void bakePiece(std::size_t index, Worker& worker, Piece& piece) const;
  void refine(const Job& job, std::span<const std::uint32_t> candidates, const Known& around, Worker& worker,
              Piece& piece) const;
  /// The nearest point to a cube's centre. `bound`: m, it is no further away, if anything is known.
  MeshPoint nearestByTree(const FieldCube& cube, const Known& around, double bound) const;
  /// The nearest point to a cube's centre, and all triangles (and few more) within two radii beyond it.
  MeshPoint nearestOf(const FieldCube& cube, std::span<const std::uint32_t> candidates, const Known& around,
                      Worker& worker, std::vector<std::uint32_t>& near) const;
  MeshSides::Side sideOf(const FieldCube& cube, const MeshPoint& nearest, const Known& around) const;
  /// Error that the caps of slits near a cube may cause, m.
  double errorOfCaps(std::span<const std::uint32_t> near) const;
  /// Sets worker.listed to the triangles that can be nearest to a point of the cube, or to none if there are
  /// more than kMaxListed. `near` holds every triangle that is at most two radii of the cube farther from its
  /// centre than the nearest one.
  void listNearest(const FieldCube& cube, std::span<const std::uint32_t> near, Worker& worker) const;
  /// Where worker.listed stands among the lists of the piece, to which it is added if it is new.
  static std::uint32_t placeOfList(Worker& worker, Piece& piece);
  /// Adds a cell with the list of triangles in worker.listed.
  void store(const Job& job, const CubeModel& model, Worker& worker, Piece& piece) const;
  /// Whether the surface turns by less than 20 degrees in and around a cube.
  bool isSmooth(const FieldCube& cube, std::span<const std::uint32_t> near, const MeshPoint& nearest) const;
  double allowed(double distance, double radius) const {
    const double least = std::max(0.0, distance - radius);
    return std::max(field_.tolerance_ - rounding_, 0.5 * field_.tolerance_) +
           kNearShare * std::min(least, field_.band_) + kFarShare * std::max(0.0, least - field_.band_);
  }

  CappedMesh capped_;
  const TriangleBvh& tree_;
  const DistanceField::Options& options_;
  DistanceField& field_;
  MeshSides sides_;
  CubeFit fit_;
  std::vector<Ball> balls_;
  double largestCapError_ = 0.0;  // m
  double rounding_ = 0.0;         // m
  bool unlimited_ = false;
};

DistanceField::DistanceField(const TriangleBvh& tree, const Options& options) {
  if (tree.empty()) {
    // Without any triangle the distance is the largest float.
    boxLow_ = boxHigh_ = glm::vec3(std::numeric_limits<float>::max());
    return;
  }
  FieldBake(tree, options, *this).run();
  ASSERT(!(tolerance_ < 0.0) && !(smallestCell_ < 0.0));
}

void FieldBake::run() {
  // What comes in through a mouth meets no surface there, and feels the walls from inside.
  if (sides_.hasMouth()) sides_.forgetInside();
  setLengths();
  field_.solid_ = sides_.solid();
  for (const double error : capped_.error) largestCapError_ = std::max(largestCapError_, error);
  balls_.resize(tree_.mesh().triangles.size());
  for (std::uint32_t t = 0; t < balls_.size(); ++t) {
    const Triangle corners = tree_.triangle(t);
    const glm::vec3 centre((corners.a + corners.b + corners.c) / 3.0 - field_.origin_);
    double radius = 0.0;
    for (const glm::dvec3& corner : {corners.a, corners.b, corners.c})
      radius = std::max(radius, glm::distance(glm::dvec3(centre), corner - field_.origin_));
    const glm::dvec3 normal = areaVector(corners);
    const double area = glm::length(normal);
    balls_[t] = {centre, roundUp(radius), glm::vec3(area > 0.0 ? normal * ((1.0 - 0x1p-20) / area) : normal)};
  }
  std::vector<Piece> pieces;
  for (;;) {
    setGrid();
    const bool fits = bakePieces(pieces);
    if (isStopped()) {
      field_.stopped_ = true;
      return;
    }
    if (fits) break;
    // A field of so few cells cannot shrink further.
    if (16.0 * field_.smallestCell_ > glm::length(tree_.bounds().max - tree_.bounds().min)) unlimited_ = true;
    field_.smallestCell_ *= 2.0;
    field_.coarsened_ = true;
  }
  join(pieces);
}

void FieldBake::setLengths() {
  const assets::Bounds& box = tree_.bounds();
  const double diagonal = glm::distance(box.min, box.max);
  field_.origin_ = 0.5 * (box.min + box.max);
  for (int axis = 0; axis < 3; ++axis) {
    field_.boxLow_[axis] = roundDown(box.min[axis] - field_.origin_[axis]);
    field_.boxHigh_[axis] = roundUp(box.max[axis] - field_.origin_[axis]);
  }
  const auto orElse = [](double given, double derived) { return given > 0.0 ? given : derived; };
  field_.tolerance_ = orElse(options_.tolerance, kTolerance * diagonal);
  field_.smallestCell_ =
      orElse(options_.smallestCell, std::clamp(DistanceField::kCellOfTolerance * field_.tolerance_,
                                               kSmallestCell * diagonal, kLargestCell * diagonal));
  field_.smallestCell_ = std::max(field_.smallestCell_, 0x1p-16 * diagonal);
  field_.band_ = orElse(options_.band, kBandCells * field_.smallestCell_);
}

void FieldBake::setGrid() {
  const assets::Bounds& box = tree_.bounds();
  std::size_t cubes = 0;
  for (;; field_.smallestCell_ *= 2.0) {
    // Rounded to float, so that cells are where read() looks for them.
    field_.smallestCell_ = static_cast<float>(field_.smallestCell_);
    const double side = DistanceField::kSpan * field_.smallestCell_;
    const double margin = field_.band_ + 2.0 * field_.smallestCell_;
    cubes = 1;
    for (int axis = 0; axis < 3; ++axis) {
      field_.count_[axis] =
          static_cast<std::uint32_t>(std::ceil((box.max[axis] - box.min[axis] + 2.0 * margin) / side));
      field_.size_[axis] = static_cast<float>(field_.count_[axis] * DistanceField::kSpan);
      field_.low_[axis] = static_cast<float>(-0.5 * side * field_.count_[axis]);
      cubes *= field_.count_[axis];
    }
    if (cubes <= kMaxCubes) break;
    field_.coarsened_ = true;
  }
  field_.perCell_ = static_cast<float>(1.0 / field_.smallestCell_);
  rounding_ = kRounding * field_.smallestCell_ * glm::length(glm::dvec3(field_.size_));
  field_.top_.assign(cubes, 0);
}

bool FieldBake::bakePieces(std::vector<Piece>& pieces) {
  pieces.assign(field_.top_.size(), {});
  const std::size_t limit = unlimited_ ? std::numeric_limits<std::size_t>::max() : options_.memory;
  std::atomic<std::size_t> next{0}, memory{0};
  onThreads(threadsOf(options_), [&](int number) {
    Worker worker;
    for (;;) {
      const std::size_t index = next.fetch_add(1);
      // The sum of all cubes decides, in any order: past the limit it stays past it.
      if (index >= pieces.size() || memory.load() > limit || isStopped()) break;
      Piece& piece = pieces[index];
      worker.known.clear();
      bakePiece(index, worker, piece);
      for (auto* cells : {&piece.cells, &piece.listed}) cells->shrink_to_fit();
      for (auto* numbers : {&piece.blocks, &piece.listAt, &piece.lists}) numbers->shrink_to_fit();
      memory.fetch_add(piece.memory());
      if (number == 0 && options_.progress)
        options_.progress(static_cast<double>(index) / static_cast<double>(pieces.size()));
    }
  });
  return memory.load() <= limit;
}

void FieldBake::bakePiece(std::size_t index, Worker& worker, Piece& piece) const {
  const std::size_t nx = field_.count_[0], ny = field_.count_[1];
  const glm::dvec3 place(static_cast<double>(index % nx), static_cast<double>(index / nx % ny),
                         static_cast<double>(index / nx / ny));
  const double side = DistanceField::kSpan * field_.smallestCell_;
  Job job{{field_.origin_ + glm::dvec3(field_.low_) + side * (place + 0.5), 0.5 * side},
          {0, 0, 0},
          DistanceField::kSpan,
          0};
  if (options_.onlyCulls) {
    refine(job, {}, {}, worker, piece);
    return;
  }
  MeshPoint nearest;
  tree_.closestPoint(job.cube.centre, 1e300, nearest);
  const double reach = nearest.distance + 2.0 * job.cube.radius();
  const assets::Bounds box{job.cube.centre - reach, job.cube.centre + reach};
  std::vector<std::uint32_t> candidates(tree_.gather(box, {}));
  tree_.gather(box, candidates);
  std::sort(candidates.begin(), candidates.end());
  refine(job, candidates, {}, worker, piece);
}

MeshPoint FieldBake::nearestByTree(const FieldCube& cube, const Known& around, double bound) const {
  MeshPoint nearest;
  tree_.closestPoint(cube.centre, around.distance >= 0.0 ? bound + rounding_ : 1e300, nearest);
  return nearest;
}

MeshPoint FieldBake::nearestOf(const FieldCube& cube, std::span<const std::uint32_t> candidates,
                               const Known& around, Worker& worker, std::vector<std::uint32_t>& near) const {
  const glm::vec3 centre(cube.centre - field_.origin_);
  // Rounding may take a reading just beyond the cube.
  const double within = 2.0 * (cube.radius() + rounding_);
  const auto isFar = [&](std::uint32_t t, float reach) {
    const Ball& ball = balls_[t];
    const glm::vec3 off = centre - ball.centre;
    const float beyond = reach + ball.radius;
    return glm::dot(off, off) > beyond * beyond || std::abs(glm::dot(off, ball.normal)) > reach;
  };
  MeshPoint nearest;
  near.clear();
  if (candidates.size() > kMany) {
    nearest = nearestByTree(cube, around, around.distance + glm::distance(around.centre, cube.centre));
    const float reach = roundUp(nearest.distance + within + rounding_);
    for (const std::uint32_t t : candidates)
      if (!isFar(t, reach)) near.push_back(t);
    return nearest;
  }
  nearest.distance = 1e300;
  float reach = 1e38f;
  worker.measured.clear();
  for (const std::uint32_t t : candidates) {
    if (isFar(t, reach)) continue;
    const TrianglePoint closest = closestPointOnTriangle(cube.centre, tree_.triangle(t));
    const double distance = glm::distance(cube.centre, closest.point);
    worker.measured.emplace_back(t, distance);
    if (distance >= nearest.distance) continue;
    nearest = {distance, t, closest.point, closest.onFace};
    reach = roundUp(distance + within + rounding_);
  }
  for (const auto& [t, distance] : worker.measured)
    if (distance <= nearest.distance + within) near.push_back(t);
  return nearest;
}

MeshSides::Side FieldBake::sideOf(const FieldCube& cube, const MeshPoint& nearest,
                                  const Known& around) const {
  // No surface lies between this centre and that of the parent cube.
  const double displacement = glm::distance(around.centre, cube.centre);
  if (around.side.certain && std::max(around.distance, nearest.distance) > displacement) return around.side;
  return sides_.sideOf(cube.centre, nearest, cube.radius());
}

void FieldBake::refine(const Job& job, std::span<const std::uint32_t> candidates, const Known& around,
                       Worker& worker, Piece& piece) const {
  if (isStopped()) return;
  std::vector<std::uint32_t>& near = worker.near[static_cast<std::size_t>(job.level)];
  const double radius = job.cube.radius();
  MeshPoint nearest;
  if (options_.onlyCulls)
    nearest = nearestByTree(job.cube, around, glm::distance(job.cube.centre, around.point));
  else
    nearest = nearestOf(job.cube, candidates, around, worker, near);
  // Where the surface passes the middle of a cube, a model through it needs no side.
  const bool passed = nearest.distance < job.cube.half;
  MeshSides::Side side{0.0, false};
  if (!passed) side = sideOf(job.cube, nearest, around);
  const bool certain = passed ? sides_.isCertain(job.cube.centre, radius) : side.certain;
  const double caps = options_.onlyCulls ? largestCapError_ : errorOfCaps(near);
  const double enough = std::max(0.0, allowed(nearest.distance, radius) - caps);
  // The smallest cells are for cubes that the surface may pass, and for narrow slits and grooves with surface
  // on several sides.
  const bool last = job.side == 1 || (job.side == 2 && nearest.distance > kAlone * radius);
  CubeModel model;
  model.error = radius;
  bool found = false;
  if (certain && radius > enough && !options_.onlyCulls) {
    found = fit_.fit(job.cube, near, nearest, side.sign, enough,
                     last ? std::max(kSecondTry * enough, 0.25 * radius) : kSecondTry * enough, model);
  }
  const bool hopeless = !certain && nearest.distance > 4.0 * radius;
  if (last || hopeless || (certain && model.error <= enough)) {
    if (!found && passed) side = sideOf(job.cube, nearest, around);
    // A distance changes by at most a metre per metre; where the side is open, its sign may change too.
    if (!found) model = {glm::dvec3(0.0), side.sign * nearest.distance, radius};
    if (!certain) model = {glm::dvec3(0.0), 0.0, nearest.distance + radius};
    model.error += caps;
    // What is listed is what contact asks for. Beside caps, which do not exist, another triangle may count.
    const bool asked = model.error + rounding_ > kListedError * field_.tolerance_ &&
                       nearest.distance <= field_.band_ + radius && !(caps > 0.0);
    std::vector<std::uint32_t>& listed = worker.listed;
    listed.clear();
    if (asked && !options_.onlyCulls) {
      // The eight smallest cells of a cube share the list of that cube, unless it is too long.
      if (job.side == 1 && !worker.sharedIsKnown) {
        listNearest({around.centre, 2.0 * job.cube.half}, candidates, worker);
        worker.shared = listed;
        worker.sharedIsKnown = true;
      }
      if (job.side == 1) listed = worker.shared;
      if (listed.empty()) listNearest(job.cube, near, worker);
    }
    store(job, model, worker, piece);
    // A cell that only culls, for example between sheets of a defective file, says nothing about accuracy.
    if (found && certain && nearest.distance <= radius && isSmooth(job.cube, near, nearest))
      piece.worstSmooth = std::max(piece.worstSmooth, model.error + rounding_);
    return;
  }
  const Known known{job.cube.centre, nearest.distance, side, nearest.point};
  const double half = 0.5 * job.cube.half;
  const std::uint32_t step = job.side / 2;
  worker.sharedIsKnown = false;
  for (std::uint32_t i = 0; i < 8; ++i) {
    const std::array<std::uint32_t, 3> bit = {i & 1u, i >> 1 & 1u, i >> 2 & 1u};
    Job child{{job.cube.centre, half}, job.at, step, job.level + 1};
    for (int axis = 0; axis < 3; ++axis) {
      child.cube.centre[axis] += bit[static_cast<std::size_t>(axis)] != 0 ? half : -half;
      child.at[static_cast<std::size_t>(axis)] += bit[static_cast<std::size_t>(axis)] * step;
    }
    refine(child, near, known, worker, piece);
  }
}

double FieldBake::errorOfCaps(std::span<const std::uint32_t> near) const {
  double largest = 0.0;
  if (!capped_.error.empty())
    for (const std::uint32_t t : near) largest = std::max(largest, capped_.error[t]);
  return largest;
}

bool FieldBake::isSmooth(const FieldCube& cube, std::span<const std::uint32_t> near,
                         const MeshPoint& nearest) const {
  const glm::dvec3 outwards = sides_.outwards(nearest);
  const double reach = nearest.distance + 2.0 * cube.radius();
  return std::all_of(near.begin(), near.end(), [&](std::uint32_t t) {
    const Triangle corners = tree_.triangle(t);
    const glm::dvec3 normal = areaVector(corners);
    return sides_.facing() * glm::dot(normal, outwards) >=
               kSmoothTurn * glm::length(normal) * glm::length(outwards) ||
           glm::distance(closestPointOnTriangle(cube.centre, corners).point, cube.centre) > reach;
  });
}

std::uint32_t FieldBake::placeOfList(Worker& worker, Piece& piece) {
  const std::vector<std::uint32_t>& list = worker.listed;
  std::vector<std::uint32_t>& lists = piece.lists;
  std::uint64_t hash = list.size();  // FNV-1a
  for (const std::uint32_t triangle : list) hash = (hash ^ triangle) * 0x100000001b3u;
  const auto at = static_cast<std::uint32_t>(lists.size());
  const auto [entry, isNew] = worker.known.try_emplace(hash, at);
  const std::uint32_t* const there = lists.data() + entry->second;
  if (!isNew && *there == list.size() && std::equal(list.begin(), list.end(), there + 1))
    return entry->second;
  lists.push_back(static_cast<std::uint32_t>(list.size()));
  lists.insert(lists.end(), list.begin(), list.end());
  return at;
}

void FieldBake::listNearest(const FieldCube& cube, std::span<const std::uint32_t> near,
                            Worker& worker) const {
  worker.listed.clear();
  if (near.size() > kWorthListing) return;
  // The distance of a triangle is convex: over the cube it lies above its tangent at the centre, and below
  // what is interpolated between its corners. A triangle whose tangent is above another one's distance at all
  // corners is nowhere nearer than that one.
  std::array<glm::dvec3, 8> corner;
  for (std::size_t i = 0; i < 8; ++i) {
    const glm::dvec3 way((i & 1) != 0 ? 1.0 : -1.0, (i & 2) != 0 ? 1.0 : -1.0, (i & 4) != 0 ? 1.0 : -1.0);
    corner[i] = (cube.half + rounding_) * way;
  }
  struct Tangent {
    std::uint32_t triangle;
    double distance;
    glm::dvec3 gradient;
  };
  FixedVector<Tangent, kWorthListing> tangents;
  const Tangent* nearest = nullptr;
  for (const std::uint32_t t : near) {
    // A cap of a slit without width lies on edges of the mesh, which are as near.
    if (t >= capped_.firstCap) continue;
    const glm::dvec3 off = cube.centre - closestPointOnTriangle(cube.centre, tree_.triangle(t)).point;
    const double distance = glm::length(off);
    const Tangent& tangent =
        tangents.push_back({t, distance, distance > 0.0 ? off / distance : glm::dvec3(0.0)});
    if (nearest == nullptr || distance < nearest->distance) nearest = &tangent;
  }
  if (nearest == nullptr) return;
  std::array<double, 8> most;
  for (std::size_t i = 0; i < 8; ++i) {
    const glm::dvec3 p = cube.centre + corner[i];
    most[i] = glm::distance(p, closestPointOnTriangle(p, tree_.triangle(nearest->triangle)).point);
  }
  for (const Tangent& tangent : tangents) {
    bool counts = &tangent == nearest;
    for (std::size_t i = 0; i < 8 && !counts; ++i)
      counts = tangent.distance + glm::dot(tangent.gradient, corner[i]) <= most[i] + rounding_;
    if (counts) worker.listed.push_back(tangent.triangle);
  }
  if (worker.listed.size() > DistanceField::kMaxListed) worker.listed.clear();
}

void FieldBake::store(const Job& job, const CubeModel& model, Worker& worker, Piece& piece) const {
  const glm::vec3 gradient(model.gradient);
  const double offset = model.value - glm::dot(glm::dvec3(gradient), job.cube.centre - field_.origin_);
  const bool isListed = !worker.listed.empty();
  if (isListed) piece.listAt.push_back(placeOfList(worker, piece));
  std::vector<DistanceField::Cell>& cells = isListed ? piece.listed : piece.cells;
  const std::uint32_t entry =
      DistanceField::kLeaf | (isListed ? kListed : 0u) | static_cast<std::uint32_t>(cells.size());
  cells.push_back({gradient, static_cast<float>(offset), roundUp(model.error + rounding_)});
  const auto newBlock = [&piece] {
    piece.blocks.resize(piece.blocks.size() + DistanceField::kBlock);
    return static_cast<std::uint32_t>(piece.blocks.size() / DistanceField::kBlock - 1);
  };
  const auto fill = [&](std::uint32_t block, std::uint32_t unit) {
    const std::uint32_t count = job.side / unit;
    for (std::uint32_t z = 0; z < count; ++z)
      for (std::uint32_t y = 0; y < count; ++y)
        for (std::uint32_t x = 0; x < count; ++x)
          piece.blocks[block * DistanceField::kBlock + DistanceField::inBlock(job.at[0] / unit + x,
                                                                              job.at[1] / unit + y,
                                                                              job.at[2] / unit + z)] = entry;
  };
  if (job.side == DistanceField::kSpan) {
    piece.root = entry;
    return;
  }
  // The first block is that of the cube, so no block entry in it can be 0.
  if (piece.blocks.empty()) piece.root = newBlock();
  if (job.side >= 8) {
    fill(0, 8);
    return;
  }
  const std::uint32_t place = DistanceField::inBlock(job.at[0] / 8, job.at[1] / 8, job.at[2] / 8);
  if (piece.blocks[place] == 0) {
    const std::uint32_t block = newBlock();
    piece.blocks[place] = block;
  }
  fill(piece.blocks[place], 1);
}

void FieldBake::join(std::vector<Piece>& pieces) {
  const auto total = [&](auto Piece::* of) {
    std::size_t size = 0;
    for (const Piece& piece : pieces) size += (piece.*of).size();
    return size;
  };
  std::size_t firstCell = total(&Piece::listed);
  field_.blocks_.reserve(total(&Piece::blocks));
  field_.cells_.resize(firstCell + total(&Piece::cells));
  field_.listAt_.reserve(firstCell);
  field_.lists_.reserve(total(&Piece::lists));
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    Piece& piece = pieces[i];
    const auto firstBlock = static_cast<std::uint32_t>(field_.blocks_.size() / DistanceField::kBlock);
    const std::size_t firstListed = field_.listAt_.size();
    const auto moved = [&](std::uint32_t entry) {
      if ((entry & DistanceField::kLeaf) == 0) return entry + firstBlock;
      const bool isListed = (entry & kListed) != 0;
      return (entry & ~kListed) + static_cast<std::uint32_t>(isListed ? firstListed : firstCell);
    };
    field_.top_[i] = moved(piece.root);
    for (const std::uint32_t entry : piece.blocks) field_.blocks_.push_back(moved(entry));
    std::copy(piece.listed.begin(), piece.listed.end(), field_.cells_.data() + firstListed);
    std::copy(piece.cells.begin(), piece.cells.end(), field_.cells_.data() + firstCell);
    firstCell += piece.cells.size();
    const auto firstList = static_cast<std::uint32_t>(field_.lists_.size());
    for (const std::uint32_t at : piece.listAt) field_.listAt_.push_back(at + firstList);
    field_.lists_.insert(field_.lists_.end(), piece.lists.begin(), piece.lists.end());
    field_.worstSmoothError_ = std::max(field_.worstSmoothError_, piece.worstSmooth);
    piece = {};
  }
  if (options_.progress) options_.progress(1.0);
}

}  // namespace tandem::haptics
