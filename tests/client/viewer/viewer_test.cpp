#include "client/viewer/viewer.h"

#include <epoxy/gl.h>

#include <GLFW/glfw3.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "client/picture/camera.h"
#include "tests/client/viewer/picture.h"

namespace tandem::client {
namespace {

constexpr int kWidth = 480, kHeight = 320;

assets::Part box(const char* name, const glm::dvec3& at, std::uint16_t material) {
  assets::Part part;
  part.name = name;
  part.movable = true;
  part.worldFromPart.position = at;
  assets::ImplicitShape shape;
  shape.kind = assets::ImplicitShape::Kind::box;
  shape.size = {0.1, 0.1, 0.1};
  shape.material = material;
  part.shapes.push_back(shape);
  return part;
}

/// A red box at the left and a green one at the right, seen from the front.
assets::Scene twoBoxes() {
  assets::Scene scene;
  scene.name = "boxes";
  scene.materials.resize(2);
  scene.materials[0].baseColour = {0.7f, 0.02f, 0.02f, 1.0f};
  scene.materials[1].baseColour = {0.02f, 0.5f, 0.02f, 1.0f};
  scene.parts = {box("left", {-0.1, 0.0, 0.0}, 0), box("right", {0.1, 0.0, 0.0}, 1)};
  scene.bounds.min = {-0.15, -0.05, -0.05};
  scene.bounds.max = {0.15, 0.05, 0.05};
  return scene;
}

bool isRed(const Rgb& c) { return c[0] > 90 && c[0] > 2 * c[1] && c[0] > 2 * c[2]; }
bool isGreen(const Rgb& c) { return c[1] > 70 && c[1] > 2 * c[0] && c[1] > 2 * c[2]; }
bool isBlue(const Rgb& c) { return c[2] > 110 && c[2] > c[0] + 40 && c[2] > c[1] + 15; }

/// A path that no other test process uses, since test processes run side by side.
std::string ownFile(const char* what) {
  return testing::TempDir() + "tandem_viewer_" + what + std::to_string(::getpid()) + ".png";
}

/// A viewer without a display on the two boxes, and the model it shows.
class ViewerTest : public testing::Test {
 protected:
  void SetUp() override {
    ViewerOptions options;
    options.width = kWidth;
    options.height = kHeight;
    options.panels = false;
    auto opened = Viewer::openOffscreen(scene_, options);
    if (!opened) GTEST_SKIP() << opened.error().message;
    viewer_ = std::move(*opened);
    model_.scene = &scene_;
    for (const assets::Part& part : scene_.parts) model_.worldFromPart.push_back(part.worldFromPart);
    model_.owner.assign(scene_.parts.size(), kNoSite);
    model_.role = sync::Role::participant;
    Camera& camera = viewer_->camera();
    camera = fitView(scene_.bounds, 1.5);
    camera.yaw = 0.0;
    camera.pitch = 0.0;
    camera.distance = 0.5;
  }

  /// Lets another person be seen whose tool is at `tool`, m, and whose camera looks from afar.
  void addOther(const glm::dvec3& tool) {
    SiteView site;
    site.info.site = 2;
    site.info.name = "Bruno";
    site.info.role = sync::Role::participant;
    site.info.colour = {20, 60, 250};
    site.seen = true;
    site.presence.worldFromTool.position = tool;
    site.presence.worldFromCamera.position = {0.0, 0.0, 5.0};
    model_.sites.push_back(site);
  }

  /// Another viewer of the same scene.
  Result<std::unique_ptr<Viewer>> openWithPanels(int width, int height) {
    ViewerOptions options;
    options.width = width;
    options.height = height;
    return Viewer::openOffscreen(scene_, options);
  }

  Picture draw() {
    actions_ = viewer_->frame(model_);
    const std::string path = ownFile("test");
    EXPECT_TRUE(viewer_->screenshot(path).ok());
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    Picture picture = readPng(path);
    std::filesystem::remove(path);
    EXPECT_EQ(picture.width, kWidth);
    EXPECT_EQ(picture.height, kHeight);
    return picture;
  }

