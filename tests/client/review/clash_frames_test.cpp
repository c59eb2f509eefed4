// Clashes do not depend on how a part is split into vertices and a pose: assemblies of closed, torn and open
// shells under random nodes, and the same with the nodes baked into the vertices.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <random>
#include <string>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/mat4x4.hpp>

#include "assets/gltf/load_gltf.h"
#include "client/review/clash_check.h"
#include "haptics/geometry/triangle_math.h"
#include "haptics/overlap/mesh_intrusion.h"
#include "haptics/scene/contact_scene.h"
#include "haptics/scene/contact_scene_data.h"
#include "tests/support/gltf_builder.h"
#include "tests/support/part_meshes.h"
#include "tests/support/shapes.h"

namespace tandem::test {
namespace {

using assets::TriangleSoup;
using client::Clash;
using client::ClashKind;

/// One part: what its file's mesh holds, and its node.
struct Piece {
  TriangleSoup soup;
  glm::dmat4 worldFromMesh{1.0};
};

TriangleSoup blobSoup(double radius, std::mt19937& random) {
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  TriangleSoup soup = sphereSoup(radius, 7);
  for (glm::dvec3& p : soup.positions) p *= 1.0 + 0.2 * u(random);
  return soup;
}

/// Without the faces for which `gone` says so.
TriangleSoup without(const TriangleSoup& soup, const std::function<bool(std::size_t)>& gone) {
  TriangleSoup left = soup;
  left.triangles.clear();
  for (std::size_t t = 0; t < soup.triangles.size(); ++t)
    if (!gone(t)) left.triangles.push_back(soup.triangles[t]);
  left.triangleMaterial.resize(left.triangles.size());
  return left;
}

/// Blobs, boxes, and among both torn ones (7 % of the faces gone), turned faces, boxes without a side,
/// sheets.
TriangleSoup randomShell(std::size_t kind, std::mt19937& random) {
  std::uniform_real_distribution<double> u(0.0, 1.0);
  const glm::dvec3 size(0.5 + u(random), 0.5 + u(random), 0.5 + u(random));
  const int n = 1 + static_cast<int>(4.0 * u(random));
  TriangleSoup soup = kind % 2 == 0 ? blobSoup(0.3 + 0.5 * u(random), random) : boxSoup(size, n);
  if (kind % 7 == 2 || kind % 7 == 5) soup = without(soup, [&](std::size_t) { return u(random) < 0.07; });
  if (kind % 7 == 3) {
    const auto side = static_cast<std::size_t>(6.0 * u(random));
    const std::size_t share = soup.triangles.size() / 6;
    soup = without(soup, [&](std::size_t t) { return t / share == side; });
  }
  if (kind % 7 == 4) soup = shattered(soup, 9, 0);
  if (kind % 14 == 13) soup = boxSoup({1.5, 1.5, 0.0}, 1);
  return soup;
}

/// Random place, rotation and scale; of every third part mirrored, of every second not uniform.
glm::dmat4 randomNode(std::size_t index, std::mt19937& random) {
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  glm::dvec3 scale(1.0 + 0.3 * u(random));
  if (index % 2 == 0) scale *= glm::dvec3(1.0 + 0.4 * u(random), 1.0 + 0.4 * u(random), 1.0);
  if (index % 3 == 0) scale.x = -scale.x;
  const glm::dquat turn = fromRotationVector(glm::dvec3(u(random), u(random), u(random)) * kPi);
  return glm::translate(glm::dmat4(1.0), glm::dvec3(u(random), u(random), u(random)) * 1.1) *
         glm::mat4_cast(turn) * glm::scale(glm::dmat4(1.0), scale);
}

std::vector<Piece> randomAssembly(unsigned seed, double size) {
  std::mt19937 random(seed);
  std::vector<Piece> pieces;
  for (std::size_t i = 0; i < 14; ++i) {
    Piece piece{randomShell(i, random), randomNode(i, random)};
    for (glm::dvec3& p : piece.soup.positions) p *= size;
    piece.worldFromMesh[3] = glm::dvec4(glm::dvec3(piece.worldFromMesh[3]) * size, 1.0);
    pieces.push_back(piece);
  }
  return pieces;
}

std::vector<float> floatsOf(const TriangleSoup& soup, const glm::dmat4& place) {
  std::vector<float> floats;
  for (const glm::dvec3& p : soup.positions) {
    const glm::dvec3 rounded(
        glm::vec3(glm::dvec3(static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z))));
    const glm::dvec3 at(place * glm::dvec4(rounded, 1.0));
    for (int i = 0; i < 3; ++i) floats.push_back(static_cast<float>(at[i]));
  }
  return floats;
}

/// The assembly as a file has it, with nodes or with these baked into the vertices.
assets::Scene loaded(const std::vector<Piece>& pieces, bool baked) {
  tests::GltfBuilder builder;
  for (const Piece& piece : pieces) {
    const bool mirrored = glm::determinant(glm::dmat3(piece.worldFromMesh)) < 0.0;
    std::vector<std::uint32_t> indices;
    for (const auto& t : piece.soup.triangles)
      for (const std::size_t i : {0, baked && mirrored ? 2 : 1, baked && mirrored ? 1 : 2})
        indices.push_back(t[i]);
    const int mesh = builder.addMesh(
        builder.addPositions(floatsOf(piece.soup, baked ? piece.worldFromMesh : glm::dmat4(1.0))),
        builder.addIndices(indices));
    tests::GltfBuilder::Json node = {{"mesh", mesh}, {"name", "part " + std::to_string(mesh)}};
    if (!baked) {
      std::vector<double> matrix;
      for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r) matrix.push_back(piece.worldFromMesh[c][r]);
      node["matrix"] = matrix;
    }
    builder.addNode(node);
  }
  Result<assets::Scene> scene = assets::loadGltfFromMemory("assembly", builder.glb(), {});
  EXPECT_TRUE(scene) << (scene ? "" : scene.error().message);
  return scene ? std::move(*scene) : assets::Scene{};
}

