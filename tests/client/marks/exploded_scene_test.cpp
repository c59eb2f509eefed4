// Parts that are drawn apart: groups from each other, parts within their groups, and no box over another.

#include "client/marks/exploded_scene.h"

#include <memory>
#include <random>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "client/picture/camera.h"
#include "client/viewer/viewer.h"

namespace tandem::client {
namespace {

using assets::Bounds;

Bounds boxAt(const glm::dvec3& centre, const glm::dvec3& size) {
  return {centre - 0.5 * size, centre + 0.5 * size};
}

/// A scene of boxes; `parents` are the groups of its tree, `boxes` the parts with the group of each.
struct Boxes {
  assets::Scene scene;
  std::vector<Bounds> boxes;

  std::uint32_t group(std::uint32_t parent = assets::kNone) {
    scene.tree.push_back({"group", parent});
    return static_cast<std::uint32_t>(scene.tree.size() - 1);
  }
  PartId part(const glm::dvec3& centre, const glm::dvec3& size, std::uint32_t group = assets::kNone) {
    assets::Part part;
    part.treeNode = group;
    scene.parts.push_back(part);
    boxes.push_back(boxAt(centre, size));
    return static_cast<PartId>(boxes.size() - 1);
  }
  std::vector<glm::dvec3> ways(const std::vector<PartId>& apart = {}) const {
    return waysApart(scene, boxes, apart);
  }
  /// How many pairs of boxes overlap once each has gone `factor` of its way.
  int overlaps(double factor, const std::vector<glm::dvec3>& ways) const {
    int count = 0;
    for (std::size_t a = 0; a < boxes.size(); ++a)
      for (std::size_t b = 0; b < a; ++b) {
        bool apart = false;
        for (int axis = 0; axis < 3; ++axis)
          apart = apart ||
                  boxes[a].min[axis] + factor * ways[a][axis] > boxes[b].max[axis] + factor * ways[b][axis] ||
                  boxes[b].min[axis] + factor * ways[b][axis] > boxes[a].max[axis] + factor * ways[a][axis];
        count += apart ? 0 : 1;
      }
    return count;
  }
};

TEST(ExplodedScene, AStackComesApartAlongItselfInItsOrder) {
  Boxes stack;
  for (const double z : {0.0, 0.01, 0.02, 0.03, 0.04}) stack.part({0.0, 0.0, z}, {0.05, 0.05, 0.01});
  const std::vector<glm::dvec3> ways = stack.ways();
  EXPECT_EQ(stack.overlaps(1.0, ways), 0);
  for (const glm::dvec3& way : ways) EXPECT_EQ(glm::dvec2(way), glm::dvec2(0.0));
  for (std::size_t i = 1; i < ways.size(); ++i) EXPECT_GT(ways[i].z, ways[i - 1].z);
  EXPECT_EQ(ways[2].z, 0.0) << "the one in the middle stays";
}

TEST(ExplodedScene, WhatIsInsideOfTheLargestPartComesOutOfIt) {
  Boxes pump;
  pump.part({0.0, 0.0, 0.0}, {0.2, 0.2, 0.2});
  pump.part({0.0, 0.0, 0.03}, {0.05, 0.05, 0.1});
  pump.part({0.0, 0.0, 0.0}, {0.02, 0.02, 0.02});
  pump.part({0.08, 0.08, 0.1}, {0.01, 0.01, 0.04});
  const std::vector<glm::dvec3> ways = pump.ways();
  EXPECT_EQ(pump.overlaps(1.0, ways), 0);
  EXPECT_EQ(ways[0], glm::dvec3(0.0)) << "the housing stays";
  EXPECT_GT(ways[1].z, 0.1) << "the shaft goes the way that its middle lies";
  EXPECT_EQ(glm::dvec2(ways[1]), glm::dvec2(0.0));
}

TEST(ExplodedScene, GroupsMoveAsOneAndPartsWithinThem) {
  Boxes boxes;
  const std::uint32_t all = boxes.group(), left = boxes.group(all), right = boxes.group(all);
  for (const double x : {-0.06, -0.04}) boxes.part({x, 0.0, 0.0}, {0.02, 0.02, 0.02}, left);
  for (const double x : {0.04, 0.06}) boxes.part({x, 0.0, 0.0}, {0.02, 0.02, 0.02}, right);
  const std::vector<glm::dvec3> ways = boxes.ways();
  EXPECT_EQ(boxes.overlaps(1.0, ways), 0);
  EXPECT_LT(ways[0].x, ways[1].x);
  EXPECT_LT(ways[1].x, 0.0) << "both of the left group go left";
  EXPECT_NEAR(ways[0].x, -ways[3].x, 1e-12);
  EXPECT_NEAR(ways[1].x, -ways[2].x, 1e-12);
}

TEST(ExplodedScene, AGroupAloneComesApartFromItsOwnMiddle) {
  Boxes boxes;
  const std::uint32_t group = boxes.group();
  boxes.part({-0.2, 0.0, 0.0}, {0.1, 0.1, 0.1});
  const PartId a = boxes.part({0.1, 0.0, 0.0}, {0.02, 0.02, 0.02}, group);
  const PartId b = boxes.part({0.12, 0.0, 0.0}, {0.02, 0.02, 0.02}, group);
  const std::vector<glm::dvec3> ways = boxes.ways({a, b});
  EXPECT_EQ(ways[0], glm::dvec3(0.0));
  EXPECT_LT(ways[a].x, 0.0);
  EXPECT_NEAR(ways[a].x, -ways[b].x, 1e-12);
}

TEST(ExplodedScene, RandomAssembliesDoNotOverlapFullyApart) {
  std::mt19937 random(7);
  const auto between = [&](double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random);
  };
  for (int scene = 0; scene < 20; ++scene) {
    Boxes boxes;
    std::vector<std::uint32_t> groups{assets::kNone};
    for (int i = 0; i < 8; ++i) groups.push_back(boxes.group(groups[random() % groups.size()]));
    for (int i = 0; i < 60; ++i)
      boxes.part({between(-0.1, 0.1), between(-0.1, 0.1), between(-0.1, 0.1)},
                 {between(0.001, 0.1), between(0.001, 0.1), between(0.001, 0.1)},
                 groups[random() % groups.size()]);
    ASSERT_GT(boxes.overlaps(0.0, boxes.ways()), 20);
    EXPECT_EQ(boxes.overlaps(1.0, boxes.ways()), 0);
  }
}

TEST(ExplodedScene, PartsWithoutASizeAndManyAreNoTrouble) {
  Boxes boxes;
  for (int i = 0; i < 3000; ++i) boxes.part({0.01 * i, 0.0, 0.0}, {0.01, 0.01, 0.01});
  boxes.part({0.0, 0.0, 0.0}, {0.01, 0.01, 0.01});
  boxes.boxes.back() = Bounds{};
  const std::vector<glm::dvec3> ways = boxes.ways();
  EXPECT_EQ(ways.back(), glm::dvec3(0.0));
  EXPECT_LT(ways.front().x, -10.0);
  EXPECT_TRUE(Boxes{}.ways().empty());
}

/// A window on two small boxes; what is under the mouse is what the person, who presents, points at.
struct ExplodedWindow : testing::Test {
  Boxes row;
  ViewModel model;
  std::unique_ptr<Viewer> viewer;

