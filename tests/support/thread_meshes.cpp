// Threads: a helical grid along the profile's corners, cut off flat at both ends.

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "assets/base/constants.h"
#include "tests/support/part_meshes.h"
#include "tests/support/soup_builder.h"

namespace tandem::test {
namespace {

constexpr double kOnPlane = 1e-6;  // of a point's distance from the origin

/// A sheet of shared points.
struct Sheet {
  std::vector<glm::dvec3> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// What of a sheet is above (side 1) or below (side -1) the plane of a height; points on the cut have exactly
/// that height. Fills `rim` with them.
Sheet cutOff(Sheet sheet, double height, double side, Ring& rim) {
  // Points that are on the plane but for rounding are put onto it: no sliver narrower than the welding.
  for (glm::dvec3& p : sheet.points) {
    if (std::abs(p.z - height) < kOnPlane * glm::length(p)) p.z = height;
  }
  Sheet out{sheet.points, {}};
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> cuts;
  const auto above = [&](std::uint32_t v) { return side * (sheet.points[v].z - height); };
  const auto cut = [&](std::uint32_t a, std::uint32_t b) {
    const auto [entry, isNew] =
        cuts.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(out.points.size()));
    if (isNew) {
      const double s = above(a) / (above(a) - above(b));
      glm::dvec3 p = glm::mix(sheet.points[a], sheet.points[b], s);
      p.z = height;
      out.points.push_back(p);
      rim.push_back(p);
    }
    return entry->second;
  };
  for (const auto& t : sheet.triangles) {
    std::vector<std::uint32_t> kept;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = t[i], b = t[(i + 1) % 3];
      if (above(a) > 0.0) kept.push_back(a);
      if ((above(a) > 0.0) != (above(b) > 0.0)) kept.push_back(cut(a, b));
    }
    for (std::size_t i = 2; i < kept.size(); ++i) out.triangles.push_back({kept[0], kept[i - 1], kept[i]});
  }
  return out;
}

void sortByAngle(Ring& ring) {
  std::sort(ring.begin(), ring.end(), [](const glm::dvec3& a, const glm::dvec3& b) {
    return std::atan2(a.y, a.x) < std::atan2(b.y, b.x);
  });
}

/// Heights of the profile's steps within a pitch, from the middle of the major flat on.
std::vector<double> stepsOf(const Thread& thread) {
  const double p = thread.pitch, flank = 5.0 / 16.0 * p, top = p / 16.0;
  std::vector<double> steps;
  for (int i = 0; i <= thread.perPitch; ++i) steps.push_back(top + flank * i / thread.perPitch);
  for (int i = 0; i <= thread.perPitch; ++i) steps.push_back(p - top - flank + flank * i / thread.perPitch);
  return steps;
}

/// The thread's surface, outside away from the axis, longer than the thread by a turn or more at both ends.
Sheet helix(const Thread& thread, int segments, double stretch) {
  const std::vector<double> steps = stepsOf(thread);
  const int perTurn = static_cast<int>(steps.size());
  const int turns = static_cast<int>(std::ceil(thread.length / thread.pitch)) + 5;
  const auto count = turns * perTurn;
  Sheet sheet;
  for (int k = 0; k < count; ++k) {
    const double u = thread.pitch * (k / perTurn - 2) + steps[static_cast<std::size_t>(k % perTurn)];
    const double r = stretch * threadProfile(thread, u);
    for (int i = 0; i < segments; ++i) {
      const double angle = 2.0 * kPi * i / segments;
      sheet.points.emplace_back(r * std::cos(angle), r * std::sin(angle), u + thread.pitch * i / segments);
    }
  }
  // After a turn the grid meets itself one pitch higher.
  const auto at = [&](int k, int i) {
    return static_cast<std::uint32_t>((i == segments ? k + perTurn : k) * segments + i % segments);
  };
  for (int k = 0; k + 1 + perTurn < count; ++k) {
    for (int i = 0; i < segments; ++i) {
      sheet.triangles.push_back({at(k, i), at(k, i + 1), at(k + 1, i + 1)});
      sheet.triangles.push_back({at(k, i), at(k + 1, i + 1), at(k + 1, i)});
    }
  }
  return sheet;
}

int eights(int segments) { return std::max(8, (segments + 7) / 8 * 8); }

/// The surface between z = 0 and the length, and its two rims.
Sheet cutThread(const Thread& thread, int segments, double stretch, Ring& low, Ring& high) {
  const Sheet half = cutOff(helix(thread, segments, stretch), 0.0, 1.0, low);
  const Sheet whole = cutOff(half, thread.length, -1.0, high);
  sortByAngle(low);
  sortByAngle(high);
  return whole;
}

void add(SoupBuilder& b, const Sheet& sheet, bool turned) {
  for (const auto& t : sheet.triangles) {
    b.triangle(sheet.points[t[0]], sheet.points[t[turned ? 2 : 1]], sheet.points[t[turned ? 1 : 2]]);
  }
}

}  // namespace

double threadProfile(const Thread& thread, double height) {
  const double off = std::abs(std::remainder(height, thread.pitch));  // from the middle of the major flat
  const double depth = std::clamp(off - thread.pitch / 16.0, 0.0, 5.0 / 16.0 * thread.pitch) * std::sqrt(3.0);
  return thread.majorRadius - thread.clearance - depth;
}

assets::TriangleSoup boltThreadSoup(const Thread& thread) {
  Ring low, high;
  SoupBuilder b;
  add(b, cutThread(thread, eights(thread.segments), 1.0, low, high), false);
  b.fan(low, {0.0, 0.0, 0.0}, SoupBuilder::Facing::down);
  b.fan(high, {0.0, 0.0, thread.length}, SoupBuilder::Facing::up);
  return b.soup;
}

assets::TriangleSoup nutThreadSoup(const Thread& thread, double outerRadius) {
  Thread nut = thread;
  nut.clearance = 0.0;
  const int n = eights(thread.segments);
  Ring low, high, outerLow, outerHigh;
  for (int i = 0; i < n; ++i) {
    const double angle = 2.0 * kPi * i / n;
    outerLow.emplace_back(outerRadius * std::cos(angle), outerRadius * std::sin(angle), 0.0);
    outerHigh.emplace_back(outerLow.back().x, outerLow.back().y, thread.length);
  }
  SoupBuilder b;
  add(b, cutThread(nut, n, 1.0 / std::cos(kPi / n), low, high), true);
  b.bands({outerLow, outerHigh});
  b.annulus(low, outerLow, SoupBuilder::Facing::down);
  b.annulus(high, outerHigh, SoupBuilder::Facing::up);
  return b.soup;
}

}  // namespace tandem::test
