#include "client/report/stroke_sweep.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>
#include <tuple>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "client/report/bare_spring.h"
#include "client/report/measurement.h"
#include "haptics/geometry/winding_tree.h"
#include "haptics/measure/path_clearance.h"
#include "haptics/proxy/proxy_trace.h"
#include "haptics/scene/contact_scene.h"
#include "haptics/tick.h"
#include "haptics/tick_data.h"

namespace tandem::client::report {
namespace {

using Clock = std::chrono::steady_clock;
using Random = std::mt19937_64;

constexpr double kStiffness = 1000.0;  // N/m
constexpr int kUnseen = 260;           // ticks without a device, after which the point begins anew
constexpr int kLongestLeg = 150;       // ticks

/// From 0 to 1; the standard's distributions differ from library to library.
double draw(Random& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

glm::dvec3 placeIn(Random& random, const assets::Bounds& box, double share) {
  glm::dvec3 place = 0.5 * (box.min + box.max);
  for (int axis = 0; axis < 3; ++axis)
    place[axis] += 0.5 * share * (box.max - box.min)[axis] * (2.0 * draw(random) - 1.0);
  return place;
}

/// A device's path and the ticks in which its legs end.
struct Stroke {
  std::vector<glm::dvec3> path;
  std::vector<std::size_t> legEnds;
};
using Strokes = std::vector<Stroke>;

/// From outside to two places within and back, each leg at a speed of its own.
Stroke anyStroke(Random& random, const assets::Bounds& box) {
  glm::dvec3 from = placeIn(random, box, 1.2);
  const auto axis = static_cast<int>(random() % 3);
  const double far = 0.05 * (box.max - box.min)[axis];
  from[axis] = random() % 2 == 0 ? box.min[axis] - far : box.max[axis] + far;
  const glm::dvec3 first = placeIn(random, box, 0.9), second = placeIn(random, box, 0.9);
  const glm::dvec3 corners[] = {from, first, second, from};
  Stroke stroke{{from}, {}};
  for (int leg = 0; leg < 3; ++leg) {
    const int ticks = 1 + static_cast<int>(std::pow(kLongestLeg, draw(random)));
    for (int i = 1; i <= ticks; ++i)
      stroke.path.push_back(glm::mix(corners[leg], corners[leg + 1], static_cast<double>(i) / ticks));
    stroke.legEnds.push_back(stroke.path.size() - 1);
  }
  return stroke;
}

/// Records the proxy's moves while it exists.
class Trace {
 public:
  Trace() { haptics::proxyTrace = &moves_; }
  ~Trace() { haptics::proxyTrace = nullptr; }
  Trace(const Trace&) = delete;
  Trace& operator=(const Trace&) = delete;
  std::vector<haptics::ProxyMove>& moves() { return moves_; }

 private:
  std::vector<haptics::ProxyMove> moves_;
};

/// A point in a scene.
class Stroker {
 public:
  explicit Stroker(const haptics::ContactScene& contact) : contact_(contact), state_(contact) {}

  void begin() {
    for (int i = 0; i < kUnseen; ++i) tick({});
  }
  void move(const glm::dvec3& at) {
    haptics::DeviceSample sample;
    sample.valid = true;
    sample.worldFromDevice.position = at;
    tick(sample);
  }
  glm::dvec3 proxy() { return state_.data().tool.proxy().position; }

 private:
  void tick(const haptics::DeviceSample& sample) {
    haptics::TickInput input;
    input.hands[0].device = sample;
    haptics::tick(input, contact_, parameters_, state_);
  }

  const haptics::ContactScene& contact_;
  const haptics::TickParameters parameters_ = bareSpring(kStiffness);
  haptics::TickState state_;
};

/// Whether those moves of a tick along which the ball fits lead from `from` to `to`.
bool ballReaches(const haptics::PathClearance& clearance, const std::vector<haptics::ProxyMove>& moves,
                 const glm::dvec3& from, const glm::dvec3& to) {
  std::vector<glm::dvec3> reached{from};
  const auto isReached = [&](const glm::dvec3& p) {
    return std::find(reached.begin(), reached.end(), p) != reached.end();
  };
  for (const haptics::ProxyMove& move : moves)
    if (isReached(move.from) && clearance.ballPasses(move.from, move.to, haptics::kLeastToolShare))
      reached.push_back(move.to);
  return isReached(to);
}

/// The winding number of a mesh around p, asked of every triangle.
double windingNumber(const assets::Mesh& mesh, const glm::dvec3& p) {
  double sum = 0.0;
  for (const auto& t : mesh.triangles)
    sum += haptics::windingOfTriangle(p, {mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]});
  return sum;
}

bool isInAPart(const assets::Scene& scene, const glm::dvec3& at) {
  return std::any_of(scene.parts.begin(), scene.parts.end(), [&](const assets::Part& part) {
    if (part.mesh == assets::kNone) return false;
    const assets::Mesh& mesh = scene.meshes[part.mesh];
    const glm::dvec3 p = glm::conjugate(part.worldFromPart.orientation) * (at - part.worldFromPart.position);
    return glm::all(glm::greaterThan(p, mesh.bounds.min)) && glm::all(glm::lessThan(p, mesh.bounds.max)) &&
           windingNumber(mesh, p) > 0.5;
  });
}

void judgeStrokes(const assets::Scene& scene, const haptics::ContactScene& contact, const Strokes& strokes,
                  StrokeMeasurement& out) {
  const haptics::PathClearance clearance(scene);
  Stroker point(contact);
  Trace trace;
  for (const Stroke& stroke : strokes) {
    point.begin();
    point.move(stroke.path.front());
    bool likeABall = true, inside = false;
    for (std::size_t i = 1; i < stroke.path.size(); ++i) {
      const glm::dvec3 from = point.proxy();
      trace.moves().clear();
      point.move(stroke.path[i]);
      likeABall = likeABall && ballReaches(clearance, trace.moves(), from, point.proxy());
      if (std::find(stroke.legEnds.begin(), stroke.legEnds.end(), i) != stroke.legEnds.end())
        inside = inside || isInAPart(scene, point.proxy());
    }
    out.fallen += likeABall ? 0 : 1;
    out.inside += inside ? 1 : 0;
  }
}

Cost timed(const haptics::ContactScene& contact, const Strokes& strokes, int runs) {
  std::vector<double> least, single;
  for (int run = 0; run < runs; ++run) {
    Stroker point(contact);
    std::size_t at = 0;
    for (const Stroke& stroke : strokes) {
      point.begin();
      for (const glm::dvec3& device : stroke.path) {
        const Clock::time_point start = Clock::now();
        point.move(device);
        const double us = std::chrono::duration<double, std::micro>(Clock::now() - start).count();
        if (run == 0) single.push_back(us);
        if (run == 0)
          least.push_back(us);
        else
          least[at] = std::min(least[at], us);
        ++at;
      }
    }
  }
  return costOf(least, single);
}

}  // namespace

StrokeResult sweepStrokes(const StrokedModel& model, int count, int runs) {
  const assets::Scene& scene = *model.scene;
  StrokeResult result;
  result.model = model.name;
  result.triangles = assets::triangleCount(scene);
  result.parts = scene.parts.size();
  result.strokes = count;
  Random random(7);
  Strokes strokes;
  for (int i = 0; i < count; ++i) {
    strokes.push_back(anyStroke(random, scene.bounds));
    result.ticks += strokes.back().path.size();
  }
  for (const auto& [setting, name, leastShare] : {std::tuple{"tandem", "Tandem", haptics::kLeastToolShare},
                                                  {"bare", "no least radius (control)", 0.0}}) {
    const haptics::ContactScene contact(scene, 0, leastShare);
    StrokeMeasurement& out = result.settings.emplace_back();
    out.setting = setting;
    out.name = name;
    judgeStrokes(scene, contact, strokes, out);
    out.cost = timed(contact, strokes, runs);
  }
  return result;
}

}  // namespace tandem::client::report
