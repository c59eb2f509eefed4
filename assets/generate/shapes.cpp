#include "assets/generate/shapes.h"

#include <cmath>

#include "assets/base/assert.h"
#include "assets/generate/triangulate.h"

namespace tandem::generate {

Loop circle(double radius, int segments, const glm::dvec2& centre) {
  Loop loop;
  for (int i = 0; i < segments; ++i) {
    const double turn = 2.0 * M_PI * i / segments;
    loop.push_back(centre + radius * glm::dvec2(std::cos(turn), std::sin(turn)));
  }
  return loop;
}

Loop circleAround(double radius, int segments, const glm::dvec2& centre) {
  return circle(radius / std::cos(M_PI / segments), segments, centre);
}

Loop hexagon(double acrossFlats, int perSide) {
  const Loop corners = circleAround(0.5 * acrossFlats, 6);
  Loop loop;
  for (std::size_t i = 0; i < 6; ++i)
    for (int k = 0; k < perSide; ++k)
      loop.push_back(corners[i] + static_cast<double>(k) / perSide * (corners[(i + 1) % 6] - corners[i]));
  return loop;
}

Loop roundedRectangle(const glm::dvec2& size, double cornerRadius, int perCorner) {
  Loop loop;
  for (int corner = 0; corner < 4; ++corner) {
    const glm::dvec2 sign(corner == 0 || corner == 3 ? 1.0 : -1.0, corner < 2 ? 1.0 : -1.0);
    const glm::dvec2 centre = sign * (0.5 * size - glm::dvec2(cornerRadius));
    for (int i = 0; i <= perCorner; ++i) {
      const double turn = 0.5 * M_PI * (corner + static_cast<double>(i) / perCorner);
      loop.push_back(centre + cornerRadius * glm::dvec2(std::cos(turn), std::sin(turn)));
    }
  }
  return loop;
}

std::vector<glm::dvec2> boltCircle(double radius, int count, double firstAngle) {
  std::vector<glm::dvec2> centres;
  for (int i = 0; i < count; ++i) {
    const double turn = firstAngle + 2.0 * M_PI * i / count;
    centres.push_back(radius * glm::dvec2(std::cos(turn), std::sin(turn)));
  }
  return centres;
}

void Solid::add(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  if (a == b || b == c || c == a) return;  // at the axis of a revolved profile
  triangles_.push_back({a, b, c});
  slots_.push_back(slot_);
}

void Solid::band(const Loop& a, double za, const Loop& b, double zb) {
  ASSERT(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    const std::size_t j = (i + 1) % a.size();
    add(glm::dvec3(a[i], za), glm::dvec3(a[j], za), glm::dvec3(b[j], zb));
    add(glm::dvec3(a[i], za), glm::dvec3(b[j], zb), glm::dvec3(b[i], zb));
  }
}

void Solid::revolve(const std::vector<ProfilePoint>& profile, int segments, const glm::dvec2& centre) {
  for (std::size_t i = 0; i + 1 < profile.size(); ++i)
    band(circle(profile[i].radius, segments, centre), profile[i].z,
         circle(profile[i + 1].radius, segments, centre), profile[i + 1].z);
}

void Solid::cap(const Loop& outer, const std::vector<Loop>& holes, double z, Facing facing) {
  for (const auto& t : triangulate(outer, holes)) {
    const glm::dvec3 a(t[0], z), b(t[1], z), c(t[2], z);
    facing == Facing::up ? add(a, b, c) : add(a, c, b);
  }
}

assets::TriangleSoup Solid::soup() const {
  assets::TriangleSoup soup;
  for (const auto& triangle : triangles_) {
    const auto first = static_cast<std::uint32_t>(soup.positions.size());
    for (const glm::dvec3& p : triangle) soup.positions.push_back(glm::dvec3(p.x, p.z, -p.y));
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  soup.triangleMaterial = slots_;
  return soup;
}

}  // namespace tandem::generate
