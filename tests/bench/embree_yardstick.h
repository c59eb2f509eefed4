#pragma once

// The yardstick of the contact benches: the closest point by Embree on the same triangles, in the same run.

#include <embree3/rtcore.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "assets/scene/scene.h"
#include "tests/bench/bench_report.h"

namespace tandem::bench {

/// All triangles of a scene in world coordinates, as Embree sees them.
struct WorldMesh {
  std::vector<float> positions;        // 3 a vertex
  std::vector<std::uint32_t> corners;  // 3 a triangle
};

inline WorldMesh flatten(const assets::Scene& scene) {
  WorldMesh out;
  for (const assets::Part& part : scene.parts) {
    if (part.mesh == assets::kNone) continue;
    const assets::Mesh& mesh = scene.meshes[part.mesh];
    const auto first = static_cast<std::uint32_t>(out.positions.size() / 3);
    for (const glm::dvec3& p : mesh.positions) {
      const glm::dvec3 world = transformPoint(part.worldFromPart, p);
      for (int i = 0; i < 3; ++i) out.positions.push_back(static_cast<float>(world[i]));
    }
    for (const auto& t : mesh.triangles) {
      for (const std::uint32_t v : t) out.corners.push_back(first + v);
    }
  }
  return out;
}

/// The yardstick: closest point by Embree, with the same triangle routine in single precision.
class EmbreeYardstick {
 public:
  explicit EmbreeYardstick(const WorldMesh& mesh) : mesh_(&mesh), device_(rtcNewDevice("threads=2")) {
    scene_ = rtcNewScene(device_);
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                             3 * sizeof(float), mesh.positions.size() / 3);
    void* indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                            3 * sizeof(std::uint32_t), mesh.corners.size() / 3);
    std::copy(mesh.positions.begin(), mesh.positions.end(), static_cast<float*>(vertices));
    std::copy(mesh.corners.begin(), mesh.corners.end(), static_cast<std::uint32_t*>(indices));
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    const Stopwatch watch;
    rtcCommitScene(scene_);
    buildSeconds_ = watch.seconds();
  }
  ~EmbreeYardstick() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  EmbreeYardstick(const EmbreeYardstick&) = delete;
  EmbreeYardstick& operator=(const EmbreeYardstick&) = delete;

  double buildSeconds() const { return buildSeconds_; }

  /// The nearest point of the mesh, as far as single precision tells.
  struct Nearest {
    glm::vec3 point{0.0f};
    std::uint32_t triangle = 0;
    float distance = 0.0f;  // m
  };

  /// Distance from p to the nearest triangle, m.
  double closest(const glm::dvec3& p) { return closestPoint(p).distance; }

  Nearest closestPoint(const glm::dvec3& p) {
    Search search{mesh_, {}};
    RTCPointQuery query{};
    query.x = static_cast<float>(p.x);
    query.y = static_cast<float>(p.y);
    query.z = static_cast<float>(p.z);
    query.radius = std::numeric_limits<float>::infinity();
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene_, &query, &context, &EmbreeYardstick::visit, &search);
    search.nearest.distance = query.radius;
    return search.nearest;
  }

 private:
  struct Search {
    const WorldMesh* mesh;
    Nearest nearest;
  };

  static glm::vec3 corner(const WorldMesh& mesh, std::uint32_t triangle, std::uint32_t i) {
    const float* p = &mesh.positions[3 * mesh.corners[3 * triangle + i]];
    return {p[0], p[1], p[2]};
  }

  /// Ericson's closest point, in float.
  static glm::vec3 closestOnTriangle(const glm::vec3& p, const glm::vec3& a, const glm::vec3& b,
                                     const glm::vec3& c) {
    const glm::vec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
    const float d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
    if (d1 <= 0.0f && d2 <= 0.0f) return a;
    const float d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
    if (d3 >= 0.0f && d4 <= d3) return b;
    const float vc = d1 * d4 - d3 * d2;
    if (vc <= 0.0f && d1 >= 0.0f && d3 <= 0.0f) return a + ab * (d1 / (d1 - d3));
    const float d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
    if (d6 >= 0.0f && d5 <= d6) return c;
    const float vb = d5 * d2 - d1 * d6;
    if (vb <= 0.0f && d2 >= 0.0f && d6 <= 0.0f) return a + ac * (d2 / (d2 - d6));
    const float va = d3 * d6 - d5 * d4;
    if (va <= 0.0f && d4 - d3 >= 0.0f && d5 - d6 >= 0.0f) {
      return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    const float sum = 1.0f / (va + vb + vc);
    return a + ab * (vb * sum) + ac * (vc * sum);
  }

  static bool visit(RTCPointQueryFunctionArguments* arguments) {
    Search& search = *static_cast<Search*>(arguments->userPtr);
    const WorldMesh& mesh = *search.mesh;
    const glm::vec3 p(arguments->query->x, arguments->query->y, arguments->query->z);
    const std::uint32_t t = arguments->primID;
    const glm::vec3 point = closestOnTriangle(p, corner(mesh, t, 0), corner(mesh, t, 1), corner(mesh, t, 2));
    const float distance = glm::length(p - point);
    if (!(distance < arguments->query->radius)) return false;
    arguments->query->radius = distance;
    search.nearest.point = point;
    search.nearest.triangle = t;
    return true;
  }

  const WorldMesh* mesh_;
  RTCDevice device_;
  RTCScene scene_ = nullptr;
  double buildSeconds_ = 0.0;
};

}  // namespace tandem::bench
