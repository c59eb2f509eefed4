#pragma once

// Boxes of one frame as boxes of another, in float: the separating-axis test between the boxes of two trees
// (Gottschalk, Lin & Manocha 1996, "OBBTree") with the six face normals of the boxes only.
//
// A rotated box is bounded by the box |R| e around it, with R the rotation and e the half extents.

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "haptics/base/simd4.h"

namespace tandem::haptics {

/// An axis-aligned box as centre and half extents, m, with the slab of its content (0: none).
struct CentredBox {
  glm::vec3 centre, half;
  std::uint32_t slab = 0;

  glm::vec3 slabNormal() const {
    return {static_cast<std::int8_t>(slab), static_cast<std::int8_t>(slab >> 8),
            static_cast<std::int8_t>(slab >> 16)};
  }
  /// How far the content reaches from the centre along the slab's normal, times the length of that normal.
  float slabOffset() const {
    return static_cast<float>(static_cast<std::int8_t>(slab >> 24)) * 0x1p-7f *
           glm::dot(glm::abs(slabNormal()), half);
  }
  /// An upper bound of how far the content reaches along `v`, times the length of v. The slab bounds the
  /// component of v along its normal, the box bounds the rest.
  float reachAlong(const glm::vec3& v) const {
    if (slab == 0) return glm::dot(glm::abs(v), half);
    const glm::vec3 normal = slabNormal();
    const float along = std::max(0.0f, glm::dot(v, normal)) / glm::dot(normal, normal);
    return along * slabOffset() + glm::dot(glm::abs(v - normal * along), half);
  }
};

/// Transforms boxes of one frame into boxes of another.
class BoxFrame {
 public:
  BoxFrame(const glm::dmat3& rotation, const glm::dvec3& shift) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        rotation_[row][column] = static_cast<float>(rotation[column][row]);
        magnitude_[row][column] = std::abs(rotation_[row][column]);
      }
      shift_[row] = static_cast<float>(shift[row]);
    }
  }
  CentredBox apply(const CentredBox& box) const {
    CentredBox out;
    for (int row = 0; row < 3; ++row) {
      out.centre[row] = shift_[row];
      out.half[row] = 0.0f;
      for (int column = 0; column < 3; ++column) {
        out.centre[row] += rotation_[row][column] * box.centre[column];
        out.half[row] += magnitude_[row][column] * box.half[column];
      }
    }
    return out;
  }
  glm::vec3 point(const glm::vec3& p) const { return vector(p) + glm::vec3(shift_[0], shift_[1], shift_[2]); }
  glm::vec3 vector(const glm::vec3& v) const {
    glm::vec3 out;
    for (int row = 0; row < 3; ++row) {
      out[row] = rotation_[row][0] * v.x + rotation_[row][1] * v.y + rotation_[row][2] * v.z;
    }
    return out;
  }
  /// apply() for four boxes.
  void apply(const Float4 centre[3], const Float4 half[3], Float4 rotated[3], Float4 grown[3]) const {
    for (int row = 0; row < 3; ++row) {
      rotated[row] = Float4(shift_[row]);
      grown[row] = Float4();
      for (int column = 0; column < 3; ++column) {
        rotated[row] = rotated[row] + Float4(rotation_[row][column]) * centre[column];
        grown[row] = grown[row] + Float4(magnitude_[row][column]) * half[column];
      }
    }
  }

 private:
  float rotation_[3][3], magnitude_[3][3], shift_[3];  // the magnitudes of the rotation's entries
};

}  // namespace tandem::haptics
