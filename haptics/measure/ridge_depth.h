#pragma once

// Depth of the ridges of one part (the probe) in another (the body), in the body's frame, used by
// penetration.cpp.

#include <cstdint>
#include <vector>

#include "assets/base/pose.h"
#include "haptics/measure/depth_model.h"

namespace tandem::haptics {

/// The deepest point found so far.
struct DeepestPoint {
  double depth = 0.0;
  glm::dvec3 point{0.0, 0.0, 0.0};    // body frame
  glm::dvec3 surface{0.0, 0.0, 0.0};  // the body's nearest point
  bool found = false;
};

/// A point where the probe's ridges cross a facet of the body.
struct CrossedFacet {
  std::uint32_t facet = 0;
  glm::dvec3 point{0.0, 0.0, 0.0};  // body frame
};

class RidgeDepth {
 public:
  RidgeDepth(const DepthModel& probe, const DepthModel& body);

  /// Searches for points deeper than `deepest` and replaces it. Appends the crossings of ridges to `crossed`.
  void measure(const Pose& bodyFromProbe, DeepestPoint& deepest, std::vector<CrossedFacet>& crossed);

 private:
  /// Nearby ridges within a ball.
  struct Cluster {
    std::uint32_t first = 0, count = 0;  // into order_
    glm::dvec3 centre{0.0, 0.0, 0.0};    // probe frame
    double radius = 0.0;
    double least =
        -1e300;       // no ridge was nearer to the body's surface than this from outside; deeper: negative
    double at = 0.0;  // travelled_ when that was measured
  };
  static constexpr std::uint32_t kNoFacet = 0xffffffffu;
  /// A crossing of a ridge with the body's surface.
  struct Cut {
    double t = 0.0;
    std::uint32_t facet = kNoFacet;
  };
  /// A piece of a ridge without crossings, and the body's facets nearest to its ends, if known.
  struct Interval {
    glm::dvec3 from, to;  // body frame
    std::uint32_t fromFacet = kNoFacet, toFacet = kNoFacet;
  };
  struct Stretch;
  enum Side : std::uint8_t { kUnknown, kOutside, kInside };

  void makeClusters();
  void travel(const Pose& bodyFromProbe);
  bool mayMatter(Cluster& cluster, double depth);
  std::uint32_t root(std::uint32_t corner);
  void measureRidge(std::uint32_t ridge, DeepestPoint& deepest, std::vector<CrossedFacet>& crossed);
  void findSides();
  double bound(const Interval& interval) const;
  MeshPoint nearest(const glm::dvec3& p, const Interval& interval) const;
  void measureInside(const Interval& interval, DeepestPoint& deepest) const;
  void measureOpen(const glm::dvec3& from, const glm::dvec3& to, DeepestPoint& deepest) const;
  double farthest(const Interval& interval, double enough, DeepestPoint& place) const;

  const DepthModel& probe_;
  const DepthModel& body_;
  double tolerance_;
  std::vector<std::uint32_t> order_;  // ridges by cluster
  std::vector<Cluster> clusters_;
  Pose pose_;
  bool posed_ = false;
  std::uint32_t deepestRidge_ = kNoFacet;  // of the last call
  double travelled_ = 0.0;  // m, upper bound of the path of any point of the probe in the body's frame
  glm::dvec3 centre_{0.0, 0.0, 0.0};
  double radius_ = 0.0;  // of the probe around centre_

  // Scratch of one call.
  std::vector<glm::dvec3> placed_;      // corners, body frame
  std::vector<std::uint8_t> side_;      // of corners
  std::vector<std::uint32_t> near_;     // ridges that may matter
  std::vector<std::uint32_t> whole_;    // of these, the ones that cross nothing
  std::vector<std::uint32_t> parent_;   // union-find of corners joined by whole ridges
  std::vector<SegmentCrossing> found_;  // of one ridge
  std::vector<Cut> cuts_;               // of one ridge: its ends and crossings, sorted
};

}  // namespace tandem::haptics
