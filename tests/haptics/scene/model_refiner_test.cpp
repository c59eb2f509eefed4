// Coarse models that are refined while a part is felt: a hand feels nothing of it, the nearest come first,
// and the end is what a bake at once would have made.

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <memory>
#include <thread>
#include <tuple>
#include <vector>

#include "haptics/scene/contact_scene_data.h"
#include "haptics/scene/model_bake.h"
#include "haptics/scene/model_refiner.h"
#include "tests/support/full_size.h"
#include "tests/support/held_part_rig.h"
#include "tests/support/irregular_shapes.h"

namespace tandem::test {
namespace {

using haptics::ContactScene;

haptics::ModelOptions fineModels() {
  haptics::ModelOptions options;
  options.threads = 1;
  return options;
}

haptics::ModelOptions coarseModels() {
  haptics::ModelOptions options = fineModels();
  options.coarse = true;
  return options;
}

/// The scene with every coarse model refined, as each step of a refiner leaves it.
std::vector<ContactScene> refined(const ContactScene& coarse) {
  const ContactScene::Data& data = coarse.data();
  const std::vector<double> tolerances =
      data.treeTolerances(haptics::partTolerances(*data.scene, data.colliders, data.smallestHeld(), 1));
  const haptics::BakePlan plan{data.smallestHeld(), haptics::fieldsOf(data.trees, data.shapes)};
  std::vector<ContactScene> scenes;
  for (std::size_t i = 0; i < data.models.size(); ++i) {
    if (data.models[i] == nullptr || !data.models[i]->coarse) continue;
    auto fine = haptics::bakeModel(*data.trees[i], tolerances[i], plan, {}, data.models[i]->features);
    scenes.push_back((scenes.empty() ? coarse : scenes.back()).withModel(i, std::move(fine)));
  }
  return scenes;
}

/// The scene with fields of meshes that are `larger` times as large: each is wrong by that.
ContactScene wronglyRefined(const ContactScene& coarse, double larger,
                            std::vector<std::unique_ptr<assets::Mesh>>& meshes) {
  const ContactScene::Data& data = coarse.data();
  std::vector<ContactScene> scenes;
  for (std::size_t i = 0; i < data.models.size(); ++i) {
    if (data.models[i] == nullptr) continue;
    meshes.push_back(std::make_unique<assets::Mesh>(data.trees[i]->mesh()));
    for (glm::dvec3& p : meshes.back()->positions) p *= larger;
    const haptics::TriangleBvh tree(*meshes.back(), 1);
    scenes.push_back(
        (scenes.empty() ? coarse : scenes.back())
            .withModel(i, std::make_shared<haptics::PartModel>(*data.trees[i], data.models[i]->features,
                                                               haptics::DistanceField(tree, {}))));
  }
  return std::move(scenes.back());
}

constexpr double kAbove = 0.055, kPress = 0.002;             // m
constexpr double kExchanges[] = {0.6, 0.75};                 // s, of the models of either part
constexpr double kDown = 0.5, kLift = 1.0, kDuration = 2.0;  // s

/// Two parts of a family, one held `kAbove` over the other, brought down to `low` until kDown, slid aside by
/// 10 mm, lifted at kLift, and all of it once more from there.
PartCase pressedTwice(Family family, unsigned seed, double low) {
  Random random(seed);
  const auto any = [&] {
    const double x = between(random, -3.0, 3.0), y = between(random, -3.0, 3.0);
    return fromRotationVector({x, y, between(random, -3.0, 3.0)});
  };
  const glm::dquat lying = any(), turned = any();
  const Pose start{{0.002, -0.001, kAbove}, turned};
  const DevicePath path = [start, low](double time) {
    const double cycle = time < kLift ? time : time - kLift;
    const double down = std::max(std::min({cycle / kDown, 1.0, (kLift - cycle) / 0.15}), 0.0);
    const double across = std::clamp(time - kDown, 0.0, 0.35) + std::clamp(time - kLift - kDown, 0.0, 0.35);
    return Pose{start.position + glm::dvec3(0.028 * across, 0.010 * across, (low - kAbove) * down),
                start.orientation};
  };
  assets::Scene scene = sceneOfParts(
      {{.name = "under", .mesh = irregularMesh(family, 2 * seed), .worldFromPart = {{0.0, 0.0, 0.0}, lying}},
       {.name = "held",
        .mesh = irregularMesh(family, 2 * seed + 1),
        .worldFromPart = start,
        .movable = true,
        .mass = 0.05}});
  return {"pressed twice", std::move(scene), 1, path, kDuration, {}};
}

/// The same, pressed by kPress.
PartCase pressedTwice(Family family, unsigned seed) {
  HeldPartRig falling(pressedTwice(family, seed, 0.0), rigParameters(), coarseModels());
  falling.runTo(kDown, 0);
  for (const RigTick& tick : falling.ticks())
    if (tick.contacts > 0) return pressedTwice(family, seed, tick.device.position.z - kPress);
  ADD_FAILURE() << "the parts do not meet";
  return pressedTwice(family, seed, kAbove);
}

/// By how much two hands that are led alike differ at most, N.
double mostDifference(const HeldPartRig& a, const HeldPartRig& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.ticks().size(); ++i)
    most = std::max(most, glm::length(a.ticks()[i].toHand.force - b.ticks()[i].toHand.force));
  return most;
}

/// How far the forces are apart in one tick, N.
double differenceAt(const HeldPartRig& a, const HeldPartRig& b, double time) {
  for (std::size_t i = 0; i < a.ticks().size(); ++i)
    if (a.ticks()[i].time > time - 1e-6)
      return glm::length(a.ticks()[i].toHand.force - b.ticks()[i].toHand.force);
  return 0.0;
}

class RefinedWhileFelt : public testing::TestWithParam<std::tuple<Family, unsigned>> {};

TEST_P(RefinedWhileFelt, ChangesNoForce) {
  const auto [family, seed] = GetParam();
  const PartCase given = pressedTwice(family, seed);
  HeldPartRig coarse(given, rigParameters(), coarseModels()), once(given, rigParameters(), coarseModels()),
      changed(given, rigParameters(), coarseModels());
  const std::vector<ContactScene> scenes = refined(changed.contact());
  ASSERT_EQ(scenes.size(), 2u);
  coarse.run(20);
  ASSERT_GT(coarse.mostForce(), 1.0) << "the parts meet";
  for (std::size_t i = 0; i < 2; ++i) {
    changed.runTo(kExchanges[i], 20);
    changed.refine(scenes[i]);
  }
  changed.run(20);
  once.runTo(kExchanges[0], 20);
  once.refine(scenes[0]);
  once.run(20);
  // Each exchange against the hand that has all but that one behind it.
  const double atOnce =
      std::max(differenceAt(coarse, changed, kExchanges[0]), differenceAt(once, changed, kExchanges[1]));
  std::printf(
      "%s %u: force %.2f N, differs by %.4f N, at the exchanges by %.4f N; depth um %.2f coarse, %.2f; "
      "tick us p50 %.0f, %.0f p99 %.0f, %.0f\n",
      familyName(family), seed, coarse.mostForce(), mostDifference(coarse, changed), atOnce,
      1e6 * coarse.deepest(), 1e6 * changed.deepest(), 1e6 * quantile(coarse.cpuTimes(), 0.5),
      1e6 * quantile(changed.cpuTimes(), 0.5), 1e6 * quantile(coarse.cpuTimes(), 0.99),
      1e6 * quantile(changed.cpuTimes(), 0.99));
  EXPECT_FALSE(coarse.everFlagged(haptics::kFlagOverflow));
  EXPECT_LT(atOnce, 0.02);
  // Facets that are snapped over a tick earlier or later make the rest.
  EXPECT_LT(mostDifference(coarse, changed), 0.2);
}

INSTANTIATE_TEST_SUITE_P(Families, RefinedWhileFelt,
                         testing::Combine(testing::Values(Family::blobs, Family::blocks, Family::turned),
                                          testing::Range(1u, atFullSize() ? 9u : 2u)));

TEST(ModelRefiner, WithFieldsOfSmallerMeshesWouldBeFelt) {
  const PartCase given = pressedTwice(Family::blobs, 2);
  HeldPartRig coarse(given, rigParameters(), coarseModels()), wrong(given, rigParameters(), coarseModels());
  std::vector<std::unique_ptr<assets::Mesh>> meshes;
  const ContactScene smaller = wronglyRefined(wrong.contact(), 0.9, meshes);
  coarse.run(0);
  wrong.runTo(kExchanges[0], 0);
  wrong.refine(smaller);
  wrong.run(0);
  EXPECT_GT(mostDifference(coarse, wrong), 0.4);
}

/// What coarse fields cost where contact is hardest: a peg in its bore. Most of its samples are within the
/// error of the bore's field, so steps are cut short, and the force changes faster than with fine fields.
TEST(ModelRefiner, IsNotNeededForAPegToGoIn) {
  PegCase peg;
  peg.diametralClearance = 20e-6;
  peg.triangles = atFullSize() ? 50'000 : 1'500;
  HeldPartRig coarse(pegCase(peg), rigParameters(), coarseModels());
  coarse.run(20);
  std::printf(
      "a peg of %d triangles: depth %.2f um; change of force a tick N p99 %.3f; tick us p50 %.0f p99 %.0f "
      "longest %.0f\n",
      peg.triangles, 1e6 * coarse.deepest(), quantile(coarse.forceSteps(), 0.99),
      1e6 * quantile(coarse.cpuTimes(), 0.5), 1e6 * quantile(coarse.cpuTimes(), 0.99),
      1e6 * quantile(coarse.cpuTimes(), 1.0));
  EXPECT_LT(coarse.deepest(), 5e-6);
  EXPECT_LT(coarse.last().part.position.z, -0.037) << "how deep it went";
}

/// Boxes in a row along x, 0.1 m apart, the first at the origin.
assets::Scene rowOfBoxes(int count) {
  std::vector<CasePart> parts;
  for (int i = 0; i < count; ++i) {
    const double size = 0.02 + 0.001 * i;
    parts.push_back({.name = "box" + std::to_string(i),
                     .mesh = meshOf(boxSoup({size, 0.02, 0.02})),
                     .worldFromPart = {{0.1 * i, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}},
                     .movable = true});
  }
  return sceneOfParts(parts);
}

std::size_t coarseOf(const ContactScene& scene) {
  const auto& models = scene.data().models;
  return static_cast<std::size_t>(
      std::count_if(models.begin(), models.end(), [](const auto& model) { return model->coarse; }));
}

template <typename Condition>
bool soon(const Condition& condition) {
  for (int i = 0; i < 6000 && !condition(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  return condition();
}

TEST(ModelRefiner, EndsWithTheModelsOfABakeAtOnce) {
  const assets::Scene scene = rowOfBoxes(4);
  ContactScene coarse(scene, 1), atOnce(scene, 1);
  ASSERT_TRUE(coarse.modelParts(coarseModels()));
  ASSERT_TRUE(atOnce.modelParts(fineModels()));
  EXPECT_EQ(coarseOf(coarse), 4u);
  haptics::ModelRefiner refiner(coarse, fineModels(), [] { return glm::dvec3(0.0); });
  ASSERT_TRUE(soon([&] { return refiner.done() >= 1.0; }));
  const ContactScene& fine = refiner.newest();
  EXPECT_EQ(coarseOf(fine), 0u);
  EXPECT_EQ(coarseOf(coarse), 4u) << "the scene that it began with is as it was";
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(fine.data().models[i]->field.pack(), atOnce.data().models[i]->field.pack());
    EXPECT_EQ(fine.data().models[i]->features, coarse.data().models[i]->features);
    EXPECT_EQ(fine.data().colliders[i].model, fine.data().models[i].get());
  }
}

TEST(ModelRefiner, KeepsNoCoarseModelThatTheHandHasLeft) {
  const assets::Scene scene = rowOfBoxes(4);
  ContactScene coarse(scene, 1);
  ASSERT_TRUE(coarse.modelParts(coarseModels()));
  std::vector<std::weak_ptr<const haptics::PartModel>> models(coarse.data().models.begin(),
                                                              coarse.data().models.end());
  // Whenever the refiner asks where the hand is, the ticks go on to its newest scene.
  std::atomic<haptics::ModelRefiner*> itself{nullptr};
  haptics::ModelRefiner refiner(std::move(coarse), fineModels(), [&] {
    while (itself.load() == nullptr) std::this_thread::yield();
    itself.load()->newest();
    return glm::dvec3(0.0);
  });
  itself = &refiner;
  ASSERT_TRUE(soon([&] { return refiner.done() >= 1.0; }));
  // The ticks have not gone on to the last scene, so the last coarse model is still in use.
  const auto ended = std::count_if(models.begin(), models.end(), [](const auto& m) { return m.expired(); });
  EXPECT_EQ(ended, 3);
}

TEST(ModelRefiner, TakesTheNearestToTheHandFirst) {
  const assets::Scene scene = rowOfBoxes(4);
  ContactScene coarse(scene, 1);
  ASSERT_TRUE(coarse.modelParts(coarseModels()));
  // Each time that it asks, the hand is at another box.
  const int order[] = {2, 0, 3, 1};
  std::atomic<haptics::ModelRefiner*> itself{nullptr};
  std::size_t asked = 0;
  std::vector<std::vector<bool>> seen;
  haptics::ModelRefiner refiner(coarse, fineModels(), [&] {
    while (itself.load() == nullptr) std::this_thread::yield();
    std::vector<bool> isCoarse;
    for (const auto& model : itself.load()->newest().data().models) isCoarse.push_back(model->coarse);
    seen.push_back(isCoarse);
    return glm::dvec3(0.1 * order[asked++], 0.0, 0.0);
  });
  itself = &refiner;
  ASSERT_TRUE(soon([&] { return refiner.done() >= 1.0; }));
  ASSERT_EQ(seen.size(), 4u);
  for (std::size_t k = 1; k < 4; ++k)
    for (std::size_t i = 0; i < k; ++i) EXPECT_FALSE(seen[k][static_cast<std::size_t>(order[i])]);
}

TEST(ModelRefiner, StopsInTheMidstOfAMesh) {
  std::vector<CasePart> parts{{.name = "blob", .mesh = irregularMesh(Family::blobs, 1), .movable = true}};
  const assets::Scene scene = sceneOfParts(parts);
  ContactScene coarse(scene, 1);
  ASSERT_TRUE(coarse.modelParts(coarseModels()));
  std::atomic<bool> begun{false};
  haptics::ModelOptions fine = fineModels();
  fine.fieldScale = 0.05;  // minutes
  auto refiner = std::make_unique<haptics::ModelRefiner>(coarse, fine, [&] {
    begun = true;
    return glm::dvec3(0.0);
  });
  ASSERT_TRUE(soon([&] { return begun.load(); }));
  refiner.reset();  // the test ends
}

TEST(ModelRefiner, HasNothingToDoWhereNothingIsCoarse) {
  const assets::Scene scene = rowOfBoxes(1);
  ContactScene contact(scene, 1);
  ASSERT_TRUE(contact.modelParts(fineModels()));
  haptics::ModelRefiner refiner(contact, {}, [] { return glm::dvec3(0.0); });
  EXPECT_EQ(refiner.done(), 1.0);
  EXPECT_EQ(refiner.newest().data().models, contact.data().models);
}

}  // namespace
}  // namespace tandem::test
