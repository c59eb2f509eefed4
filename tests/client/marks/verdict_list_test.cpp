// The list of clashes by status: what was found, what the document keeps, and the flight to a pair.

#include "client/marks/verdict_list.h"

#include <gtest/gtest.h>

#include <cmath>

#include <glm/geometric.hpp>

#include "client/picture/camera.h"
#include "client/viewer/viewer.h"
#include "tests/support/shapes.h"

namespace tandem::client {
namespace {

using namespace document;

FoundClash hard(PartId a, PartId b, double depth) {
  FoundClash found;
  found.clash.a = a;
  found.clash.b = b;
  found.clash.kind = ClashKind::hard;
  found.clash.depth = depth;
  return found;
}

/// Four boxes, a document, and the findings of a search.
struct VerdictLists : testing::Test {
  test::SceneBuilder builder;
  Document document;
  ViewModel model;

  VerdictLists() {
    for (int i = 0; i < 4; ++i) {
      builder.addPart(test::boxMesh(glm::dvec3(0.1)), Pose{{0.08 * i, 0.0, 0.0}, glm::dquat(1, 0, 0, 0)});
      model.worldFromPart.push_back(builder.scene.parts.back().worldFromPart);
    }
    builder.scene.bounds = {glm::dvec3(-0.05), {0.3, 0.05, 0.05}};
    model.scene = &builder.scene;
    model.document = &document;
    model.documentStanding.complete = true;
    model.role = sync::Role::participant;
    model.owner.assign(4, kNoSite);
    SiteView self;
    self.self = true;
    self.info.name = "Ada";
    model.sites = {self};
  }
  void find(std::vector<FoundClash> found) {
    auto findings = std::make_shared<ClashFindings>();
    findings->found = std::move(found);
    findings->worldFromPart = model.worldFromPart;
    model.clashes.possible = true;
    model.clashes.findings = findings;
  }
  void apply(const Change& change) {
    EXPECT_EQ(document.apply(change, {1, "Ada", 1, 1000}).refusal, Refusal::none);
  }
  void keep() {
    for (const Change& change : changesToKeep(model)) apply(change);
  }
  std::vector<ClashGroup> groups() const {
    return clashGroups(model.clashes.findings.get(), &document, builder.scene, false);
  }
};

TEST_F(VerdictLists, GroupsWhatWasFoundByTheStatusThatTheDocumentHas) {
  find({hard(0, 1, 0.02), hard(1, 2, 0.01), hard(2, 3, 0.005)});
  ASSERT_EQ(groups().size(), 1u);
  EXPECT_EQ(groups()[0].title, "not kept");
  keep();
  EXPECT_TRUE(changesToKeep(model).empty());
  const auto verdicts = verdictsByPair(document);
  apply(judge(*verdicts.at({0, 1}), ClashStatus::approved, {"Ben", "press fit"}));
  find({hard(0, 1, 0.02), hard(1, 2, 0.01), hard(0, 3, 0.001)});
  keep();
  const std::vector<ClashGroup> listed = groups();
  ASSERT_EQ(listed.size(), 3u);
  EXPECT_EQ(listed[0].title, "new");
  EXPECT_EQ(listed[0].lines.size(), 2u);
  EXPECT_EQ(listed[1].title, "approved");
  EXPECT_EQ(listed[1].lines[0].row.first, "part0");
  EXPECT_EQ(judgedBy(*listed[1].lines[0].verdict, 1000 + 300), "approved by Ben, 5 min ago");
  EXPECT_EQ(listed[2].title, "resolved");
  ASSERT_EQ(listed[2].lines.size(), 1u);
  EXPECT_EQ(listed[2].lines[0].row.found, nullptr);
  EXPECT_EQ(listed[2].lines[0].row.measure, "was 5.000 mm deep");
  EXPECT_EQ(judgedBy(*listed[2].lines[0].verdict, 1000), "resolved by Ada, now");
}

TEST_F(VerdictLists, ByPartThePartWithTheMostPairsComesFirst) {
  find({hard(2, 3, 0.02), hard(0, 1, 0.01), hard(1, 2, 0.005), hard(1, 3, 0.001)});
  const std::vector<ClashGroup> listed = byPart(groups());
  ASSERT_EQ(listed.size(), 2u);
  EXPECT_EQ(listed[0].title, "part1");
  EXPECT_EQ(listed[0].lines.size(), 3u);
  EXPECT_EQ(listed[1].title, "") << "a pair whose parts have no other";
  EXPECT_EQ(listed[1].lines[0].a, 2u);
  EXPECT_TRUE(byPart({}).empty());
}

TEST_F(VerdictLists, WithoutASearchTheDocumentIsListed) {
  apply({0, 0, ClashVerdict{1, 2, ClashStatus::reviewed, 0.001, "[Ben]"}});
  apply({0, 0, ClashVerdict{1, 9, ClashStatus::reviewed, 0.001, "of a part that is not there"}});
  EXPECT_TRUE(changesToKeep(model).empty()) << "nothing was searched, so nothing is gone";
  const std::vector<ClashGroup> listed = groups();
  ASSERT_EQ(listed.size(), 1u);
  ASSERT_EQ(listed[0].lines.size(), 1u);
  EXPECT_EQ(listed[0].lines[0].row.note, "not found");
}

TEST_F(VerdictLists, TheListingFollowsSearchAndDocument) {
  ClashUi ui;
  ClashListing listing;
  listing.update(model, ui);
  EXPECT_TRUE(listing.groups().empty());
  find({hard(0, 1, 0.02), hard(1, 2, 0.01)});
  listing.update(model, ui);
  EXPECT_EQ(listing.changes().size(), 2u);
  keep();
  listing.update(model, ui);
  EXPECT_TRUE(listing.changes().empty());
  EXPECT_EQ(listing.groups()[0].title, "new");
  ui.byPart = true;
  listing.update(model, ui);
  EXPECT_EQ(listing.groups()[0].title, "part1");
  document.clear();
  listing.update(model, ui);
  EXPECT_EQ(listing.changes().size(), 2u);
  model.document = nullptr;
  listing.update(model, ui);
  EXPECT_TRUE(listing.changes().empty());
}

TEST_F(VerdictLists, TheFlightKeepsBothPartsInView) {
  const assets::Bounds large{glm::dvec3(-0.05), {0.05, 0.05, 0.05}},
      small{{0.04, 0.0, 0.0}, {0.06, 0.02, 0.02}};
  const ClashWitness witness{{0.05, 0.01, 0.01}, {0.045, 0.01, 0.01}, false};
  const auto inView = [](const Camera& camera, const glm::dvec3& point) {
    const View view = makeView(camera, {800.0, 600.0}, {camera.target, 1.0});
    const auto pixel = view.project(point);
    return pixel && pixel->x >= 0.0 && pixel->y >= 0.0 && pixel->x <= 800.0 && pixel->y <= 600.0;
  };
  for (const auto& at : {std::optional<ClashWitness>(witness), std::optional<ClashWitness>()}) {
    const Camera camera = cameraForPair(Camera{}, at, large, small, 800.0 / 600.0);
    for (int corner = 0; corner < 8; ++corner) {
      const glm::dvec3 c((corner & 1) != 0 ? small.max.x : small.min.x,
                         (corner & 2) != 0 ? small.max.y : small.min.y,
                         (corner & 4) != 0 ? small.max.z : small.min.z);
      EXPECT_TRUE(inView(camera, c)) << corner;
    }
    EXPECT_TRUE(inView(camera, {0.0, 0.0, 0.0})) << "the middle of the larger one";
  }
}

TEST_F(VerdictLists, AClickOnAPairIsFlownToAndBack) {
  ViewerOptions options;
  options.width = 420;
  options.height = 320;
  auto opened = Viewer::openOffscreen(builder.scene, options);
  if (!opened) GTEST_SKIP() << opened.error().message;
  Viewer& viewer = **opened;
  find({hard(0, 1, 0.02), hard(2, 3, 0.005)});
  keep();
  apply(judge(*verdictsByPair(document).at({2, 3}), ClashStatus::approved, {"Ben", "press fit"}));
  for (int i = 0; i < 3; ++i) viewer.frame(model);
  const Camera before = viewer.camera();
  viewer.openClashes({0.0, false});
  for (int i = 0; i < 35; ++i) viewer.frame(model);
  EXPECT_GT(glm::distance(viewer.camera().target, before.target), 0.01);
  if (const char* path = std::getenv("TANDEM_KEEP_PICTURE")) {
    ASSERT_TRUE(viewer.screenshot(path).ok());
  }
  viewer.pressKey('B');
  for (int i = 0; i < 35; ++i) viewer.frame(model);
  EXPECT_NEAR(glm::distance(viewer.camera().target, before.target), 0.0, 1e-9);
  EXPECT_NEAR(viewer.camera().distance, before.distance, 1e-9);
}

}  // namespace
}  // namespace tandem::client