/// The same scene with every part's pose baked into floats, as another program would write it.
assets::Scene bakedScene(const assets::Scene& scene) {
  assets::Scene baked = scene;
  baked.meshes.clear();
  for (assets::Part& part : baked.parts) {
    if (part.mesh == assets::kNone) continue;
    const assets::Mesh& mesh = scene.meshes[part.mesh];
    TriangleSoup soup;
    for (const glm::dvec3& p : mesh.positions) {
      const glm::dvec3 at = transformPoint(part.worldFromPart, p);
      soup.positions.emplace_back(static_cast<float>(at.x), static_cast<float>(at.y),
                                  static_cast<float>(at.z));
    }
    soup.triangles = mesh.triangles;
    soup.triangleMaterial = mesh.triangleMaterial;
    part.mesh = static_cast<std::uint32_t>(baked.meshes.size());
    part.worldFromPart = {};
    baked.meshes.push_back(assets::analyseMesh(soup, 0.5).mesh);
  }
  return baked;
}

using Verdicts = std::map<std::pair<std::string, std::string>, Clash>;

Verdicts verdictsOf(const assets::Scene& scene, const haptics::ContactScene& contact) {
  Verdicts verdicts;
  client::ClashOptions options;
  options.threads = 1;
  for (const Clash& clash : client::findClashes(contact, options).clashes)
    verdicts[{scene.parts[clash.a].name, scene.parts[clash.b].name}] = clash;
  return verdicts;
}

/// Known depth, or 0 for a touch and for what is apart; negative: not known.
double depthIn(const Verdicts& verdicts, const std::pair<std::string, std::string>& pair) {
  const auto at = verdicts.find(pair);
  return at == verdicts.end() ? 0.0 : at->second.open ? -1.0 : at->second.depth;
}

