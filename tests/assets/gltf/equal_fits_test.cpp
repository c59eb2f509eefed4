// Shafts and bores of equal radii whose file states the cylinders: their facets leave each other room.

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/mesh/fit_findings.h"
#include "assets/mesh/round_faces.h"
#include "tests/assets/gltf/findings.h"
#include "tests/assets/gltf/load_for_test.h"
#include "tests/support/exact_fit_file.h"

namespace tandem::assets {
namespace {

using test::ExactFit;
using test::exactFitFile;

Scene loadedEqual(const tests::GltfBuilder& file, double unitScale = 1.0) {
  LoadOptions options;
  options.movable = {"pin"};
  options.unitScale = unitScale;
  return loaded(file, options);
}

/// m, how near to an axis and how far from it a mesh has a place.
struct Span {
  double least = 1e300, most = 0.0;
};

/// Of the edges of all triangles; `within`: m, what is farther from the axis does not count for `most`.
Span spanOf(const Mesh& mesh, const Pose& axis, double within) {
  const Pose axisFromMesh = inverse(axis);
  Span span;
  for (const auto& c : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const glm::dvec2 a(transformPoint(axisFromMesh, mesh.positions[c[k]])),
          b(transformPoint(axisFromMesh, mesh.positions[c[(k + 1) % 3]])), along = b - a;
      const double square = glm::dot(along, along);
      const double share = square > 0.0 ? std::clamp(-glm::dot(a, along) / square, 0.0, 1.0) : 0.0;
      span.least = std::min(span.least, glm::length(a + share * along));
      for (const double corner : {glm::length(a), glm::length(b)})
        if (corner < within) span.most = std::max(span.most, corner);
    }
  return span;
}

struct Spans {
  Span pin, bore;
};

Spans spansOf(const Scene& scene, const ExactFit& fit) {
  EXPECT_EQ(scene.meshes.size(), 2u);
  for (const Mesh& mesh : scene.meshes) EXPECT_TRUE(mesh.closed);
  const double within = 1.2 * fit.radius;
  return {spanOf(scene.meshes[0], fit.place, within), spanOf(scene.meshes[1], fit.place, within)};
}

/// At any angle no corner of the pin reaches a facet of the bore, and neither has left the cylinder by more
/// than the room says.
void expectRoom(const ExactFit& fit) {
  SCOPED_TRACE(testing::Message() << fit.radius << " m, " << fit.segments << " and " << fit.boreSegments
                                  << " facets, " << fit.scale << " m a unit");
  const Scene scene = loadedEqual(exactFitFile(fit), fit.scale);
  const Spans spans = spansOf(scene, fit);
  const EqualFitRoom room = equalFitRoom(fit.radius);
  const double rounding = std::ldexp(8.0 * fit.radius, -24);
  EXPECT_LT(spans.pin.most, fit.radius + rounding);
  EXPECT_GT(spans.pin.most, fit.radius - rounding);
  EXPECT_GT(spans.bore.least, fit.radius + room.least - rounding);
  EXPECT_LT(spans.bore.most, fit.radius + room.least + 1.1 * room.sag + rounding);
  const Finding* const given = findingOf(scene, "equal-fits");
  ASSERT_NE(given, nullptr);
  EXPECT_EQ(given->severity, Finding::Severity::note);
  EXPECT_TRUE(fitFindings(scene).empty()) << "facets that suit the fit are not too coarse for it";
}

TEST(EqualFitRooms, AreNarrowerThanContactPromises) {
  for (double radius = 1e-5; radius < 100.0; radius *= 1.5) {
    const EqualFitRoom room = equalFitRoom(radius);
    EXPECT_LE(room.most, std::max(4e-6, 6e-5 * radius));
    EXPECT_LE(room.most, 1e-3 * radius);
    EXPECT_LT(room.least, room.most);
    EXPECT_GT(room.least, 0.0);
  }
}

TEST(EqualFitFacets, OfShaftsAndBoresNeverMeet) {
  for (const double radius : {0.0005, 0.004, 0.010, 0.050})
    for (const int segments : {16, 32, 96})
      for (const int boreSegments : {16, 48})
        for (const double scale : {1e-3, 1.0, 1e3}) {
          ExactFit fit;
          fit.radius = scale * radius;
          fit.play = 0.0;
          fit.height = 0.7 * fit.radius;
          fit.segments = segments;
          fit.boreSegments = boreSegments;
          fit.scale = scale;
          fit.place = {fit.radius * glm::dvec3(1.1, -0.7, 0.9), fromRotationVector({0.4, -0.7, 0.3})};
          expectRoom(fit);
        }
}

TEST(EqualFitFacets, MeetAsTheFileHasThem) {
  // The control.
  ExactFit fit;
  fit.play = 0.0;
  fit.exact = false;
  const Spans spans = spansOf(loadedEqual(exactFitFile(fit)), fit);
  EXPECT_LT(spans.bore.least, spans.pin.most - 1e-5);
}

TEST(EqualFitFacets, AllowForTheRoundingOfRadii) {
  for (const double play : {-1.5e-7, -1e-8, 1e-8, 9e-7}) {
    ExactFit fit;
    fit.play = play;
    const Spans spans = spansOf(loadedEqual(exactFitFile(fit)), fit);
    EXPECT_GT(spans.bore.least, spans.pin.most + 0.9 * equalFitRoom(fit.radius).least) << play;
  }
}

TEST(EqualFitFacets, OfAnInterferenceFitStayOnTheirCylinders) {
  ExactFit fit;
  fit.play = -3e-6;
  const Scene scene = loadedEqual(exactFitFile(fit));
  const Spans spans = spansOf(scene, fit);
  EXPECT_NEAR(spans.bore.most, fit.radius + fit.play, 1e-8);
  EXPECT_EQ(findingOf(scene, "equal-fits"), nullptr);
}

TEST(EqualFitFacets, OfRoundedEdgesStayAsTheyAre) {
  ExactFit fit;
  fit.play = 0.0;
  tests::GltfBuilder file = exactFitFile(fit);
  for (auto& mesh : file.json["meshes"]) mesh["extras"]["cad"]["faces"][0]["turn"] = 0.5 * M_PI;
  const Scene scene = loadedEqual(file), plain = loadedEqual(exactFitFile({.play = 0.0, .exact = false}));
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(scene.meshes[i].positions, plain.meshes[i].positions);
  // Two of them make half a turn, which may be a bearing.
  for (auto& mesh : file.json["meshes"]) {
    auto& faces = mesh["extras"]["cad"]["faces"];
    const tests::GltfBuilder::Json face = faces[0];
    faces.push_back(face);
  }
  EXPECT_NE(findingOf(loadedEqual(file), "equal-fits"), nullptr);
}

}  // namespace
}  // namespace tandem::assets
