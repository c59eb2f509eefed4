#pragma once

// The exact surfaces of a body's faces: planes, cylinders, cones, spheres and tori.

#include <vector>

#include <TopoDS_Shape.hxx>

#include "assets/cad_import/cad_scene.h"

namespace tandem::cad_import {

/// One entry a face that has a formula, in m at `metresPerMillimetre`; other faces have none.
std::vector<ExactFace> exactFaces(const TopoDS_Shape& body, double metresPerMillimetre);

}  // namespace tandem::cad_import