/// The largest difference of a depth between two scenes, over the larger part's diagonal, and in metres;
/// infinite if only one knows it.
double worstDifference(const assets::Scene& scene, const Verdicts& posed, const Verdicts& baked,
                       std::string& where, double& metres) {
  double worst = 0.0;
  std::map<std::string, double> diagonal;
  for (const assets::Part& part : scene.parts) {
    if (part.mesh == assets::kNone) continue;
    const assets::Bounds& box = scene.meshes[part.mesh].bounds;
    diagonal[part.name] = glm::length(box.max - box.min);
  }
  for (const Verdicts* side : {&posed, &baked}) {
    for (const auto& [pair, clash] : *side) {
      const double a = depthIn(posed, pair), b = depthIn(baked, pair);
      const double size = std::max(diagonal[pair.first], diagonal[pair.second]);
      const double off = (a < 0.0) != (b < 0.0) ? HUGE_VAL : std::abs(a - b) / size;
      metres = std::max(metres, off * size);
      if (off <= worst) continue;
      worst = off;
      where = pair.first + " and " + pair.second + ": " + std::to_string(a) + " or " + std::to_string(b);
    }
  }
  return worst;
}

/// Distance of a point to a part's triangles and its generalised winding number, by brute force.
struct Judged {
  double distance = HUGE_VAL, winding = 0.0;
};
Judged judge(const assets::Mesh& mesh, const glm::dvec3& p) {
  Judged judged;
  for (const auto& t : mesh.triangles) {
    const glm::dvec3 &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    const glm::dvec3 nearest = haptics::closestPointOnTriangle(p, {a, b, c}).point;
    judged.distance = std::min(judged.distance, glm::length(nearest - p));
    const glm::dvec3 u = a - p, v = b - p, w = c - p;
    const double lu = glm::length(u), lv = glm::length(v), lw = glm::length(w);
    judged.winding +=
        std::atan2(glm::dot(u, glm::cross(v, w)),
                   lu * lv * lw + glm::dot(u, v) * lw + glm::dot(v, w) * lu + glm::dot(w, u) * lv) /
        (2.0 * kPi);
  }
  return judged;
}

/// Whether a point lies in or on a part, by a judge that shares nothing with the search.
bool liesIn(const assets::Scene& scene, PartId part, const glm::dvec3& world) {
  const assets::Part& p = scene.parts[part];
  const assets::Mesh& mesh = scene.meshes[p.mesh];
  const Judged judged = judge(mesh, transformPoint(inverse(p.worldFromPart), world));
  return judged.distance <= 1e-6 * glm::length(mesh.bounds.max - mesh.bounds.min) ||
         std::abs(judged.winding) > 0.5;
}

struct Outcome {
  double worst = 0.0;        // of the larger part's diagonal
  double worstMetres = 0.0;  // m
  std::size_t hard = 0, open = 0, witnessesOutside = 0;
  std::string where;
};

Outcome compare(const assets::Scene& posed, const assets::Scene& baked) {
  const haptics::ContactScene inPoses(posed, 1), inVertices(baked, 1);
  const Verdicts first = verdictsOf(posed, inPoses), second = verdictsOf(baked, inVertices);
  Outcome outcome;
  outcome.worst = worstDifference(posed, first, second, outcome.where, outcome.worstMetres);
  for (const auto& [pair, clash] : first) {
    if (clash.kind != ClashKind::hard) continue;
    ++outcome.hard;
    outcome.open += clash.open ? 1 : 0;
    for (const PartId part : {clash.a, clash.b}) {
      if (liesIn(posed, part, clash.deepest)) continue;
      ++outcome.witnessesOutside;
      outcome.where += ", witness of " + pair.first + " and " + pair.second;
    }
  }
  return outcome;
}

unsigned seeds() {
  const char* full = std::getenv("TANDEM_FULL_SIZE");
  return full != nullptr && *full == '1' ? 60 : 4;
}

