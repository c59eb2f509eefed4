#include "assets/generate/sample_scene.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "assets/generate/triangulate.h"
#include "assets/gltf/load_gltf.h"
#include "assets/mesh/mesh_analysis.h"
#include "tests/support/source_file.h"

namespace tandem::generate {
namespace {

/// The shapes as a reader of the file sees them, in single precision.
std::vector<assets::MeshAnalysis> analyseShapes(const SampleScene& scene) {
  std::vector<assets::MeshAnalysis> all;
  for (const SampleShape& shape : scene.shapes) {
    assets::TriangleSoup soup = shape.solid.soup();
    for (glm::dvec3& p : soup.positions) p = glm::dvec3(glm::vec3(p));
    all.push_back(assets::analyseMesh(std::move(soup), 0.5));
  }
  return all;
}

const assets::Mesh& meshNamed(const SampleScene& scene, const std::vector<assets::MeshAnalysis>& shapes,
                              const std::string& name) {
  for (std::size_t i = 0; i < scene.shapes.size(); ++i)
    if (scene.shapes[i].name == name) return shapes[i].mesh;
  throw std::runtime_error("no shape " + name);
}

/// Whether p lies in a closed mesh, by the solid angle that its faces fill (van Oosterom and Strackee 1983).
bool isInside(const assets::Mesh& mesh, const glm::dvec3& p) {
  if (!glm::all(glm::greaterThan(p, mesh.bounds.min)) || !glm::all(glm::lessThan(p, mesh.bounds.max)))
    return false;
  double angle = 0.0;
  for (const auto& t : mesh.triangles) {
    const glm::dvec3 a = mesh.positions[t[0]] - p, b = mesh.positions[t[1]] - p, c = mesh.positions[t[2]] - p;
    const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
    angle += 2.0 * std::atan2(glm::dot(a, glm::cross(b, c)),
                              la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
  }
  return angle > 2.0 * M_PI;
}

TEST(SampleScenes, EveryShapeIsOneClosedShellWithoutDefects) {
  for (const SampleScene& scene : makeAllScenes()) {
    const auto shapes = analyseShapes(scene);
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      SCOPED_TRACE(scene.name + "/" + scene.shapes[i].name);
      const assets::MeshDefects& d = shapes[i].defects;
      EXPECT_TRUE(shapes[i].mesh.closed);
      EXPECT_EQ(shapes[i].mesh.shellCount, 1u);
      EXPECT_GT(shapes[i].mesh.volume, 0.0);
      EXPECT_EQ(d.boundaryEdges + d.nonManifoldEdges + d.openShells + d.nonOrientableShells, 0u);
      EXPECT_EQ(d.degenerateFaces + d.duplicateFaces, 0u);
      EXPECT_EQ(d.flippedFaces, 0u);
      EXPECT_EQ(d.invertedShells, 0u);
    }
  }
}

TEST(SampleScenes, MovablePartsWeighWhatAHandCanHold) {
  for (const SampleScene& scene : makeAllScenes()) {
    const auto shapes = analyseShapes(scene);
    for (const SamplePart& part : scene.parts) {
      if (!part.movable) continue;
      const double density = scene.feels[scene.shapes[part.shape].feel].density;
      const assets::MassProperties m = assets::massProperties(shapes[part.shape].mesh, density);
      EXPECT_GT(m.mass, 0.001) << part.name;
      EXPECT_LT(m.mass, 5.0) << part.name;
      // The file states a diagonal inertia, which needs the part's axes to be the principal ones.
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          if (i != j) {
            EXPECT_LT(std::abs(m.inertia[i][j]), 1e-3 * m.inertia[i][i]) << part.name;
          }
    }
  }
}

TEST(SampleScenes, PartNamesAreUnique) {
  for (const SampleScene& scene : makeAllScenes()) {
    std::set<std::string> names;
    for (const SamplePart& part : scene.parts) names.insert(part.name);
    EXPECT_EQ(names.size(), scene.parts.size()) << scene.name;
  }
}

TEST(SampleScenes, NoPartStandsInAnotherAtRest) {
  for (const SampleScene& scene : makeAllScenes()) {
    const auto shapes = analyseShapes(scene);
    for (const SamplePart& a : scene.parts) {
      for (const SamplePart& b : scene.parts) {
        if (&a == &b) continue;
        const assets::Mesh &meshA = shapes[a.shape].mesh, &meshB = shapes[b.shape].mesh;
        const glm::dvec3 shift = a.position - b.position;
        std::size_t inside = 0;
        for (std::size_t v = 0; v < meshA.positions.size(); v += 3) {
          const glm::dvec3 p = meshA.positions[v] + shift;
          if (isInside(meshB, p)) ++inside;
        }
        EXPECT_EQ(inside, 0u) << scene.name << ": " << a.name << " in " << b.name;
      }
    }
  }
}

TEST(SampleScenes, PegsFitTheirHolesAtEveryAngleByTheStatedClearance) {
  const SampleScene scene = makePegBoard();
  const auto shapes = analyseShapes(scene);
  const assets::Mesh& board = meshNamed(scene, shapes, "board");
  const double clearance[3] = {0.5e-3, 0.1e-3, 0.02e-3};
  const char* pegs[3] = {"peg_0.5", "peg_0.1", "peg_0.02"};
  for (int i = 0; i < 3; ++i) {
    double pegRadius = 0.0;
    for (const glm::dvec3& p : meshNamed(scene, shapes, pegs[i]).positions)
      pegRadius = std::max(pegRadius, std::hypot(p.x, p.z));
    // The nearest that any face of the hole comes to its axis: at the middles of its edges.
    double holeRadius = 1.0;
    const double x = (i - 1) * 0.055;
    for (const auto& t : board.triangles) {
      for (int e = 0; e < 3; ++e) {
        const glm::dvec3 middle = 0.5 * (board.positions[t[e]] + board.positions[t[(e + 1) % 3]]);
        const double r = std::hypot(middle.x - x, middle.z);
        if (std::abs(middle.y - 0.027) < 0.0145) holeRadius = std::min(holeRadius, r);
      }
    }
    EXPECT_NEAR(2.0 * (holeRadius - pegRadius), clearance[i], 2e-8) << pegs[i];
  }
}

TEST(SampleScenes, ThePumpGoesTogether) {
  // Stacked as a fitter would: collar on its seat, impeller on the collar, nut on the hub, cover on the
  // flange.
  const SampleScene scene = makePump();
  const auto shapes = analyseShapes(scene);
  const assets::Mesh& housing = meshNamed(scene, shapes, "housing");
  struct Place {
    const char* shape;
    double y;
  };
  const Place stack[] = {
      {"shaft", 2.1e-3}, {"impeller", 49.2e-3}, {"impeller_nut", 89.3e-3}, {"cover", 102.1e-3}};
  for (const Place& a : stack) {
    for (const Place& b : stack) {
      const assets::Mesh& meshA = meshNamed(scene, shapes, a.shape);
      const assets::Mesh& meshB = meshNamed(scene, shapes, b.shape);
      for (std::size_t v = 0; v < meshA.positions.size(); v += 9) {
        const glm::dvec3 p = meshA.positions[v] + glm::dvec3(0.0, a.y, 0.0);
        if (a.shape != b.shape) {
          ASSERT_FALSE(isInside(meshB, p - glm::dvec3(0.0, b.y, 0.0))) << a.shape << " in " << b.shape;
        }
        ASSERT_FALSE(isInside(housing, p)) << a.shape << " in the housing";
      }
    }
  }
}

TEST(SampleScenes, CommittedFilesAreWhatTheGeneratorMakes) {
  std::size_t total = 0;
  for (const SampleScene& scene : makeAllScenes()) {
    std::ifstream file(sourceFile("assets/scenes/") + scene.name + ".glb", std::ios::binary);
    ASSERT_TRUE(file) << scene.name;
    const std::string committed((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    EXPECT_TRUE(committed == toGlb(scene)) << scene.name << ".glb differs: run tandem-scenes assets/scenes";
    total += committed.size();
  }
  EXPECT_LT(total, 4u << 20);
}

TEST(SampleScenes, LoadAsTheyWereMadeWithNothingToRemark) {
  for (const SampleScene& made : makeAllScenes()) {
    const auto loaded = assets::loadGltf(sourceFile("assets/scenes/") + made.name + ".glb", {});
    ASSERT_TRUE(loaded.ok()) << loaded.error().message;
    for (const assets::Finding& finding : loaded->findings)
      EXPECT_EQ(finding.severity, assets::Finding::Severity::note) << made.name << ": " << finding.message;
    for (const SamplePart& part : made.parts) {
      const PartId id = assets::findPart(*loaded, part.name);
      ASSERT_NE(id, kNoPart) << part.name;
      EXPECT_EQ(loaded->parts[id].movable, part.movable) << part.name;
      EXPECT_EQ(loaded->parts[id].massProperties.mass > 0.0, part.movable) << part.name;
      EXPECT_TRUE(loaded->meshes[loaded->parts[id].mesh].closed) << part.name;
      EXPECT_LT(glm::distance(loaded->parts[id].worldFromPart.position, part.position), 1e-12);
    }
  }
}

TEST(SampleScenes, TheSunAndItsPlanetsPullAndGoWithTheirParts) {
  const auto scene = assets::loadGltf(sourceFile("assets/scenes/solar_system.glb"), {});
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  ASSERT_EQ(scene->fields.size(), 6u);
  for (std::size_t i = 0; i < scene->fields.size(); ++i) {
    const assets::ForceField& field = scene->fields[i];
    EXPECT_EQ(field.kind, assets::ForceField::Kind::gravity);
    EXPECT_EQ(field.part, scene->parts[i].movable ? static_cast<PartId>(i) : kNoPart);
    // The field's radius is that of the body that is seen.
    const assets::Bounds& bounds = scene->meshes[scene->parts[i].mesh].bounds;
    EXPECT_NEAR(field.radius, 0.5 * (bounds.max.y - bounds.min.y), 1e-6) << field.name;
  }
  EXPECT_NEAR(scene->fields[0].strength, 2.5 * 0.03 * 0.03, 1e-12);
}

TEST(SampleScenes, TheGuidedPathKeepsClearOfItsPlate) {
  const auto scene = assets::loadGltf(sourceFile("assets/scenes/guided_path.glb"), {});
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  ASSERT_EQ(scene->fields.size(), 1u);
  const assets::ForceField& guide = scene->fields[0];
  EXPECT_EQ(guide.kind, assets::ForceField::Kind::guide);
  EXPECT_EQ(guide.part, kNoPart);
  bool through = false;
  for (std::size_t i = 0; i + 1 < guide.points.size(); ++i) {
    for (double s = 0.0; s <= 1.0; s += 0.05) {
      const glm::dvec3 p = glm::mix(guide.points[i], guide.points[i + 1], s);
      if (p.y < 0.0 || p.y > 0.01) continue;
      through = true;
      EXPECT_LT(std::hypot(p.x, p.z) + guide.radius, 0.009);
    }
  }
  EXPECT_TRUE(through);
}

TEST(Triangulate, CoversAPlateWithHolesExactly) {
  const std::vector<glm::dvec2> plate = roundedRectangle(glm::dvec2(4.0, 3.0), 0.5, 6);
  const auto signedArea = [](const std::vector<glm::dvec2>& loop) {
    double area = 0.0;
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const glm::dvec2 &a = loop[i], &b = loop[(i + 1) % loop.size()];
      area += 0.5 * (a.x * b.y - a.y * b.x);
    }
    return area;
  };
  std::vector<Loop> holes;
  double expected = signedArea(plate);
  std::size_t corners = plate.size();
  for (int i = 0; i < 12; ++i) {
    holes.push_back(circle(0.3, 10 + i, glm::dvec2(-1.2 + 0.8 * (i % 4), -0.9 + 0.9 * (i / 4))));
    expected -= signedArea(holes.back());
    corners += holes.back().size();
  }
  double area = 0.0;
  const auto triangles = triangulate(plate, holes);
  for (const auto& t : triangles) {
    const double a = signedArea({t[0], t[1], t[2]});
    EXPECT_GT(a, 0.0);
    area += a;
  }
  EXPECT_NEAR(area, expected, 1e-12);
  EXPECT_EQ(triangles.size(), corners + 2 * holes.size() - 2);
}

}  // namespace
}  // namespace tandem::generate
