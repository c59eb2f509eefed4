#include "haptics/overlap/mesh_closing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <tuple>

#include <glm/vector_relational.hpp>

#include "assets/base/assert.h"
#include "haptics/geometry/slit_caps.h"

namespace tandem::haptics {

namespace {

constexpr std::size_t kFewLids = 64;
/// More than the error of WindingTree::at().
constexpr double kShareError = 0.1;

/// The mesh with vertices of equal coordinates joined and without the triangles that this makes degenerate.
assets::Mesh joinedAtEqualPoints(const assets::Mesh& mesh) {
  std::vector<std::uint32_t> order(mesh.positions.size()), first(mesh.positions.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto before = [&](std::uint32_t l, std::uint32_t r) {
    const glm::dvec3 &a = mesh.positions[l], &b = mesh.positions[r];
    return std::tie(a.x, a.y, a.z, l) < std::tie(b.x, b.y, b.z, r);
  };
  std::sort(order.begin(), order.end(), before);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && mesh.positions[order[i]] == mesh.positions[order[i - 1]];
    first[order[i]] = same ? first[order[i - 1]] : order[i];
  }
  assets::Mesh joined;
  joined.positions = mesh.positions;
  for (const auto& t : mesh.triangles) {
    const std::array<std::uint32_t, 3> own{first[t[0]], first[t[1]], first[t[2]]};
    if (own[0] != own[1] && own[1] != own[2] && own[2] != own[0]) joined.triangles.push_back(own);
  }
  return joined;
}

}  // namespace

MeshClosing::MeshClosing(const TriangleBvh& tree) : tree_(tree) {
  const assets::Mesh& mesh = tree.mesh();
  glm::dvec3 mean(0.0);
  for (const glm::dvec3& p : mesh.positions) mean += p / static_cast<double>(mesh.positions.size());
  for (const glm::dvec3& p : mesh.positions) size_ = std::max(size_, 2.0 * glm::length(p - mean));
  if (mesh.closed || tree.empty()) return;
  const SlitCaps caps = closeAllHoles(joinedAtEqualPoints(mesh));
  if (caps.triangles.empty()) return;
  ASSERT(caps.complete);
  std::vector<std::uint32_t> own(mesh.positions.size(), kNoTriangle);
  for (const auto& cap : caps.triangles) {
    std::array<std::uint32_t, 3> lid;
    for (std::size_t i = 0; i < 3; ++i) {
      std::uint32_t& vertex = own[cap[i]];
      if (vertex == kNoTriangle) {
        vertex = static_cast<std::uint32_t>(lidMesh_.positions.size());
        lidMesh_.positions.push_back(mesh.positions[cap[i]]);
      }
      lid[i] = vertex;
    }
    lidMesh_.triangles.push_back(lid);
  }
  lids_ = std::make_unique<TriangleBvh>(lidMesh_, 1);
  if (lidMesh_.triangles.size() > kFewLids) lidWinding_ = std::make_unique<WindingTree>(lidMesh_);
}

int MeshClosing::crossings(const glm::dvec3& from, const glm::dvec3& to) const {
  return tree_.signedCrossings(from, to) + (lids_ == nullptr ? 0 : lids_->signedCrossings(from, to));
}

bool MeshClosing::contains(const glm::dvec3& p) const {
  const assets::Bounds& box = tree_.bounds();
  if (tree_.empty() || glm::any(glm::lessThan(p, box.min)) || glm::any(glm::greaterThan(p, box.max)))
    return false;
  // Every direction counts the same, except where a ray hits an edge exactly, which the others outvote. They
  // are skew because CAD has edges along the axes.
  static const std::array<glm::dvec3, 3> kRays = {glm::dvec3(0.5377, 0.2913, 0.7912),
                                                  glm::dvec3(-0.6121, 0.7413, -0.2757),
                                                  glm::dvec3(0.1733, -0.8347, -0.5227)};
  const double length = 1.5 * glm::length(box.max - box.min);
  const int first = crossings(p, p + length * kRays[0]), second = crossings(p, p + length * kRays[1]);
  if (first == second) return first != 0;
  const int third = crossings(p, p + length * kRays[2]);
  return (third == second ? second : first) != 0;
}

double MeshClosing::lidShare(const glm::dvec3& p) const {
  double share = 0.0;
  for (std::uint32_t i = 0; i < lidMesh_.triangles.size(); ++i)
    share += windingOfTriangle(p, lids_->triangle(i));
  return share;
}

MeshClosing::RoughShare MeshClosing::roughLidShare(const glm::dvec3& p) const {
  if (lidWinding_ == nullptr) return {lidShare(p), 0.0};
  return {lidWinding_->at(p), kShareError};
}

bool MeshClosing::isCertain(const glm::dvec3& p) const {
  if (lids_ == nullptr) return true;
  const RoughShare rough = roughLidShare(p);
  const bool decided = std::abs(std::abs(rough.value) - kMaxLidShare) > rough.error;
  return std::abs(decided ? rough.value : lidShare(p)) < kMaxLidShare;
}

}  // namespace tandem::haptics
