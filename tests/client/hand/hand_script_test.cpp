#include "client/hand/hand_script.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>

#include "client/hand/scripted_device.h"

namespace tandem::client {
namespace {

/// A scene with one part: a square of side 0.1 m in the plane z = 0, facing +z.
assets::Scene squareScene() {
  assets::Scene scene;
  assets::Mesh mesh;
  mesh.positions = {{-0.05, -0.05, 0}, {0.05, -0.05, 0}, {0.05, 0.05, 0}, {-0.05, 0.05, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.triangleMaterial = {0, 0};
  mesh.neighbours = {{assets::kNone, assets::kNone, 1}, {0, assets::kNone, assets::kNone}};
  mesh.edgeFlags = {{2, 2, 0}, {0, 2, 2}};
  mesh.triangleShell = {0, 0};
  mesh.shellCount = 1;
  mesh.bounds = {{-0.05, -0.05, 0}, {0.05, 0.05, 0}};
  scene.meshes.push_back(mesh);
  scene.materials.emplace_back();
  assets::Part part;
  part.name = "square";
  part.mesh = 0;
  part.movable = true;
  scene.parts.push_back(part);
  scene.bounds = mesh.bounds;
  return scene;
}

Pose at(double x, double y, double z) { return {{x, y, z}, {1, 0, 0, 0}}; }

ScriptedPerson person(const assets::Scene& scene, const std::string& json, const Pose& start) {
  Result<HandScript> script = parseHandScript(json, "test", scene);
  EXPECT_TRUE(script.ok()) << (script.ok() ? "" : script.error().message);
  return ScriptedPerson(scene, std::move(*script), start);
}

const auto kStill = [](PartId) { return Pose{}; };

TEST(HandScript, GoesToTheSurfaceOfAPartOfShapesToo) {
  assets::Scene scene;
  assets::Part part;
  part.name = "post";
  part.shapes.resize(2);
  part.shapes[0].kind = assets::ImplicitShape::Kind::box;
  part.shapes[0].size = {0.2, 0.2, 0.2};
  part.shapes[1].kind = assets::ImplicitShape::Kind::sphere;
  part.shapes[1].radiusTop = part.shapes[1].radiusBottom = 0.05;
  part.shapes[1].partFromShape.position = {0.3, 0.0, 0.0};
  scene.parts.push_back(part);
  const Pose lifted{{0.0, 0.0, 1.0}, {1.0, 0.0, 0.0, 0.0}};
  const SurfacePoint onBox = nearestSurfacePoint(scene, 0, lifted, {0.02, 0.03, 1.5});
  EXPECT_NEAR(glm::length(onBox.point - glm::dvec3(0.02, 0.03, 1.1)), 0.0, 1e-12);
  EXPECT_NEAR(onBox.normal.z, 1.0, 1e-12);
  const SurfacePoint onBall = nearestSurfacePoint(scene, 0, lifted, {0.5, 0.0, 1.0});
  EXPECT_NEAR(glm::length(onBall.point - glm::dvec3(0.35, 0.0, 1.0)), 0.0, 1e-12);
}

TEST(HandScript, SaysHowPartsAreDrawn) {
  const assets::Scene scene = squareScene();
  const auto stepOf = [&](const std::string& step) {
    return parseHandScript("[" + step + "]", "test", scene);
  };
  const Result<HandScript> apart = stepOf(R"({"t":0,"do":"explode","factor":0.5,"parts":["square"]})");
  ASSERT_TRUE(apart.ok()) << apart.error().message;
  EXPECT_EQ(apart->steps[0].style.explode, 0.5);
  EXPECT_EQ(apart->steps[0].style.apart, std::vector<PartId>{0});
  EXPECT_TRUE(apart->steps[0].shows());
  const Result<HandScript> coloured = stepOf(R"({"t":0,"do":"colour","what":"material"})");
  ASSERT_TRUE(coloured.ok()) << coloured.error().message;
  EXPECT_EQ(coloured->steps[0].style.colouring, document::PartColouring::byMaterial);
  EXPECT_TRUE(stepOf(R"({"t":0,"do":"ghosts","on":true})").ok());
  for (const char* wrong : {R"({"t":0,"do":"explode"})", R"({"t":0,"do":"explode","factor":1.5})",
                            R"({"t":0,"do":"explode","factor":-0.5})", R"({"t":0,"do":"ghosts"})",
                            R"({"t":0,"do":"colour","what":"size"})"})
    EXPECT_FALSE(stepOf(wrong).ok()) << wrong;
}

TEST(HandScript, SaysWhatIsLookedAtClosely) {
  const assets::Scene scene = squareScene();
  const auto stepOf = [&](const std::string& step) {
    return parseHandScript("[" + step + "]", "test", scene);
  };
  const Result<HandScript> places = stepOf(R"({"t":0,"do":"inspect","at":[[0,0,0],[0.1,0,0]]})");
  ASSERT_TRUE(places.ok()) << places.error().message;
  EXPECT_EQ(places->steps[0].places.size(), 2u);
  EXPECT_TRUE(places->steps[0].shows());
  EXPECT_TRUE(stepOf(R"({"t":0,"do":"inspect"})").ok());
  for (const char* wrong :
       {R"({"t":0,"do":"inspect","parts":["square"]})",
        R"({"t":0,"do":"inspect","parts":["square","square"]})",
        R"({"t":0,"do":"inspect","at":[[0,0,0],[1,0,0],[2,0,0]]})", R"({"t":0,"do":"inspect","at":0})"})
    EXPECT_FALSE(stepOf(wrong).ok()) << wrong;
}

TEST(HandScript, MovesAlongAMinimumJerkPath) {
  const assets::Scene scene = squareScene();
  ScriptedPerson p =
      person(scene, R"([{"t":0,"do":"move_relative","by":[0.1,0,0],"over_s":1}])", at(0, 0, 1));
  const auto half = p.at(0.5, at(0, 0, 1), kStill);
  EXPECT_NEAR(half.target.worldFromTarget.position.x, 0.05, 1e-12);
  EXPECT_NEAR(half.target.velocity.x, 0.1 * 1.875, 1e-12);  // the peak of a minimum-jerk motion
  EXPECT_NEAR(half.target.acceleration.x, 0.0, 1e-12);
  EXPECT_NEAR(p.at(1.5, at(0, 0, 1), kStill).target.worldFromTarget.position.x, 0.1, 1e-12);
  EXPECT_TRUE(p.finished(1.5));
}

TEST(HandScript, VelocityIsTheDerivativeOfPosition) {
  const assets::Scene scene = squareScene();
  ScriptedPerson p = person(scene, R"([{"t":0,"do":"move_relative","by":[0.1,0.2,0],"over_s":1},
                 {"t":1.2,"do":"sine","axis":"y","amplitude":0.02,"hz":2,"for_s":1}])",
                            at(0, 0, 1));
  const double h = 1e-6;
  for (double t = 0.05; t < 2.1; t += 0.13) {
    const auto before = p.at(t - h, at(0, 0, 1), kStill).target;
    const auto now = p.at(t, at(0, 0, 1), kStill).target;
    const auto after = p.at(t + h, at(0, 0, 1), kStill).target;
    const glm::dvec3 slope = (after.worldFromTarget.position - before.worldFromTarget.position) / (2 * h);
    EXPECT_NEAR(glm::length(slope - now.velocity), 0.0, 1e-6) << t;
    const glm::dvec3 second = (after.velocity - before.velocity) / (2 * h);
    EXPECT_NEAR(glm::length(second - now.acceleration), 0.0, 1e-4) << t;
  }
}

TEST(HandScript, PressesTheNearestPointFromTheHandsSide) {
  const assets::Scene scene = squareScene();
  ScriptedPerson p = person(scene, R"([{"t":0,"do":"press","part":"square","depth":0.003,"over_s":0.5}])",
                            at(0.01, 0.02, 0.1));
  const auto goal = p.at(1.0, at(0.01, 0.02, 0.1), kStill).target.worldFromTarget.position;
  EXPECT_NEAR(glm::length(goal - glm::dvec3(0.01, 0.02, -0.003)), 0.0, 1e-12);
}

TEST(HandScript, GraspsOnlyWhenTheHandHasArrived) {
  const assets::Scene scene = squareScene();
  ScriptedPerson p = person(
      scene, R"([{"t":0,"do":"grasp","part":"square","over_s":0.5},{"t":1,"do":"release"}])", at(0, 0, 0.1));
  EXPECT_FALSE(p.at(0.4, at(0, 0, 0.1), kStill).graspButton);
  EXPECT_TRUE(p.at(0.6, at(0, 0, 0), kStill).graspButton);
  EXPECT_EQ(p.at(0.7, at(0, 0, 0), kStill).wish, 0);
  EXPECT_FALSE(p.at(1.1, at(0, 0, 0), kStill).graspButton);
}

TEST(HandScript, LettingGoOfTheStylusKeepsTheLatch) {
  const assets::Scene scene = squareScene();
  ScriptedPerson p = person(
      scene, R"([{"t":0,"do":"grasp","part":"square","over_s":0},{"t":1,"do":"let_go"}])", at(0, 0, 0.1));
  const auto intent = p.at(1.1, at(0, 0, 0), kStill);
  EXPECT_FALSE(intent.target.holdsStylus);
  EXPECT_TRUE(intent.graspButton);
}

TEST(HandScript, SetsAControlByItsNameOrItsPartsOncePerStep) {
  assets::Scene scene = squareScene();
  assets::Control control;
  control.name = "level";
  control.part = 0;
  scene.controls.push_back(control);
  ScriptedPerson p = person(scene, R"([{"t":1,"do":"set","control":"level","value":0.02},
                 {"t":2,"do":"set","control":"square","value":0.03}])",
                            at(0, 0, 0.1));
  EXPECT_EQ(p.at(0.5, at(0, 0, 0.1), kStill).control.count, 0u);
  const ControlWish first = p.at(1.1, at(0, 0, 0.1), kStill).control;
  EXPECT_EQ(first.part, 0);
  EXPECT_EQ(first.value, 0.02);
  EXPECT_EQ(first.count, 1u);
  EXPECT_EQ(p.at(1.9, at(0, 0, 0.1), kStill).control.count, 1u);
  EXPECT_EQ(p.at(2.1, at(0, 0, 0.1), kStill).control.value, 0.03);
  EXPECT_EQ(p.at(2.2, at(0, 0, 0.1), kStill).control.count, 2u);
}

