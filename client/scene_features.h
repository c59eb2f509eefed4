#pragma once

// What a scene's surfaces, fields and controls feel like, in words and numbers: for `tandem check`.

#include <string>
#include <vector>

#include "assets/scene.h"
#include "haptics/device.h"

namespace tandem::client {

/// One number of a feature.
struct Quantity {
  std::string name;  // as the glTF property
  double value = 0.0;
  std::string unit;  // SI; empty for a plain number
};

/// One way in which a surface differs from a bare spring, or one property of a field or control.
struct Effect {
  std::string name;
  std::vector<Quantity> quantities;
  std::string text{};  // what is not a number, e.g. the pattern of a relief
};

/// How one material of one part feels, a field, or a control.
struct Feature {
  std::string name;  // of the part, field or control
  std::string kind;  // of the material, field or control
  std::string part;  // that it is or goes with; empty for a field that stands in the world
  std::vector<Effect> effects;
  std::vector<std::string> remarks;  // what will not be felt as written, one sentence each
};

/// What values are judged by.
struct FeatureLimits {
  double stiffest = 0.0;  // N/m, that the device bears for good; 0 = not known
  double contact = 0.0;   // N/m, to which a hand's contacts are held on it; 0 = not known
  double maxForce = 0.0;  // N; 0 = not known
  double tickRate = 1000.0;
};

/// The materials of each part that are more than a spring with the tool's stiffness, in order of parts.
std::vector<Feature> surfaceFeatures(const assets::Scene& scene, const FeatureLimits& limits);
std::vector<Feature> fieldFeatures(const assets::Scene& scene, const FeatureLimits& limits);
std::vector<Feature> controlFeatures(const assets::Scene& scene, const FeatureLimits& limits);

/// One line: "plate, plastic: stiffness 1000 N/m; friction static 0.8, dynamic 0.5".
std::string inOneLine(const Feature& feature);

/// A quantity's key in JSON: its name in snake case and its unit, "max_force_n".
std::string jsonKey(const Quantity& quantity);

}  // namespace tandem::client