  const assets::Scene scene_ = twoBoxes();
  std::unique_ptr<Viewer> viewer_;
  ViewModel model_;
  ViewActions actions_;
};

TEST_F(ViewerTest, ShowsPartsInTheirColoursAtTheirPlaces) {
  const Picture picture = draw();
  EXPECT_TRUE(isRed(picture.at(kWidth / 4 + 20, kHeight / 2)));
  EXPECT_TRUE(isGreen(picture.at(3 * kWidth / 4 - 20, kHeight / 2)));
  const Rgb corner = picture.at(3, 3);
  EXPECT_FALSE(isRed(corner) || isGreen(corner));
}

TEST_F(ViewerTest, MovedPartsAreDrawnWhereTheyAre) {
  draw();
  std::swap(model_.worldFromPart[0], model_.worldFromPart[1]);
  const Picture picture = draw();
  EXPECT_TRUE(isGreen(picture.at(kWidth / 4 + 20, kHeight / 2)));
  EXPECT_TRUE(isRed(picture.at(3 * kWidth / 4 - 20, kHeight / 2)));
}

TEST_F(ViewerTest, AKeyClearsAFaultAndNothingElseDoes) {
  viewer_->pressKey(GLFW_KEY_C);
  EXPECT_FALSE(viewer_->frame(model_).resetFault) << "there is none";
  model_.hand.flags = haptics::kFlagFault;
  model_.hand.fault = "x > 0";
  EXPECT_FALSE(viewer_->frame(model_).resetFault);
  viewer_->pressKey(GLFW_KEY_C);
  EXPECT_TRUE(viewer_->frame(model_).resetFault);
  EXPECT_FALSE(viewer_->frame(model_).resetFault) << "once a press";
}

TEST_F(ViewerTest, TheSameModelGivesTheSamePicture) {
  const Picture first = draw(), second = draw();
  EXPECT_EQ(countDifferent(first, second, 0), 0);
}

TEST_F(ViewerTest, FitsPartsAndHandsWhereTheyAreButNobodyWhoStrayed) {
  SiteView site;
  site.info.site = 7;
  site.info.role = sync::Role::participant;
  site.seen = true;
  site.presence.worldFromTool.position = {0.0, 0.25, 0.0};
  const auto inView = [&](const glm::dvec3& point) {
    const View view = makeView(viewer_->camera(), {kWidth, kHeight}, {point, 0.1});
    const auto at = view.project(point);
    return at && at->x > 0.0 && at->y > 0.0 && at->x < kWidth && at->y < kHeight;
  };
  model_.worldFromPart[1].position.x = 0.4;
  draw();
  EXPECT_FALSE(inView({0.4, 0.0, 0.0}));
  viewer_->fitAll();
  draw();
  EXPECT_TRUE(inView({0.4, 0.0, 0.0}));
  EXPECT_FALSE(inView({0.0, 0.25, 0.0}));
  model_.sites.push_back(site);
  viewer_->fitAll();
  draw();
  EXPECT_TRUE(inView({0.0, 0.25, 0.0}));
  const double distance = viewer_->camera().distance;
  model_.sites[0].presence.worldFromTool.position = {0.0, 100.0, 0.0};
  viewer_->fitAll();
  draw();
  EXPECT_LE(viewer_->camera().distance, distance);
}

TEST_F(ViewerTest, EveryKindOfFieldIsDrawnWhereItIs) {
  const Picture without = draw();
  assets::Scene scene = scene_;
  scene.fields.resize(1);
  model_.scene = &scene;
  assets::ForceField& field = scene.fields[0];
  field.force = {0.0, 1.0, 0.0};
  field.points = {{-0.02, 0.0, 0.0}, {0.02, 0.02, 0.0}};
  field.anchor = assets::ForceField::Anchor::path;
  field.partFromField.position = {0.0, 0.0, 0.1};  // between the boxes, before them
  using Kind = assets::ForceField::Kind;
  for (const Kind kind : {Kind::constant, Kind::spring, Kind::guide, Kind::damper, Kind::viscosity,
                          Kind::waveform, Kind::gravity, Kind::potential}) {
    field.kind = kind;
    field.part = kNoPart;
    const Picture with = draw();
    EXPECT_GT(countDifferent(without, with, 8), 15) << assets::nameOf(kind);
    field.part = 0;  // moves with the left box
    EXPECT_GT(countDifferent(with, draw(), 8), 15) << assets::nameOf(kind);
  }
  field.region.kind = assets::FieldRegion::Kind::sphere;
  field.region.radius = 0.05;
  const Picture round = draw();
  field.region.kind = assets::FieldRegion::Kind::everywhere;
  EXPECT_GT(countDifferent(round, draw(), 8), 100);
}

TEST_F(ViewerTest, APathIsDrawnAsTheCurveThatIsFelt) {
  assets::Scene scene = scene_;
  scene.fields.resize(1);
  model_.scene = &scene;
  assets::ForceField& field = scene.fields[0];
  field.kind = assets::ForceField::Kind::guide;
  field.anchor = assets::ForceField::Anchor::path;
  field.partFromField.position = {0.0, 0.0, 0.1};
  field.points = {{-0.03, 0.0, 0.0}, {0.0, 0.03, 0.0}, {0.03, 0.0, 0.0}, {0.0, -0.03, 0.0}};
  field.closed = true;
  const Picture round = draw();
  field.smooth = false;
  EXPECT_GT(countDifferent(round, draw(), 8), 100) << "a circle's curve leaves its square";
}

TEST_F(ViewerTest, AnOwnedPartTakesItsOwnersColour) {
  SiteView site;
  site.info.site = 7;
  site.info.name = "Ada";
  site.info.colour = {20, 60, 250};
  model_.sites.push_back(site);
  const Picture before = draw();
  EXPECT_EQ(before.count(isBlue), 0);
  model_.owner[0] = 7;
  const Picture owned = draw();
  const int changed = countDifferent(before, owned, 8);
  EXPECT_GT(changed, 3000);
  EXPECT_LT(changed, kWidth * kHeight / 2) << "only the owned part may change";
  EXPECT_TRUE(isGreen(owned.at(3 * kWidth / 4 - 20, kHeight / 2)));
  EXPECT_GT(owned.at(kWidth / 4 + 20, kHeight / 2)[2], before.at(kWidth / 4 + 20, kHeight / 2)[2] + 30);
}

TEST_F(ViewerTest, TheForceArrowGrowsWithTheForce) {
  model_.hand.present = model_.hand.valid = true;
  model_.hand.worldFromProxy.position = {0.0, -0.02, 0.06};
  model_.hand.worldFromDevice = model_.hand.worldFromProxy;
  const Picture without = draw();
  model_.hand.force = {0.0, 1.0, 0.0};
  const Picture weak = draw();
  model_.hand.force = {0.0, 3.0, 0.0};
  const Picture strong = draw();
  const int weakPixels = countDifferent(without, weak, 12),
            strongPixels = countDifferent(without, strong, 12);
  EXPECT_GT(weakPixels, 200);
  EXPECT_GT(strongPixels, weakPixels + 150);
}

TEST_F(ViewerTest, OthersHandsAreDrawnUnlessTheyAreAway) {
  const Picture alone = draw();
  addOther({0.0, 0.02, 0.06});
  EXPECT_GT(countDifferent(alone, draw(), 12), 300);
  model_.sites[0].info.connected = false;
  EXPECT_EQ(countDifferent(alone, draw(), 0), 0);
}

TEST_F(ViewerTest, TheSecondHandIsDrawnWithItsForce) {
  model_.hand.present = model_.hand.valid = true;
  model_.hand.worldFromProxy.position = {-0.03, -0.02, 0.06};
  model_.hand.worldFromDevice = model_.hand.worldFromProxy;
  SecondHandView& second = model_.hand.second;
  second.valid = true;
  second.worldFromProxy.position = {0.03, -0.02, 0.06};
  second.worldFromDevice = second.worldFromProxy;
  const Picture one = draw();
  second.deviceName = "left";
  const Picture two = draw();
  EXPECT_GT(countDifferent(one, two, 12), 100);
  second.force = {0.0, 2.0, 0.0};
  EXPECT_GT(countDifferent(two, draw(), 12), 200);
}

TEST_F(ViewerTest, TheSecondHandOfAnotherIsDrawn) {
  addOther({-0.03, 0.02, 0.06});
  const Picture one = draw();
  model_.sites[0].presence.worldFromSecondTool = Pose{{0.03, 0.02, 0.06}, {1.0, 0.0, 0.0, 0.0}};
  EXPECT_GT(countDifferent(one, draw(), 12), 100);
}

TEST_F(ViewerTest, PlacesTheVirtualStylusBeforeWhatIsInTheMiddle) {
  model_.worldFromPart[0].position = {0.0, 0.0, 0.0};
  draw();
  EXPECT_TRUE(actions_.stylusMoved);
  EXPECT_FALSE(actions_.grasp);
  const glm::dvec3 tip = actions_.worldFromStylus.position;
  EXPECT_NEAR(tip.x, 0.0, 1e-9);
  EXPECT_NEAR(tip.y, 0.0, 1e-9);
  EXPECT_GT(tip.z, 0.05);         // before the box's front face
  EXPECT_LT(tip.z, 0.05 + 0.02);  // but within reach of it
  draw();
  EXPECT_FALSE(actions_.stylusMoved);
}

TEST_F(ViewerTest, AnUnwritableScreenshotIsAnErrorThatNamesTheFile) {
  draw();
  const Status status = viewer_->screenshot("/nonexistent/folder/picture.png");
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().message.find("/nonexistent/folder/picture.png"), std::string::npos);
}

TEST_F(ViewerTest, TwoViewersDoNotDisturbEachOther) {
  const Picture before = draw();
  auto other = openWithPanels(200, 100);
  ASSERT_TRUE(other.ok());
  (*other)->frame(model_);
  EXPECT_EQ(countDifferent(before, draw(), 0), 0);
  other->reset();
  EXPECT_EQ(countDifferent(before, draw(), 0), 0);
}

TEST_F(ViewerTest, PanelsLeaveRoomForTheScene) {
  auto opened = openWithPanels(1200, 700);
  ASSERT_TRUE(opened.ok());
  model_.notices.push_back({Notice::Level::warning, 0.5, "Not granted: left is held by Bruno"});
  model_.loop.recentForce_n = {0.0f, 1.0f, 2.0f};
  (*opened)->frame(model_);
  (*opened)->frame(model_);
  const std::string path = ownFile("panels");
  ASSERT_TRUE((*opened)->screenshot(path).ok());
  EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
  const Picture picture = readPng(path);
  std::filesystem::remove(path);
  EXPECT_GT(picture.count(isRed), 2000);
  EXPECT_GT(picture.count(isGreen), 2000);
  const auto isPanel = [](const Rgb& c) { return c[0] > 240 && c[1] > 240 && c[2] > 240; };
  EXPECT_TRUE(isPanel(picture.at(20, 500)));
  EXPECT_TRUE(isPanel(picture.at(1190, 690)));
}

TEST_F(ViewerTest, ShowsWhatTheHeldPartIsNearestTo) {
  auto opened = openWithPanels(1200, 700);
  ASSERT_TRUE(opened.ok());
  model_.hand.present = model_.hand.valid = true;
  model_.hand.held = 0;
  model_.hand.worldFromProxy.position = model_.hand.worldFromDevice.position = {-0.1, 0.1, 0.0};
  const auto picture = [&] {
    (*opened)->frame(model_);
    (*opened)->frame(model_);
    const std::string path = ownFile("nearest");
    EXPECT_TRUE((*opened)->screenshot(path).ok());
    Picture drawn = readPng(path);
    std::filesystem::remove(path);
    return drawn;
  };
  const Picture without = picture();
  model_.hand.nearest = {1, 0.1, {-0.05, 0.0, 0.05}, {0.05, 0.0, 0.05}};
  const Picture with = picture();
  // Two lines in the panel; a line and its words in the scene.
  const auto changed = [&](int left, int right) {
    int count = 0;
    for (int y = 0; y < with.height; ++y) {
      for (int x = left; x < right; ++x) count += with.at(x, y) != without.at(x, y) ? 1 : 0;
    }
    return count;
  };
  EXPECT_GT(changed(900, 1200), 300);
  EXPECT_GT(changed(280, 880), 300);
  model_.hand.held = kNoPart;
  model_.hand.nearest.part = 1;
  const Picture apart = picture();
  model_.hand.nearest = {};
  EXPECT_EQ(countDifferent(apart, picture(), 0), 0) << "nothing is held";
}

TEST_F(ViewerTest, TheListOfClashesAsksOnceItIsOpenAndShowsWhatIsChosen) {
  auto opened = openWithPanels(1200, 700);
  ASSERT_TRUE(opened.ok());
  model_.clashes.possible = true;
  for (int i = 0; i < 3; ++i) {
    const ViewActions actions = (*opened)->frame(model_);
    EXPECT_FALSE(actions.findClashes || actions.stopClashes) << "nobody has opened it";
  }
  const glm::dvec3 before = (*opened)->camera().target;
  (*opened)->openClashes({0.2, true});
  int requested = 0;
  for (int i = 0; i < 5; ++i) {
    const ViewActions actions = (*opened)->frame(model_);
    requested += actions.findClashes ? 1 : 0;
    if (actions.findClashes) {
      EXPECT_EQ(actions.findClashes->clearance, 0.2);
      EXPECT_TRUE(actions.findClashes->atRest);
    }
  }
  EXPECT_EQ(requested, 1);
  auto findings = std::make_shared<ClashFindings>();
  findings->worldFromPart = model_.worldFromPart;
  Clash clash{0, 1};
  clash.distance = 0.1;
  clash.onA = {-0.05, 0.0, 0.05};
  clash.onB = {0.05, 0.0, 0.05};
  findings->found.push_back({clash, false});
  model_.clashes.findings = findings;
  for (int i = 0; i < 60; ++i) (*opened)->frame(model_);
  EXPECT_LT(glm::length((*opened)->camera().target - glm::dvec3(0.0, 0.0, 0.05)), 1e-12);
  EXPECT_NE((*opened)->camera().target, before);
  const std::string path = ownFile("clashes");
  const auto picture = [&] {
    (*opened)->frame(model_);
    EXPECT_TRUE((*opened)->screenshot(path).ok());
    Picture drawn = readPng(path);
    std::filesystem::remove(path);
    return drawn;
  };
  const Picture chosen = picture();
  EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
  const auto isOrange = [](const Rgb& c) { return c[0] > 140 && c[0] > c[1] + 40 && c[1] > c[2] + 15; };
  EXPECT_GT(chosen.count(isOrange), 2000) << "one part";
  EXPECT_GT(chosen.count(isBlue), 2000) << "the other one";
  (*opened)->pressKey(GLFW_KEY_ESCAPE);
  const Picture without = picture();
  EXPECT_LT(without.count(isOrange), 500);
  EXPECT_GT(without.count(isGreen), 2000);
  EXPECT_EQ((*opened)->camera().target, glm::dvec3(0.0, 0.0, 0.05)) << "the camera stays";
}

/// Pixels of the right panel's margin, which should be empty, with something drawn on them.
int writtenInMargin(const Picture& picture) {
  int count = 0;
  for (int y = 0; y < picture.height - 40; ++y)
    for (int x = picture.width - 11; x < picture.width - 7; ++x) {
      const Rgb c = picture.at(x, y);
      count += c[0] < 150 || c[1] < 150 || c[2] < 150 ? 1 : 0;
    }
  return count;
}

TEST_F(ViewerTest, LongTextStaysInsideThePanel) {
  auto opened = openWithPanels(1200, 900);
  ASSERT_TRUE(opened.ok());
  model_.hand.present = model_.hand.valid = true;
  model_.hand.flags = haptics::kFlagLessEffort;
  model_.connection.status =
      "reconnecting: no server answers at 192.168.100.200 port 7480, and goes on trying";
  for (int i = 0; i < 3; ++i) static_cast<void>((*opened)->frame(model_));
  const std::string path = ownFile("panel");
  ASSERT_TRUE((*opened)->screenshot(path).ok());
  EXPECT_EQ(writtenInMargin(readPng(path)), 0);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace tandem::client
