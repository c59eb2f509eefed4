// Cracks: T-junctions, rows that do not match, parts that lie flush, faces whose coordinates are rounded to
// float. A point must not go where a ball of 2^-20 of the coordinates does not.

#include <cmath>
#include <cstdlib>
#include <random>

#include <glm/gtc/quaternion.hpp>

#include "haptics/geometry/triangle_math.h"
#include "tests/haptics/hard_cases/hard_case.h"
#include "tests/support/full_size.h"
#include "tests/support/random_numbers.h"

namespace tandem::test {
namespace {

using Random = std::mt19937_64;

glm::dquat anyTurn(Random& random) {
  std::normal_distribution<double> normal;
  return glm::normalize(glm::dquat(normal(random), normal(random), normal(random), normal(random)));
}

int strokesAModel() { return atFullSize() ? 10'000 : 120; }

/// A convex solid: what the proxy must stay out of is known without its triangles.
struct Solid {
  assets::Scene scene;
  std::vector<glm::dvec4> faces;    // outward unit normal and offset: inside is n . x < offset for all
  std::vector<glm::dvec3> starts;   // where strokes begin, outside
  std::vector<glm::dvec3> targets;  // where they lead, inside
  double size = 0.0;                // m, largest coordinate

  double depthOf(const glm::dvec3& p) const {
    double depth = 1e300;
    for (const glm::dvec4& face : faces) depth = std::min(depth, face.w - glm::dot(glm::dvec3(face), p));
    return depth;
  }
};

/// Places points as a file does: turned, moved and rounded to float.
class Placer {
 public:
  Placer(Random& random, double scale, double away)
      : turn_(anyTurn(random)),
        scale_(scale),
        offset_(scale * away *
                glm::dvec3(between(random, -1, 1), between(random, -1, 1), between(random, -1, 1))) {}
  glm::dvec3 exact(const glm::dvec3& p) const { return turn_ * (scale_ * p) + offset_; }
  glm::dvec3 rounded(const glm::dvec3& p) const { return glm::dvec3(glm::vec3(exact(p))); }
  glm::dvec4 plane(const glm::dvec3& normal, double offset) const {
    const glm::dvec3 n = turn_ * normal;
    return {n, scale_ * offset + glm::dot(n, offset_)};
  }

 private:
  glm::dquat turn_;
  double scale_;
  glm::dvec3 offset_;
};

/// Triangles that share no vertices.
struct Soup {
  std::vector<glm::dvec3> positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;

  void triangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const auto first = static_cast<std::uint32_t>(positions.size());
    positions.insert(positions.end(), {a, b, c});
    triangles.push_back({first, first + 1, first + 2});
  }
  void quad(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d) {
    triangle(a, b, c);
    triangle(a, c, d);
  }
};

double furthest(const assets::Scene& scene) {
  double most = 0.0;
  for (const assets::Mesh& mesh : scene.meshes)
    for (const glm::dvec3& p : mesh.positions)
      most = std::max({most, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  return most;
}

constexpr double kHalf = 0.05;  // m, half the width of the planes and boxes

/// The upper side of a plane in columns with rows of their own, none of which match: T-junctions everywhere.
Solid columns(Random& random, double scale, int count) {
  const Placer placer(random, scale, 0.1);
  Soup soup;
  for (int column = 0; column < count; ++column) {
    const double width = 2.0 * kHalf / count, x0 = -kHalf + width * column, x1 = x0 + width;
    const int rows = 2 + static_cast<int>(random() % 30);
    std::vector<double> cuts;
    for (int row = 1; row < rows; ++row) cuts.push_back(between(random, -kHalf, kHalf));
    cuts.push_back(-kHalf);
    cuts.push_back(kHalf);
    std::sort(cuts.begin(), cuts.end());
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
      const auto at = [&](double x, double y) { return placer.rounded({x, y, 0.0}); };
      soup.quad(at(x0, cuts[i]), at(x1, cuts[i]), at(x1, cuts[i + 1]), at(x0, cuts[i + 1]));
    }
  }
  Solid solid;
  solid.scene = sceneOf(soupMesh(soup.positions, soup.triangles));
  solid.faces.push_back(placer.plane({0.0, 0.0, 1.0}, 0.0));
  for (int i = 0; i < 64; ++i) {
    const double x = between(random, -0.7, 0.7) * kHalf, y = between(random, -0.7, 0.7) * kHalf;
    solid.starts.push_back(placer.exact({x, y, between(random, 0.001, 0.02)}));
    solid.targets.push_back(placer.exact(
        {x + between(random, -0.01, 0.01), y + between(random, -0.01, 0.01), -between(random, 1e-4, 0.004)}));
  }
  return solid;
}

/// Splits a square into columns of rows that match neither each other nor those of other squares.
void addFace(Soup& soup, Random& random, const Placer& placer, const glm::dvec3& corner, const glm::dvec3& u,
             const glm::dvec3& v) {
  const int count = 1 + static_cast<int>(random() % 6);
  for (int i = 0; i < count; ++i) {
    const double a = 1.0 * i / count, b = 1.0 * (i + 1) / count;
    const int rows = 1 + static_cast<int>(random() % 9);
    for (int j = 0; j < rows; ++j) {
      const double c = 1.0 * j / rows, d = 1.0 * (j + 1) / rows;
      const auto at = [&](double x, double y) { return placer.rounded(corner + x * u + y * v); };
      soup.quad(at(a, c), at(b, c), at(b, d), at(a, d));
    }
  }
}

void addBox(Soup& soup, Random& random, const Placer& placer, const glm::dvec3& low, const glm::dvec3& high) {
  const glm::dvec3 size = high - low;
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 u(0.0), v(0.0), w(0.0);
    u[(axis + 1) % 3] = size[(axis + 1) % 3];
    v[(axis + 2) % 3] = size[(axis + 2) % 3];
    w[axis] = size[axis];
    addFace(soup, random, placer, low, v, u);
    addFace(soup, random, placer, low + w, u, v);
  }
}

/// Strokes between points around a box and points in it.
void addBoxStrokes(Solid& solid, Random& random, const Placer& placer, const glm::dvec3& half) {
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 normal(0.0);
    normal[axis] = 1.0;
    solid.faces.push_back(placer.plane(normal, half[axis]));
    solid.faces.push_back(placer.plane(-normal, half[axis]));
  }
  for (int i = 0; i < 64; ++i) {
    glm::dvec3 start, target;
    for (int axis = 0; axis < 3; ++axis) {
      start[axis] = between(random, -1.3, 1.3) * half[axis];
      target[axis] = between(random, -0.9, 0.9) * half[axis];
    }
    const auto side = static_cast<int>(random() % 3);
    start[side] = (random() % 2 != 0 ? 1.0 : -1.0) * between(random, 1.02, 1.4) * half[side];
    solid.starts.push_back(placer.exact(start));
    solid.targets.push_back(placer.exact(target));
  }
}

/// A closed box of rounded faces none of whose vertices match, up to ten times its size from its origin.
Solid roundedBox(Random& random, double scale, int seed) {
  const glm::dvec3 half(kHalf, 0.7 * kHalf, 0.4 * kHalf);
  const Placer placer(random, scale, seed % 2 == 0 ? 0.05 : 1.0);
  Soup soup;
  addBox(soup, random, placer, -half, half);
  Solid solid;
  solid.scene = sceneOf(soupMesh(soup.positions, soup.triangles));
  addBoxStrokes(solid, random, placer, half);
  return solid;
}

/// Eight boxes, parts of their own, that fill a larger one but for gaps.
Solid flushBoxes(Random& random, double scale, double gap) {
  const glm::dvec3 half(kHalf);
  const glm::dquat turn = anyTurn(random);
  SceneBuilder b;
  const std::uint32_t mesh = b.addMesh(scaledMesh(boxMesh(glm::dvec3(kHalf - 0.5 * gap)), scale));
  for (int i = 0; i < 8; ++i) {
    const glm::dvec3 side((i & 1) != 0 ? 0.5 : -0.5, (i & 2) != 0 ? 0.5 : -0.5, (i & 4) != 0 ? 0.5 : -0.5);
    b.addPart(mesh, {turn * (scale * kHalf * side), turn});
  }
  Solid solid;
  solid.scene = b.scene;
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 normal(0.0);
    normal[axis] = 1.0;
    solid.faces.push_back({turn * normal, scale * kHalf});
    solid.faces.push_back({turn * -normal, scale * kHalf});
  }
  for (int i = 0; i < 64; ++i) {
    // From above one of the joints into it.
    glm::dvec3 start(between(random, -0.9, 0.9), between(random, -1e-6, 1e-6), between(random, 1.05, 1.4));
    glm::dvec3 target(start.x, 0.0, between(random, 0.2, 0.95));
    if (i % 4 == 0)
      target = start = glm::dvec3(between(random, -0.9, 0.9), between(random, -0.9, 0.9), start.z);
    if (i % 4 == 0) target.z = 0.5;
    const auto axis = static_cast<int>(random() % 3);
    const auto turned = [&](const glm::dvec3& p) {
      return turn * (scale * kHalf * glm::dvec3(p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]));
    };
    solid.starts.push_back(turned(start));
    solid.targets.push_back(turned(target));
  }
  return solid;
}

