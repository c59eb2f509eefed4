// Exact cylinders of a file: which are believed, and what becomes of their facets.

#include "assets/gltf/gltf_cad.h"

#include <cmath>
#include <limits>
#include <random>

#include <glm/geometric.hpp>

#include "assets/scene/stated_tolerances.h"
#include "tests/assets/gltf/findings.h"
#include "tests/assets/gltf/load_for_test.h"
#include "tests/support/exact_fit_file.h"

namespace tandem::assets {
namespace {

using test::ExactFit;
using test::exactFitFile;
using Json = tests::GltfBuilder::Json;

constexpr double kRadius = 0.010;
constexpr int kWanted = 312;  // segments for a play of 5 um: pi / sqrt(2 play / 10 radius), in eights

Scene loadedFit(const tests::GltfBuilder& file, double unitScale = 1.0) {
  LoadOptions options;
  options.movable = {"pin"};
  options.unitScale = unitScale;
  return loaded(file, options);
}

/// The furthest that the middle of an edge of the facets lies under a cylinder about z, m.
double sagOf(const Mesh& mesh, double radius) {
  double least = radius;
  for (const auto& c : mesh.triangles) {
    const glm::dvec3& p = mesh.positions[c[0]];
    if (std::abs(glm::normalize(glm::cross(mesh.positions[c[1]] - p, mesh.positions[c[2]] - p)).z) > 0.1)
      continue;
    for (int k = 0; k < 3; ++k) {
      const glm::dvec3 &a = mesh.positions[c[k]], &b = mesh.positions[c[(k + 1) % 3]];
      const double off = 1e-8;
      if (std::abs(std::hypot(a.x, a.y) - radius) > off || std::abs(std::hypot(b.x, b.y) - radius) > off)
        continue;
      if (glm::length(glm::dvec2(a - b)) > 0.2 * radius) continue;
      least = std::min(least, 0.5 * std::hypot(a.x + b.x, a.y + b.y));
    }
  }
  return radius - least;
}

void expectFacets(const Scene& scene, std::uint64_t warned) {
  const Scene plain = loadedFit(exactFitFile({.exact = false}));
  ASSERT_EQ(scene.meshes.size(), plain.meshes.size());
  for (std::size_t i = 0; i < plain.meshes.size(); ++i) {
    EXPECT_EQ(scene.meshes[i].positions, plain.meshes[i].positions) << i;
    EXPECT_EQ(scene.meshes[i].triangles, plain.meshes[i].triangles) << i;
  }
  EXPECT_EQ(findingOf(scene, "exact-fits"), nullptr);
  const Finding* const warning = findingOf(scene, "unbelieved-cylinders");
  ASSERT_EQ(warning != nullptr, warned > 0);
  if (warning != nullptr) {
    EXPECT_EQ(warning->severity, Finding::Severity::warning);
  }
}

TEST(ExactCylinders, OfAFitAreCutUntilTheFacetsFollowThem) {
  const Scene scene = loadedFit(exactFitFile());
  ASSERT_EQ(scene.meshes.size(), 2u);
  const Scene plain = loadedFit(exactFitFile({.exact = false}));
  for (std::size_t i = 0; i < 2; ++i) {
    const Mesh &mesh = scene.meshes[i], &facets = plain.meshes[i];
    const double radius = kRadius + (i == 1 ? 5e-6 : 0.0);
    EXPECT_TRUE(mesh.closed);
    EXPECT_EQ(mesh.shellCount, 1u);
    EXPECT_NEAR(sagOf(facets, radius), test::chordSag(radius, 48), 1e-8);
    EXPECT_LT(sagOf(mesh, radius), 0.5e-6) << "a tenth of the play";
    EXPECT_GT(mesh.triangles.size(), facets.triangles.size());
    EXPECT_LT(mesh.triangles.size(), facets.triangles.size() + 8u * kWanted);
  }
  // The exact volume of the block is that of the plate less that of the bore.
  const double bore = M_PI * std::pow(kRadius + 5e-6, 2) * 0.004;
  EXPECT_NEAR(scene.meshes[1].volume, 0.03 * 0.03 * 0.004 - bore, 2e-4 * bore);
  const Finding* const felt = findingOf(scene, "exact-fits");
  ASSERT_NE(felt, nullptr);
  EXPECT_EQ(felt->count, 1u);
}

TEST(ExactCylinders, InMillimetresAreTheSame) {
  const Scene scene = loadedFit(exactFitFile({.scale = 1e-3}), 1e-3);
  EXPECT_LT(sagOf(scene.meshes[1], kRadius + 5e-6), 0.5e-6);
  EXPECT_NE(findingOf(scene, "exact-fits"), nullptr);
}

TEST(ExactCylinders, WithoutAFitAreLeftAlone) {
  expectFacets(loadedFit(exactFitFile({.exact = false})), 0);
  tests::GltfBuilder alone = exactFitFile();
  alone.json["meshes"][1].erase("extras");
  expectFacets(loadedFit(alone), 0);
  tests::GltfBuilder wide = exactFitFile();
  wide.json["meshes"][0]["extras"]["cad"]["faces"][0]["radius"] = 0.008;
  expectFacets(loadedFit(wide), 0);
  tests::GltfBuilder bores = exactFitFile();
  bores.json["meshes"][0]["extras"]["cad"]["faces"][0]["hollow"] = true;
  expectFacets(loadedFit(bores), 0);
  // Nothing moves: nothing fits into anything.
  EXPECT_EQ(findingOf(loaded(exactFitFile()), "exact-fits"), nullptr);
  LoadOptions flat;
  flat.movable = {"pin"};
  flat.normals = false;
  EXPECT_EQ(findingOf(loaded(exactFitFile(), flat), "exact-fits"), nullptr);
}

TEST(ExactCylinders, ThatLieOrAreDamagedLeaveTheFacets) {
  const std::vector<std::pair<const char*, Json>> lies = {{"radius", kRadius + 3e-6},
                                                          {"radius", -1.0},
                                                          {"radius", "wide"},
                                                          {"radius", 1e300},
                                                          {"radius", nullptr},
                                                          {"axis", {0, 0, 0}},
                                                          {"axis", {0, 1, 0}},
                                                          {"axis", {0.1, 0, 0.995}},
                                                          {"point", {1e-5, 0, 0}},
                                                          {"point", {0, 0}},
                                                          {"hollow", 7},
                                                          {"from", 1.0},
                                                          {"to", "up"},
                                                          {"point", {1e300, 0, 0}}};
  for (const auto& [key, value] : lies) {
    tests::GltfBuilder file = exactFitFile();
    Json& meshes = file.json["meshes"];
    meshes[0]["extras"]["cad"]["faces"][0][key] = value;
    // The same lie about the block would be another one.
    meshes[1]["extras"]["cad"]["faces"][0]["axis"] = {1, 0, 0};
    SCOPED_TRACE(key + value.dump());
    expectFacets(loadedFit(file), 1);
  }
  for (const Json& faces : {Json("none"), Json(3), Json::array({1, "a", nullptr, Json::array()})}) {
    tests::GltfBuilder file = exactFitFile();
    for (Json& mesh : file.json["meshes"]) mesh["extras"]["cad"]["faces"] = faces;
    expectFacets(loadedFit(file), 1);
  }
}

TEST(ExactCylinders, ThatWouldTakeTooManyCornersLeaveTheFacets) {
  const Scene plain = loadedFit(exactFitFile({.exact = false}));
  RoundFaces rounds;
  rounds.faces.push_back({{0, 0, 0}, {0, 0, 1}, kRadius, -0.005, 0.002, false});
  rounds.cuts.push_back({kWanted, 0.0});
  rounds.most = 100;
  const RoundedMesh kept = roundFaces(plain.meshes[0], rounds, 0.0);
  EXPECT_TRUE(kept.soup.triangles.empty());
  EXPECT_EQ(kept.felt, 0u);
  rounds.most = 10'000;
  EXPECT_EQ(roundFaces(plain.meshes[0], rounds, 0.0).felt, 1u);
}

TEST(ExactCylinders, OfAPrismOfFewSidesAreNotBelieved) {
  const Scene scene = loadedFit(exactFitFile({.segments = 8}));
  EXPECT_EQ(findingOf(scene, "exact-fits"), nullptr);
  EXPECT_NE(findingOf(scene, "unbelieved-cylinders"), nullptr);
}

TEST(ExactCylinders, OfRandomNumbersMakeNoMeshUnsound) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int run = 0; run < 60; ++run) {
    tests::GltfBuilder file = exactFitFile();
    for (Json& mesh : file.json["meshes"]) {
      Json face = mesh["extras"]["cad"]["faces"][0];
      const double off = std::pow(10.0, -2.0 - 3.0 * (1.0 + unit(random)));
      for (const char* key : {"radius", "from", "to"})
        face[key] = face[key].get<double>() * (1.0 + off * unit(random));
      for (int k = 0; k < 3; ++k) face["point"][k] = 0.01 * off * unit(random);
      mesh["extras"]["cad"]["faces"].push_back(face);
    }
    const Scene scene = loadedFit(file);
    for (const Mesh& mesh : scene.meshes) EXPECT_TRUE(mesh.closed) << run;
  }
}

