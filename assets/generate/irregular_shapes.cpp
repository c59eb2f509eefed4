#include "assets/generate/irregular_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

#include "assets/base/constants.h"
#include "assets/generate/soup_builder.h"

namespace tandem::generate {
namespace {

using Random = std::mt19937;

double between(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

assets::TriangleSoup shifted(assets::TriangleSoup soup, const glm::dvec3& by) {
  for (glm::dvec3& p : soup.positions) p += by;
  return soup;
}

/// The radius of a blob as a function of the direction: a sphere with a few waves.
class Lumps {
 public:
  explicit Lumps(Random& random) : radius_(between(random, 0.010, 0.018)) {
    for (Wave& wave : waves_) {
      wave.along = {between(random, -5.0, 5.0), between(random, -5.0, 5.0), between(random, -5.0, 5.0)};
      wave.phase = between(random, 0.0, 6.0);
      wave.height = between(random, 0.01, 0.07);
    }
  }
  glm::dvec3 at(const glm::dvec3& direction) const {
    double share = 1.0;
    for (const Wave& wave : waves_)
      share += wave.height * std::cos(glm::dot(wave.along, direction) + wave.phase);
    return radius_ * share * direction;
  }

 private:
  struct Wave {
    glm::dvec3 along{0.0, 0.0, 0.0};
    double phase = 0.0, height = 0.0;
  };
  double radius_;
  Wave waves_[4];
};

/// Corners of an outline, each left sharp, cut or rounded.
std::vector<glm::dvec2> bevelled(Random& random, const std::vector<glm::dvec2>& outline) {
  std::vector<glm::dvec2> out;
  const std::size_t count = outline.size();
  for (std::size_t i = 0; i < count; ++i) {
    const glm::dvec2 p = outline[i], a = outline[(i + count - 1) % count], b = outline[(i + 1) % count];
    const double size = between(random, 0.1, 0.4) * std::min(glm::length(a - p), glm::length(b - p));
    const glm::dvec2 from = p + size * glm::normalize(a - p), to = p + size * glm::normalize(b - p);
    const int pieces = std::array{0, 1, 3, 8, 24}[random() % 5];
    if (pieces == 0) out.push_back(p);
    for (int k = 0; pieces > 0 && k <= pieces; ++k) {
      const double t = static_cast<double>(k) / pieces;
      out.push_back((1.0 - t) * (1.0 - t) * from + 2.0 * t * (1.0 - t) * p + t * t * to);
    }
  }
  return out;
}

/// A prism over stairs up and down whose corners are bevelled.
assets::TriangleSoup blockSoup(Random& random) {
  const int steps = 2 + static_cast<int>(random() % 4);
  std::vector<double> runs, heights;
  double width = 0.0;
  for (int i = 0; i < steps; ++i) {
    runs.push_back(between(random, 0.003, 0.010));
    heights.push_back(between(random, 0.004, 0.018));
    width += runs.back();
  }
  std::vector<glm::dvec2> outline{{0.0, 0.0}, {width, 0.0}};
  double x = width;
  for (int i = steps - 1; i >= 0; --i) {
    outline.emplace_back(x, heights[static_cast<std::size_t>(i)]);
    x -= runs[static_cast<std::size_t>(i)];
    outline.emplace_back(std::max(x, 0.0), heights[static_cast<std::size_t>(i)]);
  }
  const double depth = between(random, 0.004, 0.020);
  const int layers = 1 + static_cast<int>(random() % 3);
  SoupBuilder builder;
  builder.prism(bevelled(random, outline), depth, layers);
  return shifted(std::move(builder.soup), {-0.5 * width, -0.006, -0.5 * depth});
}

/// Rings of random radii about the z axis: cylinders, cones, vaults, and ridges where they meet.
assets::TriangleSoup turnedSoup(Random& random) {
  const int segments = std::array{16, 24, 48, 96}[random() % 4];
  const int sections = 3 + static_cast<int>(random() % 4);
  std::vector<Ring> rings;
  double z = 0.0, r = between(random, 0.003, 0.010);
  const auto ring = [&](double radius, double height) {
    Ring points;
    for (int i = 0; i < segments; ++i) {
      const double a = 2.0 * 3.14159265358979324 * i / segments;
      points.emplace_back(radius * std::cos(a), radius * std::sin(a), height);
    }
    rings.push_back(points);
  };
  ring(r, z);
  for (int s = 0; s < sections; ++s) {
    const double length = between(random, 0.002, 0.010), next = between(random, 0.003, 0.012);
    const bool vault = random() % 3 == 0;
    const int pieces = vault ? 4 + static_cast<int>(random() % 12) : 1;
    const double rise = between(random, 0.0005, 0.003);
    for (int k = 1; k <= pieces; ++k) {
      const double t = static_cast<double>(k) / pieces;
      ring(r + (next - r) * t + (vault ? 4.0 * rise * t * (1.0 - t) : 0.0), z + length * t);
    }
    z += length;
    r = next;
  }
  SoupBuilder builder;
  builder.bands(rings);
  builder.fan(rings.front(), {0.0, 0.0, 0.0}, SoupBuilder::Facing::down);
  builder.fan(rings.back(), {0.0, 0.0, z}, SoupBuilder::Facing::up);
  return shifted(std::move(builder.soup), {0.0, 0.0, -0.5 * z});
}

/// The way after a time along a length, at a speed that rises at the beginning and falls at the end.
double wayAfter(double time, double length, double speed) {
  const double t = std::max(time, 0.0), end = length / speed + PressPath::kBlend;
  const auto fromRest = [&](double since) {
    return since < PressPath::kBlend ? 0.5 * since * since / PressPath::kBlend
                                     : since - 0.5 * PressPath::kBlend;
  };
  return t < 0.5 * end ? speed * fromRest(t) : length - speed * fromRest(std::max(end - t, 0.0));
}

}  // namespace

assets::TriangleSoup blobSoup(std::mt19937& random, int n) {
  const Lumps lumps(random);
  const auto salt = static_cast<std::uint32_t>(random());
  // A corner is shared by faces, so what it is off by depends on its place alone.
  const auto corner = [&](int x, int y, int z) {
    const auto key = static_cast<std::uint32_t>(((x + n) * (2 * n + 1) + y + n) * (2 * n + 1) + z + n);
    Random own(key ^ salt);
    const glm::dvec3 off{between(own, -0.3, 0.3), between(own, -0.3, 0.3), between(own, -0.3, 0.3)};
    return lumps.at(glm::normalize(glm::dvec3(x, y, z) + off));
  };
  SoupBuilder builder;
  for (const int sx : {-1, 1})
    for (const int sy : {-1, 1})
      for (const int sz : {-1, 1}) {
        const auto at = [&](int i, int j) { return corner(sx * i, sy * j, sz * (n - i - j)); };
        const auto add = [&](const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
          if (sx * sy * sz > 0)
            builder.triangle(a, b, c);
          else
            builder.triangle(a, c, b);
        };
        for (int i = 0; i < n; ++i)
          for (int j = 0; i + j < n; ++j) {
            add(at(i, j), at(i + 1, j), at(i, j + 1));
            if (i + j + 1 < n) add(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
          }
      }
  return builder.soup;
}

const char* familyName(Family family) {
  constexpr const char* kNames[] = {"blobs", "blocks", "turned"};
  return kNames[static_cast<int>(family)];
}

assets::Mesh irregularMesh(Family family, unsigned seed) {
  Random random(seed * 3 + static_cast<unsigned>(family));
  assets::TriangleSoup soup;
  switch (family) {
    case Family::blobs:
      soup = blobSoup(random, std::array{5, 8, 12, 20, 40}[seed % 5]);
      break;
    case Family::blocks:
      soup = blockSoup(random);
      break;
    case Family::turned:
      soup = turnedSoup(random);
      break;
  }
  return assets::analyseMesh(std::move(soup), 0.5).mesh;
}

PressPath::PressPath(unsigned seed) {
  Random random(seed);
  const auto vector = [&](double size) {
    const double x = between(random, -size, size), y = between(random, -size, size);
    return glm::dvec3(x, y, between(random, -size, size));
  };
  lying_ = fromRotationVector(vector(3.0));
  start_.orientation = fromRotationVector(vector(3.0));
  const glm::dvec3 aside = vector(0.004);
  start_.position = {aside.x, aside.y, 0.0};
  rotation_ = vector(0.3);
  angle_ = between(random, 0.0, 6.0);
}

double PressPath::duration() const { return pressing() + kSlide / kSlideSpeed + kBlend + 0.02; }
double PressPath::pressing() const { return (kAbove + kPress) / kPressSpeed + kBlend; }

Pose PressPath::at(double time) const {
  const double down = wayAfter(time, kAbove + kPress, kPressSpeed);
  const double across = wayAfter(time - pressing(), kSlide, kSlideSpeed);
  return {start_.position + glm::dvec3(across * std::cos(angle_), across * std::sin(angle_), -down),
          fromRotationVector(rotation_ * (across / kSlide)) * start_.orientation};
}

}  // namespace tandem::generate