  void open(double explode) {
    for (const double x : {-0.02, 0.02}) {
      const PartId part = row.part({x, 0.0, 0.0}, {0.03, 0.03, 0.03});
      assets::ImplicitShape shape;
      shape.kind = assets::ImplicitShape::Kind::box;
      shape.size = {0.03, 0.03, 0.03};
      row.scene.parts[part].shapes.push_back(shape);
      row.scene.parts[part].movable = true;
      row.scene.parts[part].worldFromPart.position.x = x;
      model.worldFromPart.push_back(row.scene.parts[part].worldFromPart);
    }
    row.scene.materials.resize(1);
    row.scene.bounds = {{-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}};
    model.scene = &row.scene;
    model.owner.assign(2, kNoSite);
    model.role = sync::Role::participant;
    ViewerOptions options;
    options.width = 480;
    options.height = 320;
    options.panels = false;
    options.style.explode = explode;
    options.shares = sync::Shares::view;
    auto opened = Viewer::openOffscreen(row.scene, options);
    if (!opened) GTEST_SKIP() << opened.error().message;
    viewer = std::move(*opened);
    viewer->camera() = {{0.0, 0.0, 0.0}, 0.4, 0.0, 0.0, 0.7};
    for (int i = 0; i < 3; ++i) static_cast<void>(viewer->frame(model));
  }
  /// Presses the left button where a place of the world is drawn.
  ViewActions press(const glm::dvec3& place) {
    const View view = makeView(viewer->camera(), {480.0, 320.0}, {{0.0, 0.0, 0.0}, 0.2});
    viewer->pointMouse(*view.project(place), false);
    static_cast<void>(viewer->frame(model));
    viewer->pointMouse(*view.project(place), true);
    return viewer->frame(model);
  }
  glm::dvec3 rightEnd() const {
    const double way = row.ways()[1].x;
    EXPECT_GT(way, 0.008);
    return {0.02 + 0.5 * way + 0.012, 0.0, 0.015};
  }
};

TEST_F(ExplodedWindow, PointsAtPartsWhereTheyAreDrawnAndTakesNone) {
  open(0.5);
  if (!viewer) return;
  const ViewActions actions = press(rightEnd());
  EXPECT_TRUE(actions.lifted);
  EXPECT_FALSE(actions.grasp);
  ASSERT_EQ(actions.shown.pointedAt, 1);
  EXPECT_LT(glm::distance(actions.shown.place, glm::dvec3(0.012, 0.0, 0.015)), 1e-3);
}

TEST_F(ExplodedWindow, WholeItTakesThemAndNothingIsThereWhereTheyWouldBeDrawn) {
  open(0.0);
  if (!viewer) return;
  ViewActions actions = press({0.02, 0.0, 0.015});
  EXPECT_FALSE(actions.lifted);
  EXPECT_TRUE(actions.grasp);
  EXPECT_EQ(actions.graspedAt, 1);
  viewer->pointMouse({1.0, 1.0}, false);
  static_cast<void>(viewer->frame(model));
  actions = press(rightEnd() + glm::dvec3(0.01, 0.0, 0.0));
  EXPECT_EQ(actions.shown.pointedAt, kNoPart);
}

}  // namespace
}  // namespace tandem::client
