// Feeds the scene loader and the package reader with whatever libFuzzer thinks of. The first byte chooses how
// the rest is taken: as a file, as a GLB whose chunks are the two halves (so that mutations of the JSON do
// not all die at the header), as a scene's raw bytes, or as a package.

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "assets/gltf/load_gltf.h"
#include "assets/scene/scene_check.h"
#include "assets/scene/scene_codec.h"
#include "assets/scene/scene_package.h"
#include "tests/support/gltf_builder.h"

namespace {

using namespace tandem::assets;

/// Whatever was accepted must hold to the invariants that everything else relies on.
void requireValid(const tandem::Result<Scene>& scene) {
  if (!scene) return;
  const tandem::Status status = checkScene(*scene);
  if (status) return;
  std::fprintf(stderr, "accepted a broken scene: %s\n", status.error().message.c_str());
  std::abort();
}

void loadAndCheck(const std::vector<unsigned char>& bytes) {
  LoadOptions options;
  options.allMovable = true;
  options.maxTriangles = 20000;
  const tandem::Result<Scene> scene = loadGltfFromMemory("fuzz", bytes, options);
  requireValid(scene);
  if (scene) requireValid(unpackScene(packScene(*scene)));
}

}  // namespace

/// A GLB of the text up to the first line break and the bytes after it.
static std::vector<unsigned char> asGlb(const std::uint8_t* data, std::size_t size) {
  std::size_t end = 0;
  while (end < size && data[end] != '\n') ++end;
  std::vector<unsigned char> binary(data + (end < size ? end + 1 : size), data + size);
  return tandem::tests::GltfBuilder::wrapGlb(std::string(data, data + end), std::move(binary));
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const auto* raw = reinterpret_cast<const std::byte*>(data + 1);
  switch (data[0] % 4) {
    case 0:
      loadAndCheck(std::vector<unsigned char>(data + 1, data + size));
      break;
    case 1:
      loadAndCheck(asGlb(data + 1, size - 1));
      break;
    case 2:
      requireValid(decodeScene({raw, size - 1}));
      break;
    default:
      requireValid(unpackScene({raw, size - 1}));
  }
  return 0;
}
