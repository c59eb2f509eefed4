// Files too large to be read at once: what others do to them meanwhile, and what of them is kept in memory.

#include "assets/gltf/gltf_source.h"

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "assets/gltf/gltf_error.h"
#include "assets/gltf/load_gltf.h"
#include "assets/scene/scene_package.h"
#include "tests/support/gltf_builder.h"
#include "tests/support/sanitizers.h"
#include "tests/support/temporary_folder.h"

namespace tandem::assets {
namespace {

constexpr std::size_t kMebibyte = 1 << 20;

/// A .glb of a box, whose vertices and triangles come after `before` unused bytes of the binary chunk.
Bytes boxBehind(std::size_t before) {
  tests::GltfBuilder b;
  b.binary.resize(before);
  b.addNode({{"mesh", b.addBox(1, 2, 3, "box")}});
  return b.glb();
}

void write(const std::string& path, const Bytes& bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

/// Options that call `change` once the file is open and its meshes are not read yet.
LoadOptions meanwhile(const std::function<void()>& change) {
  LoadOptions options;
  options.progress = [change](double, const char* what) {
    if (std::string(what) == "reading the file") change();
  };
  return options;
}

/// MB, the most that this process has had in memory since forgetPeak().
double peak() {
  std::ifstream status("/proc/self/status");
  std::string line;
  while (std::getline(status, line))
    if (line.rfind("VmHWM:", 0) == 0) return std::atof(line.c_str() + 6) / 1024.0;
  return 0.0;
}

bool forgetPeak() { return static_cast<bool>(std::ofstream("/proc/self/clear_refs") << "5" << std::flush); }

class GltfSourceFiles : public ::testing::Test {
 protected:
  std::string path() const { return (folder_.path() / "box.glb").string(); }

  test::TemporaryFolder folder_;
};

TEST_F(GltfSourceFiles, GivesWhatMemoryGives) {
  Bytes bytes = boxBehind(3 * kMebibyte);
  for (std::size_t i = 64; i < 2 * kMebibyte; ++i) bytes[i + 1000] = static_cast<unsigned char>(i * i >> 7);
  const GltfSource memory(bytes);
  for (const std::size_t size : {bytes.size(), std::size_t{5000}}) {  // kept open; read at once
    write(path(), Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)));
    for (const bool keepOpen : {true, false}) {
      const GltfSource file(path(), "file", keepOpen);
      ASSERT_EQ(file.size(), size);
      for (const auto& [at, count] : {std::pair{0ul, size}, {0ul, 0ul}, {1234ul, 3000ul}, {size - 1, 1ul}}) {
        const GltfPiece a = file.read(at, count), b = memory.read(at, count);
        EXPECT_TRUE(std::equal(a.view().begin(), a.view().end(), b.view().begin(), b.view().end())) << at;
      }
    }
  }
}

TEST_F(GltfSourceFiles, MakesTheSameSceneOfAFileAsOfMemory) {
  const Bytes bytes = boxBehind(3 * kMebibyte);
  write(path(), bytes);
  const Result<Scene> file = loadGltf(path(), {}), memory = loadGltfFromMemory("box.glb", bytes, {});
  ASSERT_TRUE(file.ok() && memory.ok());
  EXPECT_EQ(packScene(*file), packScene(*memory));
}

TEST_F(GltfSourceFiles, RefuseWhatOthersChangeMeanwhile) {
  const auto shorten = [&] { std::filesystem::resize_file(path(), 2 * kMebibyte); };
  const auto lengthen = [&] { std::ofstream(path(), std::ios::app) << "more"; };
  const auto alter = [&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(30));  // file systems count time in some ms
    std::fstream(path(), std::ios::in | std::ios::out | std::ios::binary).seekp(100000) << "other";
  };
  for (const auto& [change, what] :
       {std::pair<std::function<void()>, std::string>{shorten, "has become shorter while it was read"},
        {lengthen, "has changed while it was read"},
        {alter, "has changed while it was read"}}) {
    write(path(), boxBehind(3 * kMebibyte));
    EXPECT_TRUE(loadGltf(path(), meanwhile([] {})).ok());
    const std::string cache = (folder_.path() / "cache").string();
    for (const std::string& in : {std::string(), cache}) {
      write(path(), boxBehind(3 * kMebibyte));
      const Result<Scene> scene = loadScene(path(), meanwhile(change), in);
      ASSERT_FALSE(scene.ok()) << what;
      EXPECT_EQ(scene.error().message, path() + ": file: '" + path() + "' " + what);
    }
    EXPECT_FALSE(std::filesystem::exists(cache)) << "a scene of no file at all";
  }
}

TEST_F(GltfSourceFiles, AreNotKeptInMemory) {
  constexpr double kSize = 96.0;  // MB
  const std::size_t unused = static_cast<std::size_t>(kSize) * kMebibyte;
  write(path(), boxBehind(unused));
  if (test::kSanitized) GTEST_SKIP() << "a sanitizer keeps what is freed";
  if (!forgetPeak()) GTEST_SKIP() << "the peak of this process cannot be set back";
  const double before = peak();
  const std::string cache = (folder_.path() / "cache").string();
  ASSERT_TRUE(loadScene(path(), {}, cache).ok());
  ASSERT_TRUE(loadScene(path(), {}, cache).ok());
  EXPECT_LT(peak() - before, 0.25 * kSize);
  const GltfSource control(path(), "file", false);
  EXPECT_GT(peak() - before, 0.9 * kSize);
}

}  // namespace
}  // namespace tandem::assets
