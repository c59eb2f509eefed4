#include "assets/scene/scene_size.h"

#include <gtest/gtest.h>

namespace tandem::assets {
namespace {

Scene sized(double x, double y, double z, double mass = 0.0) {
  Scene scene;
  scene.bounds = {{0.0, 0.0, 0.0}, {x, y, z}};
  Part part;
  part.name = "shaft";
  part.massProperties.mass = mass;
  scene.parts = {Part{}, part};
  return scene;
}

TEST(SceneSize, HasThreeDigitsASide) {
  EXPECT_EQ(sizeInWords(sized(0.6789, 0.3, 1234.5)), "0.679 x 0.3 x 1234 m");
}

TEST(SceneSize, OfSeveralHundredMetresIsDoubted) {
  EXPECT_EQ(unitDoubt(sized(700.0, 300.0, 1.0), "m"), "700 m long: is the file in mm? --units mm");
  EXPECT_EQ(unitDoubt(sized(51.0, 1.0, 1.0), "inch"), "51 m long: is the file's unit really inch?");
  EXPECT_EQ(unitDoubt(sized(49.0, 49.0, 49.0), "m"), "");
  EXPECT_EQ(unitDoubt(Scene{}, "m"), "");
}

TEST(SceneSize, WithAPartOfManyTonsIsDoubted) {
  EXPECT_EQ(unitDoubt(sized(40.0, 1.0, 1.0, 2.1e7), "m"),
            "shaft would weigh 21000 t: is the file in mm? --units mm");
  EXPECT_EQ(unitDoubt(sized(40.0, 1.0, 1.0, 9.9e3), "m"), "");
}

}  // namespace
}  // namespace tandem::assets
