// Ways out of assemblies whose answer is known: straight, round a corner, blocked, against a spring, in
// order.

#include "client/extraction/part_extraction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include <glm/geometric.hpp>

#include "client/extraction/extraction_order.h"
#include "tests/support/bench_meshes.h"
#include "tests/support/shapes.h"

namespace tandem::test {
namespace {

using client::Extraction;
using client::ExtractionOptions;
using client::ExtractionOrder;
using client::PartExtractor;

/// Boxes, the first of which can be moved.
class BoxAssembly {
 public:
  explicit BoxAssembly(double scale = 1.0, const glm::dquat& turn = {1.0, 0.0, 0.0, 0.0})
      : scale_(scale), turn_(turn) {}

  PartId add(const std::string& name, const glm::dvec3& least, const glm::dvec3& most, bool movable = false) {
    assets::Scene box = tests::sceneOf(boxMesh(scale_ * (most - least)));
    assets::Part part = box.parts[0];
    part.mesh = static_cast<std::uint32_t>(scene_.meshes.size());
    part.name = name;
    part.movable = movable;
    part.worldFromPart = {turn_ * (0.5 * scale_ * (least + most)), turn_};
    scene_.meshes.push_back(box.meshes[0]);
    if (scene_.materials.empty()) scene_.materials = box.materials;
    scene_.parts.push_back(part);
    return static_cast<PartId>(scene_.parts.size() - 1);
  }
  /// Walls of 2 mm about a hollow, but for those whose letter is in `open`: "x" stands at the least x, "X" at
  /// the greatest.
  void wallAbout(const glm::dvec3& least, const glm::dvec3& most, const std::string& open) {
    for (int i = 0; i < 3; ++i) {
      glm::dvec3 from = least - 2e-3, to = most + 2e-3;
      const std::string low(1, "xyz"[i]), high(1, "XYZ"[i]);
      to[i] = least[i];
      if (open.find(low) == std::string::npos) add("wall " + low, from, to);
      from[i] = most[i];
      to[i] = most[i] + 2e-3;
      if (open.find(high) == std::string::npos) add("wall " + high, from, to);
    }
  }
  const assets::Scene& scene(const ExtractionOptions& options = {}) {
    client::lightenParts(scene_, options);
    scene_.bounds = {glm::dvec3(1e9), glm::dvec3(-1e9)};
    for (const assets::Part& part : scene_.parts) {
      const double reach = glm::length(scene_.meshes[part.mesh].bounds.max);
      scene_.bounds.min = glm::min(scene_.bounds.min, part.worldFromPart.position - reach);
      scene_.bounds.max = glm::max(scene_.bounds.max, part.worldFromPart.position + reach);
    }
    return scene_;
  }
  assets::Scene& edit() { return scene_; }

