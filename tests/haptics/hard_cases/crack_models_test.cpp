// Strokes of a point through real CAD (the folder TANDEM_DATA). Its openings are of all sizes, and which way
// a tool takes round a corner is a matter of last digits; but a point comes into no more parts than a ball of
// 2^-20 of the coordinates.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>

#include "assets/gltf/load_gltf.h"
#include "haptics/tick_data.h"
#include "tests/haptics/hard_cases/hard_case.h"

namespace tandem::test {
namespace {

using Random = std::mt19937_64;

double between(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

glm::dvec3 within(Random& random, const assets::Bounds& box, double share) {
  const glm::dvec3 centre = 0.5 * (box.min + box.max), half = 0.5 * share * (box.max - box.min);
  return centre + half * glm::dvec3(between(random, -1, 1), between(random, -1, 1), between(random, -1, 1));
}

/// Winding number of a mesh around p from the solid angle of every triangle (van Oosterom & Strackee 1983,
/// "The solid angle of a plane triangle").
double windingNumber(const assets::Mesh& mesh, const glm::dvec3& p) {
  double sum = 0.0;
  for (const auto& t : mesh.triangles) {
    const glm::dvec3 a = mesh.positions[t[0]] - p, b = mesh.positions[t[1]] - p, c = mesh.positions[t[2]] - p;
    const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
    sum += std::atan2(glm::dot(a, glm::cross(b, c)),
                      la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
  }
  return sum / (2.0 * kPi);
}

/// The corners of a stroke and how many ticks each leg takes.
struct Stroke {
  std::vector<glm::dvec3> corners;
  std::vector<int> ticks;
};

Stroke anyStroke(Random& random, const assets::Bounds& box) {
  Stroke stroke;
  glm::dvec3 from = within(random, box, 1.2);
  const auto axis = static_cast<int>(random() % 3);
  const double far = 0.05 * (box.max - box.min)[axis];
  from[axis] = random() % 2 == 0 ? box.min[axis] - far : box.max[axis] + far;
  stroke.corners = {from, within(random, box, 0.9), within(random, box, 0.9), from};
  for (int leg = 0; leg < 3; ++leg) {
    stroke.ticks.push_back(1 + static_cast<int>(std::exp(between(random, 0.0, 5.0))));
  }
  return stroke;
}

/// A tool in a scene, which tells in which parts it comes to be.
class Stroker {
 public:
  Stroker(const assets::Scene& scene, double radius, double leastToolShare)
      : scene_(scene), contact_(scene, 0, leastToolShare), state_(contact_) {
    tool_.toolRadius = radius;
  }

  /// The parts in which the tool is at the end of a leg.
  std::vector<PartId> partsEntered(const Stroke& stroke) {
    for (int i = 0; i < 260; ++i) tick({});
    std::vector<PartId> entered;
    move(stroke.corners[0]);
    for (std::size_t leg = 0; leg < stroke.ticks.size(); ++leg) {
      const double n = stroke.ticks[leg];
      for (int i = 1; i <= stroke.ticks[leg]; ++i) {
        move(glm::mix(stroke.corners[leg], stroke.corners[leg + 1], i / n));
      }
      findParts(entered);
    }
    return entered;
  }

 private:
  void move(const glm::dvec3& at) {
    haptics::DeviceSample sample;
    sample.valid = true;
    sample.worldFromDevice.position = at;
    tick(sample);
  }

  void tick(const haptics::DeviceSample& sample) {
    haptics::TickInput input;
    input.hands[0].device = sample;
    haptics::tick(input, contact_, tool_, state_);
  }

  void findParts(std::vector<PartId>& entered) {
    const glm::dvec3& world = state_.data().tool.proxy().position;
    for (PartId i = 0; i < scene_.parts.size(); ++i) {
      const assets::Part& part = scene_.parts[i];
      if (part.mesh == assets::kNone) continue;
      const assets::Mesh& mesh = scene_.meshes[part.mesh];
      const glm::dvec3 p =
          glm::conjugate(part.worldFromPart.orientation) * (world - part.worldFromPart.position);
      const bool near =
          glm::all(glm::greaterThan(p, mesh.bounds.min)) && glm::all(glm::lessThan(p, mesh.bounds.max));
      if (near && windingNumber(mesh, p) > 0.5) entered.push_back(i);
    }
  }

  const assets::Scene& scene_;
  haptics::ContactScene contact_;
  haptics::TickState state_;
  haptics::TickParameters tool_ = springOnly();
};

/// The largest coordinate of any mesh, m.
double coordinatesOf(const assets::Scene& scene) {
  double largest = 0.0;
  for (const assets::Mesh& mesh : scene.meshes) {
    const glm::dvec3 most = glm::max(glm::abs(mesh.bounds.min), glm::abs(mesh.bounds.max));
    largest = std::max({largest, most.x, most.y, most.z});
  }
  return largest;
}

/// Of `count` strokes, how many come into a part.
int strokesIntoParts(const assets::Scene& scene, double radius, double leastToolShare, int count) {
  Stroker tool(scene, radius, leastToolShare);
  Random random(7);
  int entered = 0;
  for (int i = 0; i < count; ++i) {
    entered += tool.partsEntered(anyStroke(random, scene.bounds)).empty() ? 0 : 1;
  }
  return entered;
}

class CrackModels : public testing::TestWithParam<const char*> {};

TEST_P(CrackModels, APointDoesNotFallThroughRealCad) {
  const char* data = std::getenv("TANDEM_DATA");
  if (data == nullptr) GTEST_SKIP() << "TANDEM_DATA is not set";
  const int strokes = std::getenv("TANDEM_FULL_SIZE") != nullptr ? 10'000 : 200;
  for (const double unit : {1e-3, 1.0}) {
    assets::LoadOptions load;
    load.unitScale = unit;
    const auto scene = assets::loadGltf(std::string(data) + "/" + GetParam(), load);
    if (!scene.ok()) GTEST_SKIP() << scene.error().message;
    const int point = strokesIntoParts(*scene, 0.0, haptics::kLeastToolShare, strokes);
    const int ball = strokesIntoParts(*scene, 0x1p-20 * coordinatesOf(*scene), 0.0, strokes);
    const int without = strokesIntoParts(*scene, 0.0, 0.0, strokes);
    std::printf(
        "%s, %g m a unit: of %d strokes %d of a point come into a part, %d of a ball of 2^-20, %d of a "
        "point without a least radius\n",
        GetParam(), unit, strokes, point, ball, without);
    EXPECT_LE(point, ball) << "unit " << unit;
    if (ball > 0) EXPECT_GT(without, ball) << "unit " << unit;
  }
}

INSTANTIATE_TEST_SUITE_P(Files, CrackModels,
                         testing::Values("2CylinderEngine.glb", "factory_rect_8mm_tight.glb",
                                         "m16_nut_bolt_loose.glb", "round_peg_hole_16mm.glb"));

}  // namespace
}  // namespace tandem::test