/// Runs strokes of a point from outside into a solid, back and forth, fast and slow.
class Strokes {
 public:
  Strokes(const Solid& solid, double leastToolShare)
      : solid_(solid),
        contact_(solid.scene, 1, leastToolShare),
        state_(contact_),
        parameters_(springOnly()) {}

  /// Of `count` strokes, how many went into the solid deeper than `allowed` m.
  int fallen(Random& random, int count, double allowed) {
    int fallen = 0;
    for (int i = 0; i < count; ++i) fallen += stroke(random, allowed) ? 1 : 0;
    return fallen;
  }
  double deepest() const { return deepest_; }
  double felt() const { return felt_; }
  double nearest() const { return nearest_; }

 private:
  bool stroke(Random& random, double allowed) {
    const auto& from = solid_.starts[random() % solid_.starts.size()];
    begin(from);
    bool fell = false;
    glm::dvec3 last = from;
    for (int leg = 0; leg < 4; ++leg) {
      const auto& list = leg % 2 == 0 ? solid_.targets : solid_.starts;
      const glm::dvec3 next = leg == 3   ? from
                              : leg == 0 ? list[&from - solid_.starts.data()]
                                         : list[random() % list.size()];
      const int ticks = 1 + static_cast<int>(std::exp(between(random, 0.0, 4.0)));
      for (int i = 1; i <= ticks; ++i) fell = moveTo(glm::mix(last, next, 1.0 * i / ticks), allowed) || fell;
      if (leg == 1) checkRoom();
      last = next;
    }
    return fell;
  }

