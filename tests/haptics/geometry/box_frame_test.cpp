#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include <glm/gtc/quaternion.hpp>

#include "haptics/geometry/box_frame.h"

namespace tandem::test {
namespace {

using haptics::BoxFrame;
using haptics::CentredBox;
using haptics::Float4;

class BoxFrameTest : public ::testing::Test {
 protected:
  float number() { return spread_(random_); }
  glm::vec3 vector() { return {number(), number(), number()}; }
  BoxFrame frame() {
    const glm::dquat q = glm::normalize(glm::dquat(number(), number(), number(), number()));
    return {glm::mat3_cast(q), glm::dvec3(vector())};
  }
  CentredBox box() { return {vector(), glm::abs(vector())}; }

 private:
  std::mt19937 random_{1};
  std::uniform_real_distribution<float> spread_{-1.0f, 1.0f};
};

TEST_F(BoxFrameTest, TheRotatedBoxHoldsAllCornersOfTheBox) {
  for (int run = 0; run < 200; ++run) {
    const BoxFrame to = frame();
    const CentredBox own = box(), around = to.apply(own);
    for (int corner = 0; corner < 8; ++corner) {
      const glm::vec3 sides((corner & 1) != 0 ? 1.0f : -1.0f, (corner & 2) != 0 ? 1.0f : -1.0f,
                            (corner & 4) != 0 ? 1.0f : -1.0f);
      const glm::vec3 off = to.point(own.centre + sides * own.half) - around.centre;
      for (int axis = 0; axis < 3; ++axis) EXPECT_LE(std::abs(off[axis]), around.half[axis] + 1e-5f);
    }
  }
}

TEST_F(BoxFrameTest, FourBoxesAtOnceAreTheSameToTheBit) {
  for (int run = 0; run < 50; ++run) {
    const BoxFrame to = frame();
    CentredBox boxes[4];
    alignas(16) float lanes[2][3][4];
    for (int i = 0; i < 4; ++i) {
      boxes[i] = box();
      for (int axis = 0; axis < 3; ++axis) {
        lanes[0][axis][i] = boxes[i].centre[axis];
        lanes[1][axis][i] = boxes[i].half[axis];
      }
    }
    Float4 centre[3], half[3], rotated[3], grown[3];
    for (int axis = 0; axis < 3; ++axis) {
      centre[axis] = Float4::load(lanes[0][axis]);
      half[axis] = Float4::load(lanes[1][axis]);
    }
    to.apply(centre, half, rotated, grown);
    for (int axis = 0; axis < 3; ++axis) {
      alignas(16) float centres[4], halves[4];
      rotated[axis].store(centres);
      grown[axis].store(halves);
      for (int i = 0; i < 4; ++i) {
        EXPECT_EQ(centres[i], to.apply(boxes[i]).centre[axis]);
        EXPECT_EQ(halves[i], to.apply(boxes[i]).half[axis]);
      }
    }
  }
}

TEST_F(BoxFrameTest, ASlabBoundsTheReachAlongItsNormal) {
  CentredBox flat{{0.0f, 0.0f, 0.0f}, {1.0f, 1.0f, 1.0f}};
  EXPECT_FLOAT_EQ(flat.reachAlong({0.0f, 0.0f, 2.0f}), 2.0f);
  // The normal (0, 0, 127) with an offset of half the box's own.
  flat.slab = 127u << 16 | 64u << 24;
  EXPECT_EQ(flat.slabNormal(), glm::vec3(0.0f, 0.0f, 127.0f));
  EXPECT_FLOAT_EQ(flat.reachAlong({0.0f, 0.0f, 2.0f}), 1.0f);
  EXPECT_FLOAT_EQ(flat.reachAlong({0.0f, 0.0f, -2.0f}), 2.0f);
  EXPECT_FLOAT_EQ(flat.reachAlong({3.0f, 0.0f, 0.0f}), 3.0f);
}

}  // namespace
}  // namespace tandem::test
