#pragma once

// Loads a built glTF as tests want it: whole and checked, or refused for a reason that names a part of the
// message.

#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "assets/gltf/load_gltf.h"
#include "assets/scene/scene_check.h"
#include "tests/support/gltf_builder.h"

namespace tandem::assets {

inline Scene loaded(const tests::GltfBuilder& builder, const LoadOptions& options = {}) {
  Result<Scene> scene = loadGltfFromMemory("test.glb", builder.glb(), options);
  EXPECT_TRUE(scene.ok()) << scene.error().message;
  if (!scene) return {};
  const Status status = checkScene(*scene);
  EXPECT_TRUE(status.ok()) << status.error().message;
  return std::move(scene).value();
}

inline void expectRefused(const tests::GltfBuilder& builder, const std::string& part) {
  const Result<Scene> scene = loadGltfFromMemory("test.glb", builder.glb(), {});
  ASSERT_FALSE(scene.ok()) << part;
  EXPECT_NE(scene.error().message.find(part), std::string::npos) << scene.error().message;
}

}  // namespace tandem::assets
