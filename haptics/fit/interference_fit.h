#pragma once

// An interference fit: a part that stands in the seat of another one because it is modelled larger than the
// seat, as a bolt of its major diameter in a hole of its core diameter.
//
// The seat's wall is known by points of it. Wherever a surface faces that wall, it counts as further back by
// as much as the plug was deepest in the wall, and nowhere else: then the plug goes along its seat as if it
// had been made to fit, in and out, and all its other surfaces meet the hollow part as they are. The depth is
// the same everywhere, because a seat that is wider in one place than in another would be a wedge.
//
// 1. Belongs to a pair of parts; frame of the hollow part, which has the seat. 2. Free of allocation.

#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "assets/base/pose.h"
#include "assets/scene/scene.h"
#include "haptics/base/fixed_vector.h"
#include "haptics/touch/sample_touch.h"

namespace tandem::haptics {

class InterferenceFit {
 public:
  // Finding the seat of a plug in the hollow part: begin(), lookAt() for each place, end().

  /// Begins within `near`, a box around the overlap of the two. False if it takes too many places.
  bool begin(const assets::Bounds& near);
  /// Of the box, to look at.
  int places() const { return places_.x * places_.y * places_.z; }
  /// Looks for the wall near a place of the box, where it is in the plug by at most `deepest` m: the side of
  /// `plugFromHollow` is that of the hollow part's samples. False if the seat takes too many points.
  bool lookAt(int place, const SampledModels& plugFromHollow, double deepest);
  /// False if the part is not hollow there, or if the seat is too long.
  bool end();
  /// Points of the seat found so far.
  std::size_t points() const { return points_.size(); }
  static constexpr std::size_t kMaxPoints = 768;

  /// The shift (m, frame of the target) that takes a sample's surfaces back from the wall, of the plug or of
  /// the wall itself, the hollow part's.
  glm::dvec3 shift(const SampledModels& models, const ContactSample& sample, bool ofHollow) const {
    Hint none;
    return shift(models, sample, ofHollow, none);
  }
  /// Points that faced one sample, and are likely to face its neighbours. Saves time and changes no shift.
  struct Hint {
    std::uint32_t four = 0;  // into fours_
  };
  /// The same with the hint of the last sample, which becomes that of this one.
  glm::dvec3 shift(const SampledModels& models, const ContactSample& sample, bool ofHollow, Hint& hint) const;
  /// m, by which surfaces count as further back.
  double depth() const { return depth_; }
  void setDepth(double depth) { depth_ = depth; }

  /// By how much (m) a shift may change while a sample moves by 1 m.
  double slope() const { return 2.0 * greatestShift() / spacing_; }
  /// m, no shift is longer: three walls may take a corner back.
  double greatestShift() const { return 1.75 * depth_; }

 private:
  static constexpr std::size_t kMaxEntries = 8 * kMaxPoints, kMaxCells = 256;
  static constexpr std::size_t kMaxFours = kMaxEntries / 4 + kMaxCells;
  static constexpr std::size_t kMostNormals = 16;  // of one sample
  static constexpr double kWhole = 1.2;            // spacings from a point over which its depth holds

  struct Point {
    glm::vec3 at{0.0f};      // m, from origin_
    glm::vec3 normal{0.0f};  // unit, of the wall
  };
  /// A point that may matter in a cell of side 2 reach().
  struct Entry {
    std::uint32_t cell = 0;
    std::uint16_t point = 0;
  };
  /// Four points of a cell side by side; the last ones of a cell may be none, which look nowhere.
  struct alignas(16) Four {
    float at[3][4] = {}, normal[3][4] = {};
  };
  struct Cell {
    std::uint32_t cell = 0, first = 0, end = 0;  // the number of the cell; its part of fours_
  };

  float reach() const { return static_cast<float>((kWhole + 1.0) * spacing_); }
  std::uint32_t cellOf(const glm::vec3& at) const;
  bool add(const Point& point);
  /// Whether the walls look at each other.
  bool isHollow() const;
  /// Sorts the points by the cells in which they may matter; false if there are too many cells.
  bool index();
  /// `among`: how many points the last cell has.
  void addToCell(const Point& point, std::size_t among);
  /// The share of the depth by which a surface is taken back at a place where the wall would look in a
  /// direction.
  float shareAt(const glm::vec3& at, const glm::vec3& direction, Hint& hint) const;
  /// The largest share that any of four points has in that.
  float shareOf(const Four& points, const glm::vec3& at, const glm::vec3& facing) const;
  /// The same in the frame of the hollow part, as if the sample were the plug's.
  glm::dvec3 shiftOf(const SampledModels& models, const ContactSample& sample, bool ofHollow,
                     Hint& hint) const;

  glm::dvec3 origin_{0.0, 0.0, 0.0};  // m
  double spacing_ = 0.0;              // m, between points at most
  double depth_ = 0.0;                // m
  assets::Bounds box_;                // m; beside it a shift falls to 0 over spacing_
  glm::ivec3 places_{0};              // along each axis of the box around the overlap
  FixedVector<Point, kMaxPoints> points_;
  FixedVector<Cell, kMaxCells> cells_;  // by number
  FixedVector<Four, kMaxFours> fours_;
};

}  // namespace tandem::haptics
