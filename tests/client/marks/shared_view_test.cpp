// Whoever shares a view or sections is followed in the window, until the person moves the camera or presses
// Esc; then what was theirs comes back.

#include "client/marks/shared_view.h"

#include <GLFW/glfw3.h>
#include <gtest/gtest.h>

#include "client/picture/camera.h"
#include "client/viewer/viewer.h"

namespace tandem::client {
namespace {

using sync::Presentation;
using sync::Shares;

constexpr SiteId kAda = 2;
constexpr PartId kLeft = 0, kRight = 1;

assets::Scene twoShapedBoxes() {
  assets::Scene scene;
  scene.materials.resize(1);
  for (const double x : {-0.1, 0.1}) {
    assets::Part part;
    part.name = x < 0.0 ? "left" : "right";
    part.movable = true;
    part.worldFromPart.position.x = x;
    assets::ImplicitShape shape;
    shape.kind = assets::ImplicitShape::Kind::box;
    shape.size = {0.1, 0.1, 0.1};
    part.shapes.push_back(shape);
    scene.parts.push_back(part);
  }
  scene.bounds = {{-0.15, -0.05, -0.05}, {0.15, 0.05, 0.05}};
  return scene;
}

/// A window on two boxes, and Ada, who is at another site.
struct SharedViews : testing::Test {
  assets::Scene scene = twoShapedBoxes();
  ViewModel model;
  SharedViews() {
    model.scene = &scene;
    for (const assets::Part& part : scene.parts) model.worldFromPart.push_back(part.worldFromPart);
    model.owner.assign(scene.parts.size(), kNoSite);
    model.role = sync::Role::participant;
    SiteView self, ada;
    self.info.site = 1;
    self.self = true;
    ada.info.site = kAda;
    ada.info.name = "Ada";
    ada.info.role = sync::Role::instructor;
    ada.seen = true;
    ada.presence.worldFromTool.position = {0.0, 0.5, 0.0};
    ada.presence.worldFromCamera = {{0.0, 0.0, 0.6}, {1.0, 0.0, 0.0, 0.0}};
    model.sites = {self, ada};
  }
  void adaShares(Shares what) {
    Presentation& shared = model.presenting.shared;
    shared = {};
    if (what == Shares::nothing) return;
    ++model.presenting.begun;
    shared.site = kAda;
    shared.shares = what;
    shared.sections = {{{0.03, 0.0, 0.0}, {1.0, 0.0, 0.0}}};
    if (what != Shares::view) return;
    shared.hidden = {1u << kLeft};
    shared.selected = kRight;
    shared.transparent = {1u << kRight};
    shared.style.explode = 0.5;
    shared.style.colouring = document::PartColouring::byBody;
  }
};

/// The window's state without a window.
struct Follower : SharedViews {
  SharedView shared;
  SectionSet sections;
  PartDisplay parts{2};
  MeasureUi measures;
  sync::Inspection clash;
  SiteId camera = kNoSite;
  Follower() {
    sections.before[1] = -0.04;
    parts.setHidden(kRight, true);
    parts.selected = kLeft;
    parts.style.ghosts = true;
  }
  void frame() { shared.follow(model, {sections, parts, measures, camera}); }
  void expectOwn() {
    EXPECT_EQ(sections.before[1], -0.04);
    EXPECT_FALSE(sections.beyond[0]);
    EXPECT_TRUE(parts.visible(kLeft));
    EXPECT_FALSE(parts.visible(kRight));
    EXPECT_FALSE(parts.transparent(kRight));
    EXPECT_EQ(parts.style, (document::PartStyle{0.0, {}, document::PartColouring::asMade, true}));
  }
  void expectAdas() {
    EXPECT_EQ(sections.count(), 1u);
    EXPECT_EQ(sections.beyond[0], 0.03);
  }
};

TEST_F(Follower, AViewIsTakenOverAndGivenBack) {
  frame();
  expectOwn();
  adaShares(Shares::view);
  frame();
  expectAdas();
  EXPECT_EQ(camera, kAda);
  EXPECT_FALSE(parts.visible(kLeft));
  EXPECT_TRUE(parts.visible(kRight));
  EXPECT_EQ(parts.selected, kRight);
  EXPECT_TRUE(parts.transparent(kRight));
  EXPECT_EQ(parts.style, model.presenting.shared.style) << "apart, coloured, and without ghosts, as hers";
  EXPECT_EQ(sharingInWords(model, shared), "Ada presents: you follow");
  adaShares(Shares::nothing);
  frame();
  expectOwn();
  EXPECT_EQ(camera, kNoSite);
  EXPECT_EQ(parts.selected, kLeft);
  EXPECT_EQ(sharingInWords(model, shared), "");
}

TEST_F(Follower, AnOwnMoveOfTheCameraEndsItUntilThePersonFollowsAgain) {
  adaShares(Shares::view);
  frame();
  camera = kNoSite;
  frame();
  expectOwn();
  EXPECT_EQ(sharingInWords(model, shared), "Ada presents: you do not follow");
  model.presenting.shared.sections.clear();  // what she does now is not followed
  frame();
  expectOwn();
  adaShares(Shares::nothing);
  frame();
  adaShares(Shares::view);  // something new is
  frame();
  expectAdas();
  shared.setFollows(false);
  frame();
  expectOwn();
  EXPECT_EQ(camera, kNoSite);
  shared.setFollows(true);
  frame();
  expectAdas();
  EXPECT_EQ(camera, kAda);
}

TEST_F(Follower, StoppingAtOnceLeavesTheWindowToWhatComesNext) {
  adaShares(Shares::view);
  frame();
  shared.stop({sections, parts, measures, camera});
  expectOwn();
  sections = {};  // a named view, say
  camera = kNoSite;
  frame();
  EXPECT_FALSE(sections.any());
}

TEST_F(Follower, TheMarksOfAClashAndAnOpenMeasureAreTakenOverAndGivenBack) {
  measures.open = true;
  measures.marks = {{kLeft, {0.05, 0.0, 0.0}}};
  adaShares(Shares::view);
  frame();
  EXPECT_EQ(measures.marks.size(), 1u) << "she measures nothing, so the person may";
  sync::Inspection& looks = model.presenting.shared.inspection;
  looks.a = kLeft;
  looks.b = kRight;
  looks.measuring = true;
  looks.marks = {{kRight, {0.0, 0.05, 0.0}}, {kRight, {0.0, 0.0, 0.05}}};
  frame();
  EXPECT_EQ(measures.marks, looks.marks);
  EXPECT_EQ(shared.clash(model).b, kRight);
  looks.measuring = false;
  looks.marks.clear();
  frame();
  EXPECT_EQ(measures.marks.at(0).part, kLeft) << "hers is closed";
  looks.measuring = true;
  frame();
  EXPECT_TRUE(measures.marks.empty());
  adaShares(Shares::nothing);
  frame();
  EXPECT_EQ(measures.marks.at(0).part, kLeft);
  EXPECT_EQ(shared.clash(model).a, kNoPart);
}

TEST_F(Follower, OfAViewThatIsNotFollowedNothingIsMarked) {
  shared.setFollows(false);
  shared.followLater(false);
  adaShares(Shares::view);
  model.presenting.shared.inspection = {kLeft, kRight, {}, 0.0, false, {}, {}, true, {}};
  frame();
  EXPECT_EQ(shared.clash(model).a, kNoPart);
  EXPECT_FALSE(measures.open);
}

TEST_F(Follower, WhoPresentsShowsTheChosenClashAndTheOpenMeasure) {
  clash.a = kLeft;
  clash.b = kRight;
  measures.open = true;
  measures.marks = {{kLeft, {0.05, 0.0, 0.0}}};
  const auto shown = [&] { return shared.shown(model, {sections, parts, measures, clash}, kNoPart, {}); };
  EXPECT_EQ(shown().inspection, sync::Inspection{}) << "nothing is shared";
  shared.shares = Shares::sections;
  EXPECT_EQ(shown().inspection, sync::Inspection{});
  shared.shares = Shares::view;
  EXPECT_EQ(shown().inspection.b, kRight);
  EXPECT_TRUE(shown().inspection.measuring);
  EXPECT_EQ(shown().inspection.marks, measures.marks);
}

TEST_F(Follower, OfSharedSectionsOnlyTheSectionsFollow) {
  adaShares(Shares::view);
  frame();
  adaShares(Shares::sections);
  frame();
  expectAdas();
  EXPECT_EQ(camera, kNoSite);
  EXPECT_TRUE(parts.visible(kLeft));
  EXPECT_FALSE(parts.visible(kRight));
}

TEST_F(Follower, WhoeverSharesFollowsNobodyAndGoesOnWithWhatIsSeen) {
  adaShares(Shares::sections);
  frame();
  shared.shares = Shares::sections;
  frame();
  expectAdas();
  const Presentation shown =
      shared.shown(model, {sections, parts, measures, clash}, kRight, {0.15, 0.0, 0.0});
  EXPECT_EQ(shown.shares, Shares::sections);
  EXPECT_EQ(shown.sections.size(), 1u);
  EXPECT_EQ(shown.pointedAt, kNoPart) << "who shares sections alone does not point";
  ++model.presenting.ended;  // another has taken over
  frame();
  EXPECT_EQ(shared.shares, Shares::nothing);
}

TEST_F(Follower, WhoPresentsOrHoldsTheKeyPointsAtAPlaceOnThePart) {
  EXPECT_EQ(shared.shown(model, {sections, parts, measures, clash}, kRight, {0.15, 0.01, 0.0}).pointedAt,
            kNoPart);
  shared.pointing = true;
  Presentation shown = shared.shown(model, {sections, parts, measures, clash}, kRight, {0.15, 0.01, 0.0});
  EXPECT_EQ(shown.shares, Shares::nothing);
  EXPECT_EQ(shown.pointedAt, kRight);
  EXPECT_NEAR(glm::length(shown.place - glm::dvec3(0.05, 0.01, 0.0)), 0.0, 1e-12);
  shared.pointing = false;
  shared.shares = Shares::view;
  shown = shared.shown(model, {sections, parts, measures, clash}, kRight, {0.15, 0.01, 0.0});
  EXPECT_EQ(shown.pointedAt, kRight);
  EXPECT_EQ(shown.hidden, std::vector<std::uint8_t>{1u << kRight});
  EXPECT_EQ(shown.style, parts.style);
  EXPECT_EQ(shown.selected, kLeft);
  model.role = sync::Role::observer;
  EXPECT_EQ(shared.shown(model, {sections, parts, measures, clash}, kRight, {}).shares, Shares::nothing);
}

struct FollowingWindow : SharedViews {
  std::unique_ptr<Viewer> viewer;
  void SetUp() override {
    ViewerOptions options;
    options.width = 480;
    options.height = 320;
    auto opened = Viewer::openOffscreen(scene, options);
    if (!opened) GTEST_SKIP() << opened.error().message;
    viewer = std::move(*opened);
    for (int i = 0; i < 3; ++i) static_cast<void>(viewer->frame(model));
  }
};

TEST_F(FollowingWindow, SeesAndCutsWhatThePresenterDoesUntilEsc) {
  const Camera own = viewer->camera();
  adaShares(Shares::view);
  ViewActions actions = viewer->frame(model);
  ASSERT_EQ(actions.sections.size(), 1u) << "what is cut away is not felt either";
  EXPECT_EQ(actions.sections[0].point.x, 0.03);
  EXPECT_LT(glm::length(actions.worldFromCamera.position - glm::dvec3(0.0, 0.0, 0.6)), 1e-9);
  EXPECT_EQ(actions.shown.shares, Shares::nothing);
  EXPECT_TRUE(actions.lifted) << "nor what is drawn apart";
  viewer->pressKey(GLFW_KEY_ESCAPE);
  actions = viewer->frame(model);
  EXPECT_TRUE(actions.sections.empty());
  EXPECT_FALSE(viewer->frame(model).lifted);
  model.sites[1].presence.worldFromCamera.position.z = 0.9;
  actions = viewer->frame(model);
  EXPECT_LT(glm::length(actions.worldFromCamera.position - glm::dvec3(0.0, 0.0, 0.6)), 1e-9)
      << "the camera stays where it was when the person stopped";
  EXPECT_NE(own.yaw, viewer->camera().yaw);
}

}  // namespace
}  // namespace tandem::client