Json stating(Json tolerances) { return Json{{"cad", {{"tolerances", std::move(tolerances)}}}}; }

TEST(StatedTolerances, BelongToTheirPartOrGroup) {
  tests::GltfBuilder b;
  const int box = b.addBox(1, 2, 3);
  // Two bodies of one product, each of which has what is stated of the product.
  const Json product = stating({"flatness 0.05 mm"});
  const int first = b.addOrphan({{"name", "rib"}, {"mesh", box}, {"extras", product}});
  const int second = b.addOrphan({{"name", "web"}, {"mesh", box}, {"extras", product}});
  const int frame = b.addOrphan({{"name", "frame"}, {"children", {first, second}}, {"extras", product}});
  const int pin = b.addOrphan({{"name", "pin"},
                               {"mesh", box},
                               {"extras", stating({"diameter 12 mm +0.018 -0", "cylindricity 0.01 mm",
                                                   "diameter 12 mm +0.018 -0"})}});
  const int press =
      b.addOrphan({{"name", "press"}, {"children", {frame, pin}}, {"extras", stating({"length 80 mm"})}});
  b.addNode({{"name", "press"}, {"children", {press}}});
  const Scene scene = loaded(b);
  ASSERT_EQ(scene.parts.size(), 3u);
  const auto of = [&](const char* name) { return statedTolerances(scene, findPart(scene, name)); };
  using Words = std::vector<std::string>;
  EXPECT_EQ(of("rib"), (Words{"flatness 0.05 mm", "press: length 80 mm"}));
  EXPECT_EQ(of("web"), (Words{"flatness 0.05 mm", "press: length 80 mm"}));
  EXPECT_EQ(of("pin"), (Words{"diameter 12 mm +0.018 -0", "cylindricity 0.01 mm", "press: length 80 mm"}));
}

