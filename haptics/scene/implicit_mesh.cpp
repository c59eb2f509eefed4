#include "haptics/scene/implicit_mesh.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <glm/common.hpp>

#include "assets/base/constants.h"

namespace tandem::haptics {
namespace {

using assets::ImplicitShape;

// A chord over the angle a lies r (1 - cos(a/2)) below its arc: 1e-4 r at 1.62 degrees, 222 segments a turn.
constexpr int kSegments = 224;

class MeshWriter {
 public:
  MeshWriter(assets::Mesh& mesh, const ImplicitShape& shape) : mesh_(mesh), shape_(shape) {}

  std::uint32_t vertex(const glm::dvec3& inShape) {
    mesh_.positions.push_back(transformPoint(shape_.partFromShape, inShape));
    return static_cast<std::uint32_t>(mesh_.positions.size() - 1);
  }

  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (a == b || b == c || c == a) return;
    mesh_.triangles.push_back({a, b, c});
    mesh_.triangleMaterial.push_back(shape_.material);
  }

  void quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    triangle(a, b, c);
    triangle(a, c, d);
  }

  /// Revolves a profile (radius, height), from top to bottom, about +Y. A radius of zero makes a tip.
  void revolve(const std::vector<std::pair<double, double>>& profile) {
    std::vector<std::vector<std::uint32_t>> rings;
    for (const auto& [radius, height] : profile) {
      std::vector<std::uint32_t> ring;
      for (int i = 0; i < kSegments; ++i) {
        const double angle = 2.0 * kPi * i / kSegments;
        if (i > 0 && radius <= 0.0) {
          ring.push_back(ring.front());
        } else {
          ring.push_back(vertex({radius * std::sin(angle), height, radius * std::cos(angle)}));
        }
      }
      rings.push_back(std::move(ring));
    }
    for (std::size_t r = 0; r + 1 < rings.size(); ++r) {
      for (std::size_t i = 0; i < kSegments; ++i) {
        const std::size_t j = (i + 1) % kSegments;
        quad(rings[r][i], rings[r + 1][i], rings[r + 1][j], rings[r][j]);
      }
    }
  }

 private:
  assets::Mesh& mesh_;
  const ImplicitShape& shape_;
};

void writeBox(MeshWriter& out, const glm::dvec3& size) {
  std::uint32_t v[8];
  for (int i = 0; i < 8; ++i) {
    const glm::dvec3 sign((i & 1) != 0 ? 0.5 : -0.5, (i & 2) != 0 ? 0.5 : -0.5, (i & 4) != 0 ? 0.5 : -0.5);
    v[i] = out.vertex(sign * size);
  }
  out.quad(v[0], v[4], v[6], v[2]);  // -x
  out.quad(v[1], v[3], v[7], v[5]);  // +x
  out.quad(v[0], v[1], v[5], v[4]);  // -y
  out.quad(v[2], v[6], v[7], v[3]);  // +y
  out.quad(v[0], v[2], v[3], v[1]);  // -z
  out.quad(v[4], v[5], v[7], v[6]);  // +z
}

void writePlane(MeshWriter& out, const glm::dvec3& size, double reach) {
  const double x = size.x > 0.0 ? 0.5 * size.x : reach, z = size.z > 0.0 ? 0.5 * size.z : reach;
  out.quad(out.vertex({-x, 0.0, -z}), out.vertex({-x, 0.0, z}), out.vertex({x, 0.0, z}),
           out.vertex({x, 0.0, -z}));
}

/// Two spheres, of radius `top` at +height/2 and `bottom` at -height/2, and the cone that touches both.
void writeCapsule(MeshWriter& out, double top, double bottom, double height) {
  std::vector<std::pair<double, double>> profile;
  // The common tangent leaves both spheres at the same polar angle; when one sphere contains the other there
  // is no cone.
  const double difference = bottom - top;
  if (height <= std::abs(difference)) {
    const double radius = std::max(top, bottom), y = top > bottom ? 0.5 * height : -0.5 * height;
    for (int i = 0; i <= kSegments / 2; ++i) {
      const double polar = kPi * i / (kSegments / 2);
      const bool pole = i == 0 || i == kSegments / 2;
      profile.emplace_back(pole ? 0.0 : radius * std::sin(polar), y + radius * std::cos(polar));
    }
    out.revolve(profile);
    return;
  }
  const double tangent = std::acos(difference / height);
  const int upper = std::max(2, static_cast<int>(std::ceil(tangent / (2.0 * kPi) * kSegments)));
  const int lower = std::max(2, static_cast<int>(std::ceil((kPi - tangent) / (2.0 * kPi) * kSegments)));
  for (int i = 0; i <= upper; ++i) {
    const double polar = tangent * i / upper;
    profile.emplace_back(i == 0 ? 0.0 : top * std::sin(polar), 0.5 * height + top * std::cos(polar));
  }
  for (int i = 0; i <= lower; ++i) {
    const double polar = tangent + (kPi - tangent) * i / lower;
    profile.emplace_back(i == lower ? 0.0 : bottom * std::sin(polar),
                         -0.5 * height + bottom * std::cos(polar));
  }
  out.revolve(profile);
}

void writeCylinder(MeshWriter& out, double top, double bottom, double height) {
  const double h = 0.5 * height;
  out.revolve({{0.0, h}, {top, h}, {bottom, -h}, {0.0, -h}});
}

}  // namespace

assets::Mesh meshOfShapes(std::span<const assets::ImplicitShape> shapes, double reach) {
  assets::Mesh mesh;
  for (const ImplicitShape& shape : shapes) {
    MeshWriter out(mesh, shape);
    switch (shape.kind) {
      case ImplicitShape::Kind::box:
        writeBox(out, shape.size);
        break;
      case ImplicitShape::Kind::plane:
        writePlane(out, shape.size, reach);
        break;
      case ImplicitShape::Kind::sphere:
        writeCapsule(out, shape.radiusBottom, shape.radiusBottom, 0.0);
        break;
      case ImplicitShape::Kind::capsule:
        writeCapsule(out, shape.radiusTop, shape.radiusBottom, shape.height);
        break;
      case ImplicitShape::Kind::cylinder:
        writeCylinder(out, shape.radiusTop, shape.radiusBottom, shape.height);
        break;
    }
  }
  for (const glm::dvec3& p : mesh.positions) {
    mesh.bounds.include(p);
  }
  return mesh;
}

}  // namespace tandem::haptics