TEST(ClashFrames, PosedIsAsDeepAsBakedAndWitnessesLieInBothParts) {
  std::size_t hard = 0, open = 0;
  double worst = 0.0;
  for (const double size : {1e-3, 1.0, 50.0}) {
    for (unsigned seed = 1; seed <= seeds(); ++seed) {
      const std::vector<Piece> pieces = randomAssembly(seed, size);
      const Outcome outcome = compare(loaded(pieces, false), loaded(pieces, true));
      EXPECT_LE(outcome.worst, 1e-6) << "seed " << seed << " size " << size << ' ' << outcome.where;
      EXPECT_EQ(outcome.witnessesOutside, 0u) << "seed " << seed << " size " << size << ' ' << outcome.where;
      hard += outcome.hard;
      open += outcome.open;
      worst = std::max(worst, outcome.worst);
    }
  }
  EXPECT_GT(hard, 20u * 3u);
  EXPECT_GT(open, 0u) << "some of these shells must leave a depth open";
  EXPECT_LT(2u * open, hard) << "most depths must be known";
  std::printf("%zu hard clashes, %zu of them open, worst difference %.2g of the size\n", hard, open, worst);
}

/// Parts in a file's usual relations, m.
struct Relation {
  const char* name;
  std::vector<std::pair<TriangleSoup, Pose>> parts;
};

/// A shaft and a bore of one radius, and two gears that mesh, whole or torn.
std::vector<Relation> fits(const std::function<TriangleSoup(TriangleSoup)>& worn) {
  Peg peg;
  peg.radius = 0.5, peg.length = 2.0, peg.chamfer = 0.0, peg.facets = {32, 2};
  BoredBlock block;
  block.boreRadius = 0.5, block.depth = block.height = 1.5, block.width = 2.0, block.facets = {32, 2};
  block.fit = Fit::within;
  SpurGear gear;
  gear.module = 0.1, gear.width = 0.5, gear.bore = 0.2, gear.flankPoints = 4;
  return {{"peg in bore",
           {{worn(boredBlockSoup(block)), {}},
            {worn(pegSoup(peg)), {{0.0, 0.0, -1.6}, fromRotationVector({0.0, 0.0, kPi / 32})}}}},
          {"gears",
           {{worn(spurGearSoup(gear)), {}},
            {worn(spurGearSoup(gear)), {{1.93, 0.0, 0.1}, fromRotationVector({0.0, 0.0, 0.1})}}}}};
}

std::vector<Relation> relations(std::mt19937& random) {
  const TriangleSoup box = boxSoup({1.0, 1.2, 0.8}, 3), coarse = boxSoup({1.0, 1.2, 0.8}, 1),
                     blob = blobSoup(0.6, random);
  const auto torn = [&](const TriangleSoup& soup) {
    std::uniform_real_distribution<double> u(0.0, 1.0);
    return without(soup, [&](std::size_t) { return u(random) < 0.05; });
  };
  std::vector<Relation> all = {
      {"there twice", {{blob, {}}, {blob, {}}}},
      {"there twice, cut otherwise", {{box, {}}, {coarse, {}}}},
      {"pushed along itself", {{box, {}}, {box, {{0.0, 0.0, 0.4}}}}},
      {"flush", {{box, {}}, {coarse, {{1.0, 0.1, 0.2}}}, {box, {{0.0, 1.2, 0.0}}}}},
      {"nearly flush", {{box, {}}, {coarse, {{0.9999, 0.1, 0.2}}}, {box, {{0.0, 1.1999, 0.0}}}}},
      {"one in the other", {{box, {}}, {blobSoup(0.1, random), {{-0.2, -0.2, 0.1}}}}},
      {"bars", {{boxSoup({4.0, 1.0, 1.0}, 2), {}}, {boxSoup({0.3, 0.4, 4.0}, 3), {}}}},
      {"two shells in one", {{joined(box, moved(box, {0.4, 0.3, 0.2})), {}}, {blob, {{0.8, 0.5, 0.3}}}}},
      {"sheets",
       {{boxSoup({1.5, 1.5, 0.0}, 1), {}},
        {boxSoup({1.5, 1.5, 0.0}, 2), {{0.1, 0.1, 0.1}, fromRotationVector({1.2, 0.2, 0.1})}},
        {coarse, {{0.7, 0.1, 0.2}}}}},
      {"torn", {{torn(joined(box, moved(box, {0.4, 0.3, 0.2}))), {}}, {torn(blob), {{0.8, 0.5, 0.3}}}}}};
  for (const Relation& fit : fits([](const TriangleSoup& soup) { return soup; })) all.push_back(fit);
  for (const Relation& fit : fits(torn)) all.push_back(fit);
  return all;
}