TEST(ImportFindings, AreWarningsOfTheSceneAndWhatIsNoneIsPassedOver) {
  tests::GltfBuilder b;
  b.addNode({{"name", "box"}, {"mesh", b.addBox(1, 2, 3)}});
  const auto finding = [](Json code, Json count, Json message) {
    return Json{{"code", std::move(code)}, {"count", std::move(count)}, {"message", std::move(message)}};
  };
  b.json["asset"]["extras"]["cad"]["findings"] = {finding("construction-shells", 3, "Shells are left out."),
                                                  finding(7, 1, "x"),
                                                  finding("a", -1, "x"),
                                                  finding("a", 1, nullptr),
                                                  5,
                                                  finding("loud", 1, "\x1b[2J" + std::string(5000, 'x'))};
  const Scene scene = loaded(b);
  const Finding* shells = findingOf(scene, "import-construction-shells");
  ASSERT_NE(shells, nullptr);
  EXPECT_EQ(shells->count, 3u);
  EXPECT_EQ(shells->severity, Finding::Severity::warning);
  EXPECT_EQ(shells->message, "Shells are left out.");
  const Finding* loud = findingOf(scene, "import-loud");
  ASSERT_NE(loud, nullptr);
  EXPECT_EQ(loud->message.size(), 500u);
  EXPECT_EQ(loud->message.substr(0, 5), "?[2Jx");
  EXPECT_EQ(findingOf(scene, "import-a"), nullptr);
}

TEST(StatedTolerances, OfAHostileFileAreFewPrintableAndShort) {
  tests::GltfBuilder b;
  const int box = b.addBox(1, 2, 3);
  for (const Json& none : {Json(7), Json("flat"), Json{{"a", 1}}, Json{1, nullptr, ""}})
    b.addNode({{"name", "none"}, {"mesh", box}, {"extras", stating(none)}});
  b.addNode({{"name", "loud"}, {"mesh", box}, {"extras", stating({"\x1b[2J", std::string(5000, 'x')})}});
  Json many = Json::array();
  for (int i = 0; i < 500; ++i) many.push_back("length " + std::to_string(i) + " mm");
  for (int i = 0; i < 15; ++i) b.addNode({{"name", "many"}, {"mesh", box}, {"extras", stating(many)}});
  const Scene scene = loaded(b);
  EXPECT_TRUE(statedTolerances(scene, findPart(scene, "none")).empty());
  const std::vector<std::string> loud = statedTolerances(scene, findPart(scene, "loud"));
  ASSERT_EQ(loud.size(), 2u);
  EXPECT_EQ(loud[0], "?[2J");
  EXPECT_EQ(loud[1].size(), 200u);
  EXPECT_EQ(statedTolerances(scene, findPart(scene, "many")).size(), 200u);
  const Finding* leftOut = findingOf(scene, "tolerances-left-out");
  ASSERT_NE(leftOut, nullptr);
  EXPECT_EQ(leftOut->count, 15u * 200u + 2u - 2000u);
}

}  // namespace
}  // namespace tandem::assets
