#include "client/viewer/section_handles.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

namespace tandem::client {
namespace {

class SectionHandlesTest : public testing::Test {
 protected:
  SectionHandlesTest() {
    Camera camera;
    camera.yaw = 0.5;
    camera.pitch = 0.4;
    camera.distance = 1.0;
    view_ = makeView(camera, {800.0, 800.0}, {{0.0, 0.0, 0.0}, 0.5});
  }
  glm::dvec2 pixelOf(const glm::dvec3& p) const { return view_.project(p).value(); }

  /// One frame with the left button down and the cursor on p, to which it has moved by `moved`.
  bool drag(const glm::dvec2& p, const glm::dvec2& moved, bool begins, bool shift = false) {
    Input input;
    input.down[0] = true;
    input.pressed[0] = begins;
    input.cursorMove = moved;
    input.shift = shift;
    return handles_.update(view_, input, p, true, glm::dvec3(0.0), sections_);
  }

  View view_;
  SectionSet sections_;
  SectionHandles handles_;
};

TEST_F(SectionHandlesTest, MovesThePlaneWithTheMouseAlongItsNormal) {
  ASSERT_TRUE(sections_.addAll({"x=0.2", "-z=0.1", "0,3,4,0.1"}).ok());
  for (const std::size_t i : {std::size_t{0}, std::size_t{1}, std::size_t{2}}) {
    const document::SectionPlane before = sections_.planes()[i];
    const glm::dvec3 foot = glm::dot(before.normal, before.point) * before.normal,
                     to = foot + 0.02 * before.normal;
    const glm::dvec2 from = pixelOf(foot), moved = pixelOf(to) - from;
    ASSERT_TRUE(drag(from, {}, true));
    ASSERT_TRUE(drag(from + moved, moved, false));
    const double by = glm::dot(before.normal, sections_.planes()[i].point - before.point);
    EXPECT_NEAR(by, 0.02, 0.002) << i;
  }
}

TEST_F(SectionHandlesTest, TurnsAnObliquePlaneAboutItsHandle) {
  ASSERT_TRUE(sections_.addAll({"x=0.2", "0,3,4,0.1"}).ok());
  const document::SectionPlane square = sections_.planes()[0], before = sections_.planes()[1];
  ASSERT_TRUE(drag(pixelOf(before.point), {}, true));
  ASSERT_TRUE(drag(pixelOf(before.point), {50.0, 0.0}, false, true));
  const document::SectionPlane after = sections_.planes()[1];
  EXPECT_GT(glm::distance(after.normal, before.normal), 0.1);
  EXPECT_NEAR(glm::length(after.normal), 1.0, 1e-12);
  EXPECT_NEAR(glm::dot(after.normal, before.point - after.point), 0.0, 1e-12) << "the handle stays";
  EXPECT_EQ(sections_.planes()[0].point, square.point);
}

TEST_F(SectionHandlesTest, LeavesTheMouseAloneBesideTheHandles) {
  ASSERT_TRUE(sections_.add("x=0.2").ok());
  EXPECT_FALSE(drag(pixelOf({0.2, 0.0, 0.0}) + glm::dvec2(0.0, 60.0), {}, true));
  EXPECT_FALSE(drag(pixelOf({0.2, 0.0, 0.0}), {5.0, 0.0}, false) && sections_.planes()[0].point.x != 0.2)
      << "what began beside a handle does not drag it";
}

}  // namespace
}  // namespace tandem::client
