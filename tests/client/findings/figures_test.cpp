// Figures for the document are those of the commands' arithmetic, and hold where the parts have been moved.

#include "client/findings/figures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include <glm/geometric.hpp>

#include "assets/document/entry_check.h"
#include "haptics/scene/contact_scene.h"
#include "tests/support/part_meshes.h"
#include "tests/support/random_numbers.h"
#include "tests/support/shapes.h"

namespace tandem::client {
namespace {

using document::MeasureKind;
using test::boxMesh;
using test::SceneBuilder;

const Figure* find(const std::vector<Figure>& figures, FigureKind kind) {
  for (const Figure& figure : figures)
    if (figure.kind == kind) return &figure;
  return nullptr;
}

struct Figures : testing::Test {
  SceneBuilder builder;
  std::vector<Pose> poses;

  const assets::Scene& scene() const { return builder.scene; }
  void part(const assets::Mesh& mesh, const Pose& pose) {
    builder.addPart(mesh);
    poses.push_back(pose);
  }
};

TEST_F(Figures, OneBoxHasAnEdgeAndNoDiameter) {
  part(boxMesh({0.01, 0.02, 0.03}), {{1.0, 0.0, 0.0}, glm::angleAxis(0.4, glm::dvec3(0.0, 1.0, 0.0))});
  const haptics::ContactScene contact(scene(), 1);
  const auto place = measurePlaceOn(contact, 0, {0.004, 0.003, 0.02});
  ASSERT_TRUE(place);
  const std::vector<MeasuredPlace> places{moved(*place, poses[0])};
  const std::vector<Figure> figures = figuresOf(places, {});
  ASSERT_EQ(figures.size(), 1u);
  EXPECT_NEAR(figures[0].value, 0.02, 1e-12);
  const document::Measure measure = toMeasure(figures[0], scene(), poses);
  EXPECT_EQ(measure.kind, MeasureKind::length);
  ASSERT_EQ(measure.anchors.size(), 2u);
  EXPECT_NEAR(glm::distance(measure.anchors[0].point, measure.anchors[1].point), 0.02, 1e-12)
      << "the ends of the edge, in the frame of the part";
}

TEST_F(Figures, TheAnchorsOfAFigureLieItsValueApart) {
  part(test::meshOf(test::prismSoup(
           [] {
             std::vector<glm::dvec2> outline;
             for (int i = 0; i < 48; ++i)
               outline.emplace_back(0.01 * std::cos(i * kPi / 24), 0.01 * std::sin(i * kPi / 24));
             return outline;
           }(),
           0.05)),
       {{0.0, 0.0, 0.3}, glm::angleAxis(0.7, glm::normalize(glm::dvec3(1.0, 2.0, 3.0)))});
  part(boxMesh({0.04, 0.04, 0.04}), {{0.2, 0.1, 0.0}, poses[0].orientation});
  const haptics::ContactScene contact(scene(), 1);
  const MeasuredPlace side = moved(*measurePlaceOn(contact, 0, {0.011, 0.0, 0.02}), poses[0]);
  const MeasuredPlace face = moved(*measurePlaceOn(contact, 1, {0.03, 0.0, 0.0}), poses[1]);
  const std::vector<MeasuredPlace> one{side}, two{side, face};
  const Figure* diameter = nullptr;
  const std::vector<Figure> ofOne = figuresOf(one, {}), ofTwo = figuresOf(two, {});
  ASSERT_NE(diameter = find(ofOne, FigureKind::diameter), nullptr);
  EXPECT_NEAR(diameter->value, 0.02, 1e-9);
  EXPECT_NEAR(glm::distance(diameter->line[0], diameter->line[1]), diameter->value, 1e-12);
  const Figure* across = find(ofTwo, FigureKind::across);
  ASSERT_NE(across, nullptr) << "an axis and a face along it";
  EXPECT_NEAR(glm::distance(across->line[0], across->line[1]), across->value, 1e-12);
  EXPECT_EQ(toMeasure(*across, scene(), poses).kind, MeasureKind::distance);
}

TEST_F(Figures, WhatIsMeasuredOfMovedPartsIsWhatAFileWithThemThereHas) {
  std::mt19937 random(18);
  const auto some = [&](double most) {
    return glm::dvec3(test::between(random, -most, most), test::between(random, -most, most),
                      test::between(random, -most, most));
  };
  part(boxMesh({0.01, 0.02, 0.03}), {});
  part(boxMesh({0.03, 0.02, 0.01}), {});
  const haptics::ContactScene contact(scene(), 1);
  const PartClosings closings(contact);
  for (int round = 0; round < 50; ++round) {
    for (Pose& pose : poses)
      pose = {some(0.03), glm::angleAxis(test::between(random, -3.0, 3.0), glm::normalize(some(1.0)))};
    SceneBuilder file;
    for (PartId p = 0; p < 2; ++p) file.addPart(scene().meshes[scene().parts[p].mesh], poses[p]);
    const haptics::ContactScene there(file.scene, 1);
    std::vector<MeasuredPlace> places, asCheck;
    for (PartId p = 0; p < 2; ++p) {
      places.push_back(moved(*measurePlaceOn(contact, p, {0.02, 0.001, 0.0}), poses[p]));
      asCheck.push_back(moved(*measurePlaceOn(there, p, {0.02, 0.001, 0.0}), poses[p]));
    }
    const auto parts = measurePair(closings, 0, poses[0], 1, poses[1]);
    const auto partsThere = measurePair(PartClosings(there), 0, poses[0], 1, poses[1]);
    const std::vector<Figure> here = figuresOf(places, parts), inFile = figuresOf(asCheck, partsThere);
    ASSERT_EQ(here.size(), inFile.size());
    for (std::size_t i = 0; i < here.size(); ++i)
      EXPECT_NEAR(here[i].value, inFile[i].value, 1e-9)
          << kFigureNames[static_cast<std::size_t>(here[i].kind)];
  }
}

TEST_F(Figures, PartsThatOverlapHaveANegativeClearance) {
  Clash clash;
  clash.a = 1;
  clash.b = 3;
  clash.kind = ClashKind::hard;
  clash.depth = 0.002;
  EXPECT_EQ(clearanceFigure(clash).value, -0.002);
  clash.kind = ClashKind::clearance;
  clash.distance = 0.004;
  EXPECT_EQ(clearanceFigure(clash).value, 0.004);
}

TEST_F(Figures, NamesOfPartsAreCutToWhatAnEntryHolds) {
  part(boxMesh(glm::dvec3(0.01)), {});
  builder.scene.parts[0].name.clear();
  for (int i = 0; i < 100; ++i) builder.scene.parts[0].name += "\u00f6";
  const document::Measure measure = toMeasure({FigureKind::length, 1.0, {{}}, {0}}, scene(), poses);
  EXPECT_EQ(measure.name.size(), document::kMaxName);
  EXPECT_TRUE(document::check(measure).ok());
  EXPECT_EQ(toMeasure({FigureKind::length, 1.0, {{}}, {0}}, scene(), poses, "pitch").name, "pitch");
}

TEST_F(Figures, QuantitiesHaveTheirUnits) {
  EXPECT_EQ(quantityInWords(MeasureKind::diameter, 0.0302), "30.2000 mm");
  EXPECT_EQ(quantityInWords(MeasureKind::clearance, -0.0000004), "-0.0004 mm");
  EXPECT_EQ(quantityInWords(MeasureKind::distance, 1.25), "1.250000 m");
  EXPECT_EQ(quantityInWords(MeasureKind::angle, kPi / 2), "90.000 deg");
}

}  // namespace
}  // namespace tandem::client