  /// A hand that was not seen for a while is where it is.
  void begin(const glm::dvec3& at) {
    haptics::DeviceSample away;
    for (int i = 0; i < 260; ++i) tick(away);
    moveTo(at, 1e300);
  }

  haptics::TickOutput tick(const haptics::DeviceSample& sample) {
    haptics::TickInput input;
    input.hands[0].device = sample;
    return haptics::tick(input, contact_, parameters_, state_);
  }

  bool moveTo(const glm::dvec3& at, double allowed) {
    haptics::DeviceSample sample;
    sample.valid = true;
    sample.worldFromDevice.position = at;
    const haptics::TickOutput out = tick(sample);
    proxy_ = state_.data().tool.proxy().position;
    const double depth = solid_.depthOf(proxy_);
    felt_ = std::max(felt_, solid_.depthOf(out.worldFromProxy.position));
    deepest_ = std::max(deepest_, depth);
    return depth > allowed;
  }

  /// The distance to the nearest of all triangles, asked of each.
  void checkRoom() {
    for (const assets::Part& part : solid_.scene.parts) {
      const assets::Mesh& mesh = solid_.scene.meshes[part.mesh];
      const glm::dvec3 p =
          glm::conjugate(part.worldFromPart.orientation) * (proxy_ - part.worldFromPart.position);
      for (const auto& t : mesh.triangles) {
        const haptics::Triangle corners{mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]};
        nearest_ = std::min(nearest_, glm::length(p - haptics::closestPointOnTriangle(p, corners).point));
      }
    }
  }

  const Solid& solid_;
  haptics::ContactScene contact_;
  haptics::TickState state_;
  haptics::TickParameters parameters_;
  glm::dvec3 proxy_{0.0};
  double deepest_ = -1e300, felt_ = -1e300, nearest_ = 1e300;
};

/// Strokes of a family at every scale and several seeds: no stroke falls with the radius of a point, some do
/// without it.
template <typename Make>
void strokeFamily(int seeds, const Make& make) {
  int fallenWithout = 0;
  for (const double scale : kScales) {
    for (int seed = 0; seed < seeds; ++seed) {
      Random random(static_cast<std::uint64_t>(seed) + 1);
      const Solid solid = make(random, scale, seed);
      const double coordinates = furthest(solid.scene);
      // The faces themselves are off by the rounding of their coordinates.
      const double allowed = 0x1p-22 * coordinates;
      Strokes point(solid, haptics::kLeastToolShare);
      EXPECT_EQ(point.fallen(random, strokesAModel(), allowed), 0)
          << "scale " << scale << " seed " << seed << " deepest " << point.deepest() / coordinates;
      EXPECT_LE(point.felt(), 0x1p-18 * coordinates) << "scale " << scale << " seed " << seed;
      EXPECT_GE(point.nearest(), 0x1p-20 * coordinates) << "scale " << scale << " seed " << seed;
      Strokes without(solid, 0.0);
      fallenWithout += without.fallen(random, 60, allowed);
    }
  }
  EXPECT_GT(fallenWithout, 0) << "a point without a radius must fall";
}

TEST(HardCracks, APointDoesNotFallThroughTJunctions) {
  strokeFamily(4, [](Random& random, double scale, int) { return columns(random, scale, 20); });
}

TEST(HardCracks, APointDoesNotFallBetweenStripsWhoseRowsDoNotMatch) {
  strokeFamily(4, [](Random& random, double scale, int) { return columns(random, scale, 2); });
}

TEST(HardCracks, APointDoesNotFallIntoABoxOfRoundedFaces) {
  strokeFamily(6, [](Random& random, double scale, int seed) { return roundedBox(random, scale, seed); });
}

TEST(HardCracks, APointDoesNotFallBetweenFlushParts) {
  for (const double gap : {1e-9, 1e-8, 1e-7}) {
    SCOPED_TRACE(gap);
    strokeFamily(2, [gap](Random& random, double scale, int) { return flushBoxes(random, scale, gap); });
  }
}

}  // namespace
}  // namespace tandem::test
