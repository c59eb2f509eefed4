// Pictures of single views: what the view hides is not there, what it marks is told apart.

#include "client/viewer/still_pictures.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/client/viewer/picture.h"
#include "tests/support/temporary_folder.h"

namespace tandem::client {
namespace {

constexpr int kSmallWidth = 160, kSmallHeight = 100;

/// Two boxes side by side, 0.2 m wide, seen from 1 m before them.
struct StillPicturesTest : testing::Test {
  assets::Scene scene;
  std::vector<Pose> poses;
  std::unique_ptr<StillPictures> pictures;
  Still front;
  test::TemporaryFolder folder;

  void SetUp() override {
    scene.materials.resize(1);
    for (const double x : {-0.15, 0.15}) {
      assets::Part part;
      part.worldFromPart.position.x = x;
      part.shapes.resize(1);
      part.shapes[0].size = glm::dvec3(0.2);
      scene.parts.push_back(part);
      poses.push_back(part.worldFromPart);
    }
    scene.bounds = {{-0.25, -0.1, -0.1}, {0.25, 0.1, 0.1}};
    auto opened = StillPictures::open(scene, kSmallWidth, kSmallHeight);
    if (!opened) GTEST_SKIP() << opened.error().message;
    pictures = std::move(*opened);
    front.worldFromEye.position = {0.0, 0.0, 1.0};
  }

  Picture draw(const Still& still) const {
    const std::vector<std::uint8_t> png = pictures->draw(still, poses);
    const std::string path = (folder.path() / "still.png").string();
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(png.data()), static_cast<std::streamsize>(png.size()));
    return readPng(path);
  }
  /// How many pixels of the left or right half differ between two pictures.
  static int differing(const Picture& a, const Picture& b, bool left) {
    int count = 0;
    for (int y = 0; y < kSmallHeight; ++y)
      for (int x = left ? 0 : kSmallWidth / 2; x < (left ? kSmallWidth / 2 : kSmallWidth); ++x)
        count += a.at(x, y) != b.at(x, y);
    return count;
  }
};

TEST_F(StillPicturesTest, HideWhatTheViewHides) {
  const Picture both = draw(front);
  ASSERT_EQ(both.width, kSmallWidth);
  ASSERT_EQ(both.height, kSmallHeight);
  Still still = front;
  still.parts = {0};
  const Picture right = draw(still);
  EXPECT_GT(differing(both, right, true), 500);
  EXPECT_EQ(differing(both, right, false), 0);
  still.onlyThese = true;
  const Picture left = draw(still);
  EXPECT_EQ(differing(both, left, true), 0);
  EXPECT_GT(differing(both, left, false), 500);
}

TEST_F(StillPicturesTest, MarkPartsAndPlaces) {
  const Picture plain = draw(front);
  Still still = front;
  still.marked = {1};
  const Picture marked = draw(still);
  EXPECT_EQ(differing(plain, marked, true), 0);
  EXPECT_GT(differing(plain, marked, false), 500);
  still = front;
  still.places = {{-0.15, 0.0, 0.1}};
  const int dot = differing(plain, draw(still), true);
  EXPECT_GT(dot, 30);
  EXPECT_LT(dot, 200);
}

TEST_F(StillPicturesTest, CutSectionsAndFollowTheirEye) {
  const Picture plain = draw(front);
  Still still = front;
  still.sections = {{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}}};  // away with what lies to the right
  const Picture cut = draw(still);
  EXPECT_GT(differing(plain, cut, false), 500);
  EXPECT_EQ(draw(front).rgb, plain.rgb) << "the next picture is not cut";
  // An eye on its head sees left what was right.
  still.worldFromEye.orientation = glm::dquat(0.0, 0.0, 0.0, 1.0);
  EXPECT_GT(differing(cut, draw(still), true), 500);
}

}  // namespace
}  // namespace tandem::client
