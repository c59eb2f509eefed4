// Strokes of a point through real CAD (the folder TANDEM_DATA). Some of its meshes are open, and a point
// comes into them through openings of all sizes; but it goes nowhere where a ball of 2^-20 of the coordinates
// could not follow it in one continuous motion.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

#include "assets/gltf/load_gltf.h"
#include "haptics/measure/path_clearance.h"
#include "haptics/proxy/proxy_trace.h"
#include "haptics/tick_data.h"
#include "tests/haptics/hard_cases/hard_case.h"
#include "tests/support/full_size.h"
#include "tests/support/random_numbers.h"
#include "tests/support/winding_number.h"

namespace tandem::test {
namespace {

using haptics::PathClearance;
using Random = std::mt19937_64;

glm::dvec3 within(Random& random, const assets::Bounds& box, double share) {
  const glm::dvec3 centre = 0.5 * (box.min + box.max), half = 0.5 * share * (box.max - box.min);
  return centre + half * glm::dvec3(between(random, -1, 1), between(random, -1, 1), between(random, -1, 1));
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

/// What a stroke did.
struct Journey {
  bool entered = false;        // a leg ended in some part
  bool enteredClosed = false;  // in one whose mesh is closed
  bool likeABall = true;       // a ball could have gone the same way
};

/// A tool in a scene, with the path that it takes.
class Stroker {
 public:
  Stroker(const assets::Scene& scene, const PathClearance& clearance, double leastToolShare)
      : scene_(scene), clearance_(clearance), contact_(scene, 0, leastToolShare), state_(contact_) {
    haptics::proxyTrace = &moves_;
  }
  ~Stroker() { haptics::proxyTrace = nullptr; }
  Stroker(const Stroker&) = delete;
  Stroker& operator=(const Stroker&) = delete;

  /// Strokes with the path checked against a ball of `share` of each part's coordinates.
  Journey run(const Stroke& stroke, double share) {
    for (int i = 0; i < 260; ++i) tick({});
    Journey journey;
    move(stroke.corners[0]);
    for (std::size_t leg = 0; leg < stroke.ticks.size(); ++leg) {
      const double n = stroke.ticks[leg];
      for (int i = 1; i <= stroke.ticks[leg]; ++i) {
        const glm::dvec3 from = proxy_;
        move(glm::mix(stroke.corners[leg], stroke.corners[leg + 1], i / n));
        journey.likeABall = journey.likeABall && ballReaches(from, share);
      }
      noteParts(journey);
    }
    return journey;
  }

 private:
  void move(const glm::dvec3& at) {
    haptics::DeviceSample sample;
    sample.valid = true;
    sample.worldFromDevice.position = at;
    moves_.clear();
    tick(sample);
  }

  void tick(const haptics::DeviceSample& sample) {
    haptics::TickInput input;
    input.hands[0].device = sample;
    haptics::tick(input, contact_, tool_, state_);
    proxy_ = state_.data().tool.proxy().position;
  }

  /// Whether those moves of the last tick along which the ball fits lead from `from` to the proxy.
  bool ballReaches(const glm::dvec3& from, double share) const {
    std::vector<glm::dvec3> reached{from};
    const auto isReached = [&](const glm::dvec3& p) {
      return std::find(reached.begin(), reached.end(), p) != reached.end();
    };
    for (const haptics::ProxyMove& move : moves_) {
      if (isReached(move.from) && clearance_.ballPasses(move.from, move.to, share))
        reached.push_back(move.to);
    }
    return isReached(proxy_);
  }

  void noteParts(Journey& journey) const {
    for (const assets::Part& part : scene_.parts) {
      if (part.mesh == assets::kNone) continue;
      const assets::Mesh& mesh = scene_.meshes[part.mesh];
      const glm::dvec3 p =
          glm::conjugate(part.worldFromPart.orientation) * (proxy_ - part.worldFromPart.position);
      const bool near =
          glm::all(glm::greaterThan(p, mesh.bounds.min)) && glm::all(glm::lessThan(p, mesh.bounds.max));
      if (!near || windingNumber(mesh, p) <= 0.5) continue;
      journey.entered = true;
      journey.enteredClosed = journey.enteredClosed || mesh.closed;
    }
  }

  const assets::Scene& scene_;
  const PathClearance& clearance_;
  haptics::ContactScene contact_;
  haptics::TickState state_;
  haptics::TickParameters tool_ = springOnly();
  std::vector<haptics::ProxyMove> moves_;  // of the last tick
  glm::dvec3 proxy_{0.0};
};

struct Count {
  int entered = 0, enteredClosed = 0;
  int fallen = 0;  // went where the ball does not
};

Count strokesOf(const assets::Scene& scene, double leastToolShare, int strokes) {
  const PathClearance clearance(scene);
  Stroker tool(scene, clearance, leastToolShare);
  Random random(7);
  Count count;
  for (int i = 0; i < strokes; ++i) {
    const Journey journey = tool.run(anyStroke(random, scene.bounds), haptics::kLeastToolShare);
    count.entered += journey.entered ? 1 : 0;
    count.enteredClosed += journey.enteredClosed ? 1 : 0;
    count.fallen += journey.likeABall ? 0 : 1;
  }
  return count;
}

class CrackModels : public testing::TestWithParam<const char*> {};

TEST_P(CrackModels, APointGoesNowhereWhereABallDoesNot) {
  const char* data = std::getenv("TANDEM_DATA");
  if (data == nullptr) GTEST_SKIP() << "TANDEM_DATA is not set";
  const bool fullSize = atFullSize();
  for (const double unit : {1e-3, 1.0, 1e3}) {
    SCOPED_TRACE(unit);
    assets::LoadOptions load;
    load.unitScale = unit;
    const auto scene = assets::loadGltf(std::string(data) + "/" + GetParam(), load);
    if (!scene.ok()) GTEST_SKIP() << scene.error().message;
    const int strokes = !fullSize ? 60 : unit == 1e-3 ? 10'000 : 1000;
    const Count point = strokesOf(*scene, haptics::kLeastToolShare, strokes);
    EXPECT_EQ(point.fallen, 0);
    EXPECT_EQ(point.enteredClosed, 0);
    const Count bare = strokesOf(*scene, 0.0, 20);
    EXPECT_GT(bare.fallen, 0) << "a point without a least radius goes where no ball does";
    std::printf("%s, %g m a unit: of %d strokes %d come into an open part, %d go where no ball does\n",
                GetParam(), unit, strokes, point.entered, point.fallen);
  }
}

INSTANTIATE_TEST_SUITE_P(Files, CrackModels,
                         testing::Values("2CylinderEngine.glb", "factory_rect_8mm_tight.glb",
                                         "m16_nut_bolt_loose.glb", "round_peg_hole_16mm.glb"));

}  // namespace
}  // namespace tandem::test
