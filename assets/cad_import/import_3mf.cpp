#include "assets/cad_import/import_3mf.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "assets/base/printable.h"
#include "assets/cad_import/length_unit.h"

namespace tandem::cad_import {
namespace {

constexpr std::uint64_t kMostNodes = 200000;
constexpr int kDeepest = 100;         // objects within each other
constexpr double kSkew = 1e-4;        // rad between axes that count as square: the file has few digits
constexpr double kReadingEnds = 0.9;  // of the progress

/// The transform with axes that are exactly square; nothing if it shears.
std::optional<glm::dmat4> square(const glm::dmat4& matrix) {
  const glm::dvec3 x(matrix[0]), y(matrix[1]), z(matrix[2]);
  const glm::dvec3 lengths(glm::length(x), glm::length(y), glm::length(z));
  const glm::dvec3 i = x / lengths.x, asked = y / lengths.y, last = z / lengths.z;
  if (std::abs(glm::dot(i, asked)) > kSkew || std::abs(glm::dot(i, last)) > kSkew ||
      std::abs(glm::dot(asked, last)) > kSkew)
    return std::nullopt;
  const glm::dvec3 j = glm::normalize(asked - glm::dot(i, asked) * i);
  const glm::dvec3 k = glm::cross(i, j) * (glm::dot(glm::cross(i, j), last) < 0.0 ? -1.0 : 1.0);
  return glm::dmat4(glm::dvec4(lengths.x * i, 0.0), glm::dvec4(lengths.y * j, 0.0),
                    glm::dvec4(lengths.z * k, 0.0), matrix[3]);
}

bool canBeInverted(const glm::dmat4& matrix) {
  double most = 0.0;
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 4; ++row) {
      if (!std::isfinite(matrix[column][row])) return false;
      if (column < 3) most = std::max(most, std::abs(matrix[column][row]));
    }
  return std::abs(glm::determinant(glm::dmat3(matrix))) > 1e-9 * most * most * most;
}

class TreeBuilder {
 public:
  TreeBuilder(ThreeMfPackage package, CadScene& scene)
      : package_(std::move(package)), scene_(scene), counts_(package_.objects.size()) {}

  void build(const glm::dmat4& worldFromFile) {
    if (package_.built.empty()) buildAll();
    std::uint64_t nodes = 0;
    for (const ThreeMfPlace& place : package_.built) nodes += nodesOf(place.object, 0);
    if (nodes > kMostNodes)
      throw std::runtime_error("more than " + std::to_string(kMostNodes) + " objects are placed in it");
    meshes_.assign(package_.objects.size(), kNone);
    for (const ThreeMfPlace& place : package_.built)
      add(place, worldFromFile, kNone, place.name.empty() ? scene_.name : place.name);
    if (supports_ > 0) say("support-structures", supports_, "Supports for printing are left out.");
    if (sheared_ > 0) say("sheared-instances", sheared_, "Places that shear have meshes of their own.");
  }

 private:
  void say(const char* code, std::uint64_t count, const char* text) {
    scene_.findings.push_back({code, count, text});
  }

  /// All objects that no other one uses.
  void buildAll() {
    std::vector<bool> used(package_.objects.size(), false);
    for (const ThreeMfObject& object : package_.objects)
      for (const ThreeMfPlace& child : object.children) used[child.object] = true;
    for (std::uint32_t i = 0; i < used.size(); ++i)
      if (!used[i]) package_.built.push_back({i, glm::dmat4(1.0), {}});
    say("nothing-built", 1, "It does not say what is to be built: all objects are taken.");
  }

  /// Of an object with all that it is put together of; more than kMostNodes are some number beyond.
  std::uint64_t nodesOf(std::uint32_t index, int depth) {
    Count& count = counts_[index];
    if (count.open) throw std::runtime_error("an object in it is put together of itself");
    if (depth > kDeepest) throw std::runtime_error("its objects are put together too deeply");
    if (count.nodes > 0) return count.nodes;
    count.open = true;
    std::uint64_t nodes = 1;
    for (const ThreeMfPlace& child : package_.objects[index].children) {
      nodes = std::min(nodes + nodesOf(child.object, depth + 1), kMostNodes + 1);
      count.height = std::max(count.height, 1 + counts_[child.object].height);
    }
    if (count.height > kDeepest) throw std::runtime_error("its objects are put together too deeply");
    count.open = false;
    return count.nodes = nodes;
  }