TEST(ClashFrames, PartsInUsualRelationsAreAsDeepPosedAsBaked) {
  for (const double size : {1e-3, 1.0, 50.0}) {
    for (unsigned seed = 1; seed <= (seeds() > 4 ? 10u : 1u); ++seed) {
      std::mt19937 random(seed);
      std::uniform_real_distribution<double> u(-1.0, 1.0);
      const Pose world{glm::dvec3(u(random), u(random), u(random)) * size,
                       fromRotationVector(glm::dvec3(u(random), u(random), u(random)) * kPi)};
      for (const Relation& relation : relations(random)) {
        SceneBuilder builder;
        for (auto [soup, pose] : relation.parts) {
          for (glm::dvec3& p : soup.positions) p *= size;
          pose.position *= size;
          builder.addPart(meshOf(soup), world * pose);
        }
        const Outcome outcome = compare(builder.scene, bakedScene(builder.scene));
        EXPECT_LE(outcome.worst, 1e-6) << relation.name << " size " << size << ' ' << outcome.where;
        EXPECT_EQ(outcome.witnessesOutside, 0u) << relation.name << " size " << size << ' ' << outcome.where;
        EXPECT_EQ(outcome.hard == 0, std::string(relation.name) == "flush") << relation.name;
      }
    }
  }
}

/// How a depth is found from the vertices of both parts alone, by some test of sides.
using SideTest = std::function<bool(const haptics::MeshClosing&, const glm::dvec3&)>;
double depthOfVertices(const client::PartClosings& closings, PartId a, PartId b, const SideTest& contains) {
  const haptics::ContactScene& contact = closings.contact();
  double depth = 0.0;
  for (const auto& [own, other] : {std::pair{a, b}, std::pair{b, a}}) {
    const haptics::TriangleBvh& solid = *contact.data().colliders[other].tree;
    const Pose solidFromMesh =
        inverse(contact.scene().parts[other].worldFromPart) * contact.scene().parts[own].worldFromPart;
    for (const glm::dvec3& p : contact.data().colliders[own].tree->mesh().positions) {
      const glm::dvec3 local = transformPoint(solidFromMesh, p);
      haptics::MeshPoint nearest;
      if (!contains(closings.of(other), local) || !solid.closestPoint(local, 1e300, nearest)) continue;
      depth = std::max(depth, nearest.distance);
    }
  }
  return depth;
}

/// The largest difference between posed and baked of depths that a test of sides decides, over 1 m.
double differenceBy(const SideTest& contains) {
  double worst = 0.0;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const std::vector<Piece> pieces = randomAssembly(seed, 1.0);
    const assets::Scene posed = loaded(pieces, false), baked = loaded(pieces, true);
    const haptics::ContactScene inPoses(posed, 1), inVertices(baked, 1);
    const client::PartClosings first(inPoses), second(inVertices);
    for (PartId a = 0; a < pieces.size(); ++a)
      for (PartId b = a + 1; b < pieces.size(); ++b)
        worst = std::max(worst, std::abs(depthOfVertices(first, a, b, contains) -
                                         depthOfVertices(second, a, b, contains)));
  }
  return worst;
}

