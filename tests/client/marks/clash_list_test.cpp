// The search for clashes in its thread, and the list of its findings apart from drawing.

#include "client/marks/clash_list.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "client/review/clash_search.h"
#include "haptics/scene/contact_scene.h"
#include "tests/support/bench_meshes.h"
#include "tests/support/shapes.h"

namespace tandem::client {
namespace {

constexpr double kSide = 0.01;  // m

/// Cubes of 10 mm with their middles at these places along x.
assets::Scene cubesAt(const std::vector<double>& places) {
  assets::Scene scene = tests::sceneOf(test::boxMesh(glm::dvec3(kSide)));
  const assets::Part cube = scene.parts[0];
  scene.parts.clear();
  for (const double x : places) {
    scene.parts.push_back(cube);
    scene.parts.back().name = std::string(1, static_cast<char>('a' + scene.parts.size() - 1));
    scene.parts.back().worldFromPart.position = {x, 0.0, 0.0};
  }
  return scene;
}

std::vector<Pose> posesOf(const assets::Scene& scene) {
  std::vector<Pose> poses;
  for (const assets::Part& part : scene.parts) poses.push_back(part.worldFromPart);
  return poses;
}

/// a and b overlap by 1 mm, c is 0.5 mm from b, d touches nobody.
assets::Scene row() { return cubesAt({0.0, 0.009, 0.0195, 0.05}); }

TEST(ClashSearch, TellsOverlapsAtRestFromThoseThatCameAbout) {
  const assets::Scene scene = row();
  const haptics::ContactScene contact(scene, 1);
  std::vector<Pose> poses = posesOf(scene);
  const ClashFindings before = searchClashes(contact, {1e-3, false}, poses);
  ASSERT_EQ(before.found.size(), 2u);
  EXPECT_TRUE(before.found[0].overlapsAtRest);
  EXPECT_NEAR(before.found[0].clash.depth, 1e-3, 1e-5);
  EXPECT_EQ(before.found[1].clash.kind, ClashKind::clearance);
  poses[3].position.x = 0.0195 + 0.0098;  // d overlaps c by 0.2 mm: less than a and b, but not at rest
  const ClashFindings after = searchClashes(contact, {1e-3, false}, poses);
  ASSERT_EQ(after.found.size(), 3u);
  EXPECT_EQ(after.found[0].clash.a, 2);
  EXPECT_EQ(after.found[0].clash.b, 3);
  EXPECT_FALSE(after.found[0].overlapsAtRest);
  EXPECT_NEAR(after.found[0].clash.depth, 2e-4, 2e-6);
  EXPECT_TRUE(after.found[1].overlapsAtRest);
  const ClashCounts counts = countClashes(after);
  EXPECT_EQ(counts.hard, 1u);
  EXPECT_EQ(counts.atRest, 1u);
  EXPECT_EQ(counts.near, 1u);
}

TEST(ClashSearch, AtRestLooksAtTheSceneWhereverPartsAreNow) {
  const assets::Scene scene = row();
  const haptics::ContactScene contact(scene, 1);
  std::vector<Pose> poses = posesOf(scene);
  for (Pose& pose : poses) pose.position.y = pose.position.x * 100.0;
  EXPECT_TRUE(searchClashes(contact, {1e-3, false}, poses).found.empty());
  EXPECT_EQ(searchClashes(contact, {1e-3, true}, poses).found.size(), 2u);
  EXPECT_EQ(searchClashes(contact, {0.1e-3, true}, poses).found.size(), 1u) << "the clearance that was asked";
}

TEST(ClashSearch, WhatIsStoppedSaysSo) {
  const assets::Scene scene = row();
  const haptics::ContactScene contact(scene, 1);
  const std::atomic<bool> stop{true};
  const ClashFindings findings = searchClashes(contact, {1e-3, true}, {}, {}, &stop);
  EXPECT_FALSE(findings.complete);
  EXPECT_TRUE(findings.found.empty());
  EXPECT_EQ(findings.pairs, 2u);
}

/// Polls as a window would until the search has ended; false after twenty seconds.
bool ends(const ClashSearch& search) {
  for (int i = 0; i < 4000 && search.view().running; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  return !search.view().running;
}

TEST(ClashSearch, AnswersFromItsThreadAndKeepsTheLastAnswerMeanwhile) {
  const assets::Scene scene = row();
  const haptics::ContactScene contact(scene, 1);
  ClashSearch search(contact);
  EXPECT_TRUE(search.view().possible);
  EXPECT_FALSE(search.view().running) << "nobody has asked";
  EXPECT_EQ(search.view().findings, nullptr);
  search.start({1e-3, true}, {});
  ASSERT_TRUE(ends(search));
  const ClashSearchView view = search.view();
  ASSERT_NE(view.findings, nullptr);
  EXPECT_EQ(view.findings->found.size(), 2u);
  EXPECT_EQ(view.done, view.pairs);
  search.start({0.1e-3, true}, {});
  EXPECT_NE(search.view().findings, nullptr);
  ASSERT_TRUE(ends(search));
  EXPECT_EQ(search.view().findings->found.size(), 1u);
  for (int i = 0; i < 20; ++i) search.start({1e-3, true}, {});  // each stops the previous one
  search.stop();
}

TEST(ClashList, SaysWhatItFoundAndListsTouchesWhenAsked) {
  const assets::Scene scene = cubesAt({0.0, 0.009, 0.019, 0.0295});
  const haptics::ContactScene contact(scene, 1);
  const ClashFindings findings = searchClashes(contact, {1e-3, true}, {});
  const std::vector<ClashRow> rows = clashRows(findings, scene, false);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].first + rows[0].second, "ab");
  EXPECT_NE(rows[0].measure.find(" mm deep"), std::string::npos) << rows[0].measure;
  EXPECT_NE(rows[0].note.find("overlap at rest"), std::string::npos) << rows[0].note;
  EXPECT_EQ(rows[1].first + rows[1].second, "cd");
  EXPECT_EQ(rows[1].measure, "0.500 mm apart");
  EXPECT_EQ(rows[1].note, "");
  const std::vector<ClashRow> all = clashRows(findings, scene, true);
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(all[1].measure, "touch");
}

TEST(ClashList, KeepsThePairThatWasChosen) {
  const assets::Scene scene = row();
  const haptics::ContactScene contact(scene, 1);
  const ClashFindings findings = searchClashes(contact, {1e-3, true}, {});
  ClashUi ui;
  EXPECT_EQ(chosenClash(&findings, ui), nullptr);
  ui.a = 1;
  ui.b = 2;
  EXPECT_EQ(chosenClash(nullptr, ui), nullptr);
  ASSERT_NE(chosenClash(&findings, ui), nullptr);
  EXPECT_EQ(chosenClash(&findings, ui)->clash.kind, ClashKind::clearance);
  ui.b = 3;
  EXPECT_EQ(chosenClash(&findings, ui), nullptr) << "nothing was found between these";
}

TEST(ClashList, TheOthersAreShownTheChosenClashWithItsPlacesWhereTheyAreKnown) {
  const assets::Scene scene = row();
  const haptics::ContactScene contact(scene, 1);
  std::vector<Pose> poses = posesOf(scene);
  const ClashFindings findings = searchClashes(contact, {1e-3, false}, poses);
  ClashUi ui;
  ui.a = 1;
  ui.b = 2;
  EXPECT_EQ(inspectionOf(&findings, ui, poses), sync::Inspection{}) << "the list is closed";
  ui.open = true;
  EXPECT_EQ(inspectionOf(nullptr, ui, poses).mark, sync::ClashMark::pair);
  const sync::Inspection looks = inspectionOf(&findings, ui, poses);
  EXPECT_EQ(looks.mark, sync::ClashMark::clearance);
  EXPECT_NEAR(looks.amount, 0.5e-3, 1e-12);
  const double apart = glm::length(transformPoint(poses[2], looks.onB) - transformPoint(poses[1], looks.onA));
  EXPECT_NEAR(apart, 0.5e-3, 1e-12);
  poses[2].position.x += 0.002;
  EXPECT_TRUE(inspectionOf(&findings, ui, poses).moved);
  const ViewModel model = [&] {
    ViewModel made;
    made.scene = &scene;
    made.worldFromPart = poses;
    return made;
  }();
  const View view = makeView(Camera{}, {800.0, 600.0}, {{0.0, 0.0, 0.0}, 1.0});
  GlyphBatch batch(view);
  std::vector<Label> labels;
  std::vector<PartLook> parts(scene.parts.size());
  addInspection(looks, model, true, parts, batch, labels);
  EXPECT_TRUE(labels.empty()) << "parts are drawn apart";
  EXPECT_GT(parts[1].tintAmount, 0.0f);
  addInspection(looks, model, false, parts, batch, labels);
  ASSERT_EQ(labels.size(), 1u);
  EXPECT_EQ(labels[0].text, "0.500 mm apart");
}

TEST(ClashList, WitnessPointsGoWithTheirParts) {
  const assets::Scene scene = row();
  const haptics::ContactScene contact(scene, 1);
  std::vector<Pose> poses = posesOf(scene);
  const ClashFindings findings = searchClashes(contact, {1e-3, false}, poses);
  const FoundClash& near = findings.found[1];
  EXPECT_FALSE(witnessOf(findings, near, poses).moved);
  for (Pose& pose : poses) pose = Pose{{0.1, 0.2, 0.3}, fromRotationVector({0.3, 0.2, 0.1})} * pose;
  const ClashWitness together = witnessOf(findings, near, poses);
  EXPECT_FALSE(together.moved) << "the assembly went as one";
  EXPECT_NEAR(glm::length(together.onB - together.onA), 0.5e-3, 1e-12);
  poses[2].position += poses[2].orientation * glm::dvec3(0.002, 0.0, 0.0);
  const ClashWitness apart = witnessOf(findings, near, poses);
  EXPECT_TRUE(apart.moved);
  EXPECT_NEAR(glm::length(apart.onB - apart.onA), 2.5e-3, 1e-12);
}

TEST(ClashList, TheCameraSeesTheLineFromAsideAndLargeEnough) {
  const View probe = makeView(Camera{}, {800.0, 600.0}, {{0.0, 0.0, 0.0}, 1.0});
  for (const double yaw : {0.0, 0.7, 1.5, 3.0}) {
    for (const double pitch : {-1.2, 0.0, 0.5, 1.5}) {
      for (const glm::dvec3& line : {glm::dvec3(1e-3, 0.0, 0.0), {0.0, 1e-3, 0.0}, {0.0, 0.0, 1e-3}}) {
        Camera from;
        from.yaw = yaw;
        from.pitch = pitch;
        const Camera to = cameraFor(from, {glm::dvec3(0.1), glm::dvec3(0.1) + line, false}, 0.03, 4.0 / 3.0);
        const View view = makeView(to, probe.size, {glm::dvec3(0.1), 0.1});
        const auto a = view.project(glm::dvec3(0.1)), b = view.project(glm::dvec3(0.1) + line);
        ASSERT_TRUE(a && b);
        EXPECT_GT(glm::length(*b - *a), 12.0) << yaw << ' ' << pitch;
        EXPECT_LT(glm::length(0.5 * (*a + *b) - 0.5 * view.size), 2.0);
      }
    }
  }
}

TEST(ClashList, ATouchIsShownWithSomeOfTheSmallerPartAround) {
  const Camera to = cameraFor(Camera{}, {glm::dvec3(0.0), glm::dvec3(0.0), false}, 0.03, 1.5);
  const View view = makeView(to, {900.0, 600.0}, {glm::dvec3(0.0), 0.1});
  const double height = 600.0 * view.metresPerPixel(view.depthOf(glm::dvec3(0.0)));
  EXPECT_GT(height, 0.08 * 0.03);
  EXPECT_LT(height, 0.03);
}

TEST(CameraFlight, EndsWhereItWasSentAndTurnsTheShortWay) {
  Camera from, to;
  from.yaw = 3.0;
  to.yaw = -3.0;
  to.target = {1.0, 2.0, 3.0};
  to.distance = 0.1;
  CameraFlight flight;
  EXPECT_FALSE(flight.flying());
  flight.start(from, to);
  Camera last = from;
  int frames = 0;
  while (flight.flying() && frames < 1000) {
    last = flight.step(1.0 / 60.0);
    EXPECT_GT(std::abs(last.yaw), 2.9);
    ++frames;
  }
  EXPECT_GT(frames, 10);
  EXPECT_EQ(last.target, to.target);
  EXPECT_EQ(last.distance, to.distance);
  EXPECT_EQ(last.yaw, to.yaw);
}

}  // namespace
}  // namespace tandem::client