  /// `rest` is what the node above could not take, since it shears.
  void add(const ThreeMfPlace& place, const glm::dmat4& rest, std::uint32_t parent,
           const std::string& otherName) {
    const ThreeMfObject& object = package_.objects[place.object];
    if (object.support) {
      ++supports_;
      return;
    }
    if (!canBeInverted(place.parentFromObject))
      throw std::runtime_error("a place in it has no volume, or is not a number");
    glm::dmat4 scaled = place.parentFromObject;
    for (int axis = 0; axis < 3; ++axis) scaled[3][axis] *= scene_.metresPerUnit;
    const glm::dmat4 wanted = rest * scaled;
    const std::optional<glm::dmat4> own = square(wanted);
    CadNode node;
    node.name = object.name.empty() ? otherName : object.name;
    node.parent = parent;
    node.material = object.material;
    if (own) node.parentFromNode = *own;
    if (!object.mesh.triangles.empty()) node.mesh = own ? meshOf(place.object) : shearedMesh(object, wanted);
    scene_.nodes.push_back(node);
    const auto self = static_cast<std::uint32_t>(scene_.nodes.size() - 1);
    for (const ThreeMfPlace& child : object.children)
      add(child, own ? glm::dmat4(1.0) : wanted, self, node.name);
  }

  std::uint32_t meshOf(std::uint32_t object) {
    if (meshes_[object] == kNone) {
      meshes_[object] = static_cast<std::uint32_t>(scene_.meshes.size());
      scene_.meshes.push_back(inMetres(package_.objects[object]));
    }
    return meshes_[object];
  }

  std::uint32_t shearedMesh(const ThreeMfObject& object, const glm::dmat4& matrix) {
    ++sheared_;
    CadMesh mesh = inMetres(object);
    for (glm::dvec3& at : mesh.positions) at = glm::dvec3(matrix * glm::dvec4(at, 1.0));
    if (glm::determinant(glm::dmat3(matrix)) < 0.0)
      for (CadTriangles& group : mesh.triangles)
        for (std::size_t i = 0; i + 2 < group.corners.size(); i += 3)
          std::swap(group.corners[i], group.corners[i + 1]);
    scene_.meshes.push_back(std::move(mesh));
    return static_cast<std::uint32_t>(scene_.meshes.size() - 1);
  }

  /// The object's mesh with the points that its triangles use.
  CadMesh inMetres(const ThreeMfObject& object) const {
    CadMesh mesh;
    mesh.name = object.name;
    std::vector<std::uint32_t> kept(object.mesh.positions.size(), kNone);
    for (CadTriangles group : object.mesh.triangles) {
      for (std::uint32_t& corner : group.corners) {
        if (kept[corner] == kNone) {
          kept[corner] = static_cast<std::uint32_t>(mesh.positions.size());
          mesh.positions.push_back(scene_.metresPerUnit * object.mesh.positions[corner]);
        }
        corner = kept[corner];
      }
      mesh.triangles.push_back(std::move(group));
    }
    return mesh;
  }

  struct Count {
    std::uint64_t nodes = 0;
    int height = 0;     // of the tree below it
    bool open = false;  // it is being counted
  };

  ThreeMfPackage package_;
  CadScene& scene_;
  std::vector<Count> counts_;          // one an object
  std::vector<std::uint32_t> meshes_;  // into the scene's, one an object
  std::size_t supports_ = 0, sheared_ = 0;
};

}  // namespace

Result<CadScene> sceneOf3mf(ThreeMfPackage package, const std::string& name,
                            const ImportOptions& options) try {
  CadScene scene;
  scene.name = name;
  scene.unit = options.units.empty() ? package.unit : options.units;
  scene.metresPerUnit = metresPerUnit(scene.unit).value();
  scene.colours = package.colours;
  if (package.unusable > 0)
    scene.findings.push_back(
        {"unusable-triangles", package.unusable, "Triangles without area or without corners are left out."});
  if (package.warnings > 0)
    scene.findings.push_back({"reader-warnings", package.warnings, "lib3mf: " + package.firstWarning});
  const glm::dmat4 yFromZ(1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1);
  TreeBuilder(std::move(package), scene).build(options.yUp ? glm::dmat4(1.0) : yFromZ);
  if (scene.meshes.empty()) return Error{"no triangle in it"};
  if (const std::string doubt = unitDoubt(scene); !doubt.empty())
    scene.findings.push_back({"unit-doubt", 1, doubt});
  return scene;
} catch (const std::runtime_error& error) {
  return Error{error.what()};
}

Result<CadScene> import3mf(const std::string& path, const ImportOptions& options) {
  options.progress(0.0, "the file");
  Result<ThreeMfPackage> package =
      read3mf(path, [&](double share) { options.progress(kReadingEnds * share, "the file"); });
  if (!package) return package.error();
  Result<CadScene> scene =
      sceneOf3mf(std::move(*package), printable(std::filesystem::path(path).stem().string(), 200), options);
  options.progress(1.0, "done");
  return scene;
}

}  // namespace tandem::cad_import
