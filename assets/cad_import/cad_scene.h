#pragma once

// What an import makes of a CAD file, whatever its format: a tree of nodes, the meshes that they share,
// colours, and the exact surfaces behind the facets. Lengths in m, angles in rad; independent of any CAD
// library.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

namespace tandem::cad_import {

inline constexpr std::uint32_t kNone = 0xffffffffu;

/// A surface of a solid that has a formula, in the mesh's frame.
struct ExactFace {
  enum class Kind : std::uint8_t { plane, cylinder, cone, sphere, torus };
  Kind kind = Kind::plane;
  glm::dvec3 point{0.0};           // m: on the plane; on the axis where `from` is 0; a centre
  glm::dvec3 axis{0.0, 0.0, 1.0};  // unit; of a plane its normal, out of the solid
  double radius = 0.0;             // m: cylinder, sphere, cone at `point`, torus from its axis
  double minorRadius = 0.0;        // m: torus
  double halfAngle = 0.0;          // rad: cone, grows along the axis where positive
  double from = 0.0, to = 0.0;     // m along the axis: cylinder, cone
  double turn = 0.0;               // rad: how much of the way around there is of it
  bool hollow = false;             // the solid lies outside of it: a bore, a socket
};

/// Triangles of one colour.
struct CadTriangles {
  std::uint32_t colour = 0;            // into CadScene::colours
  std::vector<std::uint32_t> corners;  // 3 a triangle, into CadMesh::positions
};

struct CadMesh {
  std::string name;
  std::vector<glm::dvec3> positions;  // m
  std::vector<glm::vec3> normals;     // unit, one a position; or none at all
  std::vector<CadTriangles> triangles;
  std::vector<ExactFace> faces;
};

struct CadNode {
  std::string name;
  std::uint32_t parent = kNone;  // into CadScene::nodes; parents stand before their children
  glm::dmat4 parentFromNode{1.0};
  std::uint32_t mesh = kNone;
  double density = 0.0;                 // kg/m^3; 0: the file states none
  std::string material;                 // as the file names it
  std::vector<std::string> tolerances;  // dimensions and tolerances that the file states, in words
};

/// Something that a user should know about the file.
struct CadFinding {
  std::string code;  // stable, kebab-case
  std::uint64_t count = 0;
  std::string message;  // one sentence
};

struct CadScene {
  std::string name;
  std::string unit;                           // as the file declares it; empty: it declares none
  double metresPerUnit = 0.001;               // that all lengths have been multiplied by
  std::vector<std::array<float, 4>> colours;  // linear RGBA
  std::vector<CadMesh> meshes;
  std::vector<CadNode> nodes;
  std::vector<CadFinding> findings;
};

}  // namespace tandem::cad_import
