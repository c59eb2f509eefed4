#include "tests/support/t_junction_meshes.h"

#include <algorithm>
#include <array>
#include <map>
#include <random>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "tests/support/soup_builder.h"

namespace tandem::test {
namespace {

using Place = std::array<double, 3>;
using Corners = std::array<glm::dvec3, 3>;
/// Places along the edges of a triangle, as shares from each edge's first corner, ascending.
using Shares = std::array<std::vector<double>, 3>;

Place placeOf(const glm::dvec3& p) { return {p.x, p.y, p.z}; }

class EdgeCutter {
 public:
  explicit EdgeCutter(const EdgeCuts& cuts) : cuts_(cuts), random_(cuts.seed) {}

  assets::TriangleSoup cut(const assets::TriangleSoup& clean) {
    // The triangles at each edge, whose shares are dealt when its first one is met.
    std::map<std::pair<Place, Place>, std::vector<std::pair<std::size_t, int>>> uses;
    for (std::size_t t = 0; t < clean.triangles.size(); ++t)
      for (int e = 0; e < 3; ++e) {
        const Place a = placeOf(clean.positions[clean.triangles[t][e]]),
                    b = placeOf(clean.positions[clean.triangles[t][(e + 1) % 3]]);
        uses[std::minmax(a, b)].emplace_back(t, e);
      }
    std::vector<Shares> shares(clean.triangles.size());
    for (const auto& [ends, sides] : uses) {
      if (sides.size() != 2 || !(uniform_(random_) < cuts_.share)) continue;
      const std::size_t first = uniform_(random_) < 0.5 ? 0 : 1;
      deal(shares[sides[first].first][sides[first].second]);
      if (cuts_.bothSides) deal(shares[sides[1 - first].first][sides[1 - first].second]);
    }
    for (std::size_t t = 0; t < clean.triangles.size(); ++t) {
      material_ = clean.triangleMaterial[t];
      const auto& c = clean.triangles[t];
      add({clean.positions[c[0]], clean.positions[c[1]], clean.positions[c[2]]}, shares[t]);
    }
    return std::move(out_);
  }

 private:
  void deal(std::vector<double>& shares) {
    const int count = 1 + static_cast<int>(uniform_(random_) * cuts_.most);
    const double near = 0.05 + 0.9 * uniform_(random_);
    for (int i = 0; i < count; ++i) {
      const double any = 0.02 + 0.96 * uniform_(random_);
      shares.push_back(cuts_.crowded ? near + 1e-3 * (any - 0.5) : any);
    }
    std::sort(shares.begin(), shares.end());
  }

  /// Cuts a triangle at the middle one of the places on an edge, and both halves again.
  void add(const Corners& c, const Shares& shares) {
    for (int e = 0; e < 3; ++e) {
      const std::vector<double>& here = shares[e];
      if (here.empty()) continue;
      const std::size_t middle = here.size() / 2;
      const double at = here[middle];
      const glm::dvec3 &a = c[e], &b = c[(e + 1) % 3], &apex = c[(e + 2) % 3];
      const glm::dvec3 p = a + at * (b - a);
      Shares before, after;
      for (std::size_t i = 0; i < middle; ++i) before[0].push_back(here[i] / at);
      for (std::size_t i = middle + 1; i < here.size(); ++i) after[0].push_back((here[i] - at) / (1.0 - at));
      before[2] = shares[(e + 2) % 3];
      after[1] = shares[(e + 1) % 3];
      add({a, p, apex}, before);
      add({p, b, apex}, after);
      return;
    }
    const auto first = static_cast<std::uint32_t>(out_.positions.size());
    out_.positions.insert(out_.positions.end(), c.begin(), c.end());
    out_.triangles.push_back({first, first + 1, first + 2});
    out_.triangleMaterial.push_back(material_);
  }

  const EdgeCuts& cuts_;
  std::mt19937 random_;
  std::uniform_real_distribution<double> uniform_{0.0, 1.0};
  assets::TriangleSoup out_;
  std::uint16_t material_ = 0;
};

}  // namespace

assets::TriangleSoup withTJunctions(const assets::TriangleSoup& clean, const EdgeCuts& cuts) {
  return EdgeCutter(cuts).cut(clean);
}

assets::TriangleSoup placed(assets::TriangleSoup soup, const glm::dmat3& turn, double scale,
                            const glm::dvec3& shift) {
  for (glm::dvec3& p : soup.positions) p = turn * (scale * p) + shift;
  return soup;
}

assets::TriangleSoup roundedToFloat(assets::TriangleSoup soup) {
  for (glm::dvec3& p : soup.positions) p = glm::dvec3(glm::vec3(p));
  return soup;
}

glm::dmat3 turnOf(std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  glm::dquat q(normal(random), normal(random), normal(random), normal(random));
  return glm::mat3_cast(glm::normalize(q));
}

assets::TriangleSoup twoStrips(double size, int below, int above, int rows, std::uint32_t seed) {
  SoupBuilder b;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-0.4, 0.4);
  for (const int side : {-1, 1}) {
    const int columns = side < 0 ? below : above;
    std::vector<double> x;
    for (int i = 0; i <= columns; ++i) {
      const double off = seed != 0 && i > 0 && i < columns ? uniform(random) : 0.0;
      x.push_back(size * ((i + off) / columns - 0.5));
    }
    for (int i = 0; i < columns; ++i)
      for (int j = 0; j < rows; ++j) {
        const double y0 = side * 0.5 * size * j / rows, y1 = side * 0.5 * size * (j + 1) / rows;
        const double low = std::min(y0, y1), high = std::max(y0, y1);
        b.quad({x[i], low, 0.0}, {x[i + 1], low, 0.0}, {x[i + 1], high, 0.0}, {x[i], high, 0.0});
      }
  }
  return b.soup;
}

}  // namespace tandem::test