 private:
  double scale_;
  glm::dquat turn_;
  assets::Scene scene_;
};

Extraction extract(BoxAssembly& assembly, const ExtractionOptions& options = {}) {
  haptics::ContactScene contact(assembly.scene(options), 1);
  EXPECT_TRUE(contact.modelParts());
  return PartExtractor(contact, options).extract(0);
}

const glm::dvec3 kCube(5e-3);

TEST(PartExtraction, LeavesAHoleByItsMouth) {
  const glm::dquat turn = glm::angleAxis(0.4, glm::normalize(glm::dvec3(1.0, 2.0, 3.0)));
  for (const double scale : {0.01, 1.0, 100.0}) {
    BoxAssembly assembly(scale, turn);
    assembly.add("cube", -kCube, kCube, true);
    assembly.wallAbout(-kCube - 5e-5, kCube + 5e-5, "Y");
    const Extraction out = extract(assembly);
    ASSERT_TRUE(out.free) << scale;
    ASSERT_EQ(out.way.size(), 1u);
    EXPECT_GT(glm::dot(out.way[0].axis, turn * glm::dvec3(0.0, 1.0, 0.0)), 0.9999);
    EXPECT_NEAR(out.way[0].distance, scale * 0.0122, scale * 0.001) << "the cube and a little more";
    EXPECT_LT(out.force, 0.1);
    EXPECT_TRUE(out.blockedBy.empty());
  }
}

TEST(PartExtraction, SaysWhatStandsRoundAPartThatCannotLeave) {
  BoxAssembly assembly;
  assembly.add("cube", -kCube, kCube, true);
  assembly.wallAbout(-kCube - 1e-3, kCube + 1e-3, "");
  const Extraction out = extract(assembly);
  EXPECT_FALSE(out.free);
  EXPECT_EQ(out.blockedBy, (std::vector<PartId>{1, 2, 3, 4, 5, 6}));
}

TEST(PartExtraction, GoesRoundACorner) {
  BoxAssembly assembly;
  assembly.add("cube", -kCube, kCube, true);
  // A corridor along x, open upwards at its far end alone.
  assembly.wallAbout(glm::dvec3(-5.2e-3), glm::dvec3(35e-3, 5.2e-3, 5.2e-3), "Y");
  assembly.add("roof", glm::dvec3(-8e-3, 5.2e-3, -8e-3), glm::dvec3(20e-3, 8e-3, 8e-3));
  const Extraction out = extract(assembly);
  ASSERT_TRUE(out.free);
  ASSERT_EQ(out.way.size(), 2u);
  EXPECT_GT(out.way[0].axis.x, 0.9999);
  EXPECT_NEAR(out.way[0].distance, 30e-3, 0.2e-3);
  EXPECT_GT(out.way[1].axis.y, 0.9999);
  ExtractionOptions straight;
  straight.maxPulls = 6;
  EXPECT_FALSE(extract(assembly, straight).free) << "without a search from where it got stuck";
}

TEST(PartExtraction, ForceAndWorkAreThoseOfTheSpringThatHoldsThePart) {
  constexpr double kStiffness = 100.0;
  BoxAssembly assembly;
  assembly.add("slider", -kCube, kCube, true);
  assembly.wallAbout(-kCube - 5e-5, kCube + 5e-5, "Y");
  assets::Joint joint;
  joint.partA = kNoPart;
  joint.partB = 0;
  joint.collide = true;
  joint.limits = {{false, 0b101, 0.0, 0.0}, {true, 0b111, 0.0, 0.0}, {false, 0b010, 0.0, 0.0, kStiffness}};
  assembly.edit().joints = {joint};
  const Extraction out = extract(assembly);
  ASSERT_TRUE(out.free);
  const double way = out.way[0].distance;
  EXPECT_NEAR(out.force, kStiffness * way, 0.02 * kStiffness * way);
  EXPECT_NEAR(out.work, 0.5 * kStiffness * way * way, 0.02 * 0.5 * kStiffness * way * way);
  ExtractionOptions weak;
  weak.maxForce = 0.5 * kStiffness * way;
  EXPECT_FALSE(extract(assembly, weak).free);
}

TEST(PartExtraction, TakesTheLidOffBeforeWhatIsUnderIt) {
  BoxAssembly assembly;
  assembly.add("cube", -kCube, kCube, true);
  const PartId lid = assembly.add("lid", {-8e-3, 8e-3, -8e-3}, {8e-3, 9e-3, 8e-3}, true);
  assembly.wallAbout(-kCube - 1e-4, kCube + 1e-4, "Y");
  haptics::ContactScene contact(assembly.scene(), 1);
  ASSERT_TRUE(contact.modelParts());
  PartExtractor extractor(contact, {});
  const Extraction covered = extractor.extract(0);
  EXPECT_FALSE(covered.free);
  EXPECT_NE(std::find(covered.blockedBy.begin(), covered.blockedBy.end(), lid), covered.blockedBy.end());
  const ExtractionOrder order = extractionOrder(extractor, assembly.scene().parts.size(), [](double) {});
  EXPECT_EQ(order.order, (std::vector<PartId>{lid, 0}));
  ASSERT_EQ(order.parts.size(), 2u);
  EXPECT_EQ(order.parts[0].way[0].distance, 0.0) << "nothing lies over the lid";
}

TEST(PartExtraction, IsTheSameEachTime) {
  BoxAssembly assembly;
  assembly.add("cube", -kCube, kCube, true);
  assembly.wallAbout(-kCube - 5e-5, kCube + 5e-5, "zX");
  const Extraction a = extract(assembly), b = extract(assembly);
  EXPECT_EQ(a.way[0].axis, b.way[0].axis);
  EXPECT_EQ(a.force, b.force);
  EXPECT_EQ(a.work, b.work);
}

}  // namespace
}  // namespace tandem::test
