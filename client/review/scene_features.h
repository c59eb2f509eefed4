#pragma once

// Describes how a scene's surfaces, fields and controls feel, in words and numbers: for `tandem check`.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "assets/scene/scene.h"
#include "haptics/base/device.h"

namespace tandem::client {

/// One number of a feature.
struct Quantity {
  std::string name;  // as the glTF property
  double value = 0.0;
  std::string unit;  // SI; empty for a plain number
};

/// One effect by which a surface differs from a bare spring, or one property of a field or control.
struct Effect {
  std::string name;
  std::vector<Quantity> quantities;
  std::string text{};  // a property that is not a number, e.g. the pattern of a relief
};

/// A property that will not be felt as the file states it.
struct Remark {
  std::string kind;  // the same for all remarks of one sort, whatever their numbers
  std::string text;  // one sentence
};

/// How one material of one part feels, a field, or a control.
struct Feature {
  std::string name;  // of the part, field or control
  std::string kind;  // of the material, field or control
  std::string part;  // name of the part that it is or moves with; empty for a field fixed in the world
  std::vector<Effect> effects;
  std::vector<Remark> remarks;
  std::uint32_t material = assets::kNone;  // into Scene::materials; kNone for fields and controls
};

/// The limits by which values are judged.
struct FeatureLimits {
  double stiffest = 0.0;  // N/m, the stiffest stable contact of the device; 0 = not known
  double contact = 0.0;   // N/m, to which a hand's contacts are limited on it; 0 = not known
  double maxForce = 0.0;  // N; 0 = not known
  double tickRate = 1000.0;
  double damping = 0.0;  // N·s/m, to which damping of surfaces and fields is limited; 0 = not known
};

/// The materials of each part that state more than the tool's default spring, in order of parts.
std::vector<Feature> surfaceFeatures(const assets::Scene& scene, const FeatureLimits& limits);
std::vector<Feature> fieldFeatures(const assets::Scene& scene, const FeatureLimits& limits);
std::vector<Feature> controlFeatures(const assets::Scene& scene, const FeatureLimits& limits);

/// All remarks of one kind.
struct RemarkGroup {
  std::string kind, text;  // the text of the first
  std::string example;     // name of the first feature
  std::size_t features = 0, materials = 0;
};
/// In order of their first appearance.
std::vector<RemarkGroup> groupRemarks(const std::vector<Feature>& features);
/// One feature a material, in order of their first appearance, named "plate and 3 more".
std::vector<Feature> oneEachMaterial(const std::vector<Feature>& surfaces);

/// One line: "plate, plastic: stiffness 1000 N/m; friction static 0.8, dynamic 0.5".
std::string inOneLine(const Feature& feature);

/// A quantity's key in JSON: its name in snake case and its unit, "max_force_n".
std::string jsonKey(const Quantity& quantity);

}  // namespace tandem::client