TEST(ClashFrames, ControlSidesByRaysOfTheMeshsFrameDifferWithThePose) {
  const SideTest byRays = [](const haptics::MeshClosing& closing, const glm::dvec3& p) {
    return haptics::containsPoint(closing.tree(), p);
  };
  const SideTest withLids = [](const haptics::MeshClosing& closing, const glm::dvec3& p) {
    return closing.contains(p);
  };
  EXPECT_GT(differenceBy(byRays), 1e-3);
  EXPECT_LE(differenceBy(withLids), 1e-6);
}

TEST(ClashFrames, ControlTheJudgeFindsAWitnessThatIsOutside) {
  const assets::Scene scene = loaded(randomAssembly(1, 1.0), false);
  const haptics::ContactScene contact(scene, 1);
  const Verdicts verdicts = verdictsOf(scene, contact);
  std::size_t hard = 0, found = 0;
  for (const auto& [pair, clash] : verdicts) {
    if (clash.kind != ClashKind::hard || clash.open) continue;
    ++hard;
    // Beyond the nearest point of the surface that it is under, as far again as it is deep.
    const glm::dvec3 exit = clash.deepest == clash.onA ? clash.onB : clash.onA;
    const glm::dvec3 beyond = exit + 0.5 * (exit - clash.deepest);
    found += liesIn(scene, clash.a, beyond) && liesIn(scene, clash.b, beyond) ? 0 : 1;
  }
  ASSERT_GT(hard, 5u);
  EXPECT_GT(found * 10, hard * 9);
}

std::optional<assets::Scene> engine() {
  const char* data = std::getenv("TANDEM_DATA");
  const std::string file = data == nullptr ? "" : std::string(data) + "/2CylinderEngine.glb";
  if (!std::filesystem::exists(file)) return {};
  assets::LoadOptions options;
  options.unitScale = 0.001;
  Result<assets::Scene> scene = assets::loadScene(file, options, "");
  if (!scene) return {};
  return std::move(*scene);
}

TEST(ClashFrames, AnEngineIsAsDeepPosedAsBaked) {
  const std::optional<assets::Scene> scene = engine();
  if (!scene) GTEST_SKIP() << "TANDEM_DATA is not set";
  const Outcome outcome = compare(*scene, bakedScene(*scene));
  EXPECT_LE(outcome.worst, 1e-6) << outcome.where;
  EXPECT_EQ(outcome.witnessesOutside, 0u) << outcome.where;
  std::printf("%zu hard clashes, %zu of them open, worst difference %.2g of the size\n", outcome.hard,
              outcome.open, outcome.worst);
}

TEST(ClashFrames, AnEngineThatIsTurnedAndCarriedAwayIsAsDeepPosedAsBaked) {
  std::optional<assets::Scene> scene = engine();
  if (!scene || seeds() <= 4) GTEST_SKIP() << "set TANDEM_DATA and TANDEM_FULL_SIZE";
  const double size = glm::length(scene->bounds.max - scene->bounds.min);
  for (unsigned seed = 0; seed < 3; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> u(-1.0, 1.0);
    const Pose world{glm::dvec3(u(random), u(random), u(random)) * size,
                     fromRotationVector(glm::dvec3(u(random), u(random), u(random)) * kPi)};
    assets::Scene turned = *scene;
    for (assets::Part& part : turned.parts) part.worldFromPart = world * part.worldFromPart;
    // Baked vertices are rounded at the size of the whole, not of a part.
    const Outcome outcome = compare(turned, bakedScene(turned));
    EXPECT_LE(outcome.worstMetres, 1e-6 * size) << seed << ' ' << outcome.where;
    EXPECT_EQ(outcome.witnessesOutside, 0u) << seed << ' ' << outcome.where;
  }
}

}  // namespace
}  // namespace tandem::test
