#pragma once

// Force fields of every law, for tests.

#include <utility>
#include <vector>

#include "assets/scene/scene.h"

namespace tandem::test {

using assets::FieldRegion;
using assets::ForceField;
using Kind = ForceField::Kind;

inline assets::Scene sceneWith(std::vector<ForceField> fields) {
  assets::Scene scene;
  scene.materials.emplace_back();
  scene.fields = std::move(fields);
  return scene;
}

inline ForceField spring(double stiffness) {
  ForceField f;
  f.kind = Kind::spring;
  f.stiffness = stiffness;
  return f;
}

inline ForceField gravity(double strength, double radius) {
  ForceField f;
  f.kind = Kind::gravity;
  f.strength = strength;
  f.radius = radius;
  f.maxForce = 1e3;
  return f;
}

inline FieldRegion sphere(double radius, double fade) {
  return {FieldRegion::Kind::sphere, glm::dvec3(0.0), radius, fade};
}

inline FieldRegion box(const glm::dvec3& half, double fade) {
  return {FieldRegion::Kind::box, half, 0.0, fade};
}

/// All laws that have a potential, with and without borders.
inline std::vector<ForceField> storedFields() {
  std::vector<ForceField> all;
  ForceField f = spring(150.0);
  f.radius = 0.01;
  f.maxForce = 3.0;
  for (const auto anchor : {ForceField::Anchor::point, ForceField::Anchor::line, ForceField::Anchor::plane}) {
    f.anchor = anchor;
    f.range = f.fade = 0.0;
    all.push_back(f);
    f.range = 0.04;
    f.fade = 0.015;
    all.push_back(f);
  }
  f.anchor = ForceField::Anchor::path;
  f.points = {{-0.05, 0.0, 0.0}, {0.0, 0.01, 0.0}, {0.05, 0.0, 0.01}};
  all.push_back(f);
  all.push_back(gravity(1e-3, 0.02));
  all.push_back(gravity(1e-3, 0.02));
  all.back().maxForce = 1.5;  // cut between 0.012 and 0.026 m
  all.push_back(gravity(-1e-3, 0.02));
  all.back().range = 0.05;
  all.back().fade = 0.02;
  f = ForceField{};
  f.kind = Kind::potential;
  f.depth = 0.02;
  f.sigma = {0.02, 0.03, 0.015};
  all.push_back(f);
  f.region = box({0.05, 0.04, 0.03}, 0.02);
  f.maxForce = 100.0;
  all.push_back(f);
  f.potential = ForceField::Potential::ripple;
  f.region = sphere(0.05, 0.02);
  all.push_back(f);
  f.potential = ForceField::Potential::polynomial;
  f.terms = {{20.0, {2, 0, 0}}, {300.0, {1, 2, 1}}, {-5.0, {0, 0, 1}}};
  all.push_back(f);
  f = ForceField{};
  f.force = {0.5, -1.0, 0.2};
  all.push_back(f);
  return all;
}

}  // namespace tandem::test
