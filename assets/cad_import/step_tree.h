#pragma once

// The tree of a STEP assembly: its nodes, and the bodies that instances share.

#include <array>
#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include <TopoDS_Shape.hxx>

#include "assets/cad_import/cad_scene.h"
#include "assets/cad_import/step_document.h"

namespace tandem::cad_import {

/// A solid, or a shell where the file has no solids, in its product's frame, mm. Becomes one mesh.
struct Body {
  TopoDS_Shape shape;
  std::string name;
  std::uint32_t colour = 0;                // into CadScene::colours, of faces without their own
  std::vector<std::uint32_t> faceColours;  // by TopExp::MapShapes' order of faces; kNone: the body's
  std::vector<std::uint32_t> instances;    // nodes
};

struct StepTree {
  CadScene scene;  // without meshes; CadNode::mesh is an index into bodies
  std::vector<Body> bodies;
};

/// The tree, its lengths in m by `metresPerUnit` m for each mm of the document; turned about x unless `yUp`.
StepTree buildTree(const StepDocument& step, double metresPerMillimetre, bool yUp);

}  // namespace tandem::cad_import