TEST(HandScript, IsCheckedBeforeItsSceneIsThereButForNames) {
  const std::string path =
      (std::filesystem::temp_directory_path() / ("tandem-script-" + std::to_string(::getpid()))).string();
  const auto check = [&](const std::string& json) {
    std::ofstream(path) << json;
    const Status status = checkHandScript(path);
    return status.ok() ? std::string() : status.error().message;
  };
  EXPECT_EQ(check(R"([{"t":0,"do":"grasp","part":"?"},{"t":1,"do":"set","control":"?","value":0}])"), "");
  const auto refuses = [&](const std::string& json, const std::string& word) {
    const std::string message = check(json);
    EXPECT_NE(message.find(word), std::string::npos) << json << ": " << message;
  };
  refuses(R"([{"t":0,"do":"hold"},{"t":0,"do":"jump"}])", "step 2");
  refuses(R"([{"t":0,"do":"grasp"}])", "\"part\"");
  refuses(R"([{"t":0,"do":"press","part":"?"}])", "\"depth\"");
  refuses(R"([{"t":0,"do":"move","to":[0,0],"over_s":1}])", "\"to\"");
  refuses(R"({"script":3})", "list");
  std::filesystem::remove(path);
}

TEST(HandScript, RefusesWhatItDoesNotKnowAndNamesTheStep) {
  const assets::Scene scene = squareScene();
  const std::pair<std::string, const char*> cases[] = {
      {R"([{"t":0,"do":"jump"}])", "jump"},
      {R"([{"t":0,"do":"hold"},{"t":1,"do":"grasp","part":"none"}])", "step 2"},
      {R"([{"do":"hold"}])", "\"t\""},
      {R"([{"t":0,"do":"move","to":[0,0],"over_s":1}])", "to"},
      {R"([{"t":0,"do":"turn","axis":[0,0,0],"angle":1,"over_s":1}])", "axis"},
      {R"([{"t":0,"do":"move","to":[0,0,0],"over_s":-1}])", "over_s"},
      {"not json", "JSON"},
      {std::string(100000, '[') + std::string(100000, ']'), "deeper"},
      {R"([{"t":0,"do":"move","to":[1e300,0,0],"over_s":1}])", "within"},
      {R"([{"t":-1,"do":"hold"}])", "negative"},
      {R"([{"t":1e308,"do":"hold"}])", "\"t\""},
      {R"([{"t":0,"do":"sine","axis":"x","amplitude":1e300,"hz":1,"for_s":1}])", "amplitude"},
      {R"([{"t":0,"do":"hold","ower_s":1}])", "ower_s"},
      {R"([{"t":0,"do":"set","control":"none","value":1}])", "no control"},
      {R"([{"t":0,"do":"set","value":1}])", "control"},
      {R"({"a":1})", "list"},
  };
  for (const auto& [json, word] : cases) {
    const Result<HandScript> script = parseHandScript(json, "file.json", scene);
    ASSERT_FALSE(script.ok()) << json;
    EXPECT_NE(script.error().message.find(word), std::string::npos) << script.error().message;
    EXPECT_NE(script.error().message.find("file.json"), std::string::npos);
  }
}

TEST(ScriptedDevice, TheHandFollowsTheScript) {
  const assets::Scene scene = squareScene();
  Result<HandScript> script =
      parseHandScript(R"([{"t":0.1,"do":"move_relative","by":[0.1,0,0],"over_s":0.8}])", "test", scene);
  ASSERT_TRUE(script.ok());
  ScriptedDevice device(scene, std::move(*script), {}, {}, at(0, 0, 1), kStill);
  haptics::DeviceSample sample;
  for (int i = 0; i <= 3000; ++i)
    sample = device.poll(10.0 + i * 1e-3);  // a clock that does not begin at zero
  EXPECT_TRUE(sample.valid);
  EXPECT_NEAR(sample.worldFromDevice.position.x, 0.1,
              1.5e-3);  // Coulomb friction of the device holds it a little short
  EXPECT_TRUE(device.finished());
}

}  // namespace
}  // namespace tandem::client
