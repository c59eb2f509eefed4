// Sections as they look, against pictures that somebody has looked at: one plane, two planes, a box and a
// turned plane through a pump, covered in the colours of the parts that they cut.
//
// TANDEM_WRITE_PICTURES=DIR writes the pictures of this machine there. Other versions of the software
// renderer draw edges a little differently, so a picture counts as the same while few of its pixels differ.

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "assets/gltf/load_gltf.h"
#include "client/marks/section_set.h"
#include "client/session/view_model.h"
#include "client/viewer/still_pictures.h"
#include "tests/client/viewer/picture.h"
#include "tests/support/source_file.h"

namespace tandem::client {
namespace {

constexpr int kGoldenWidth = 160, kGoldenHeight = 120;
constexpr int kLevelsOff = 24;         // by which a channel of a pixel may differ
constexpr double kPixelsOff = 0.01;    // share of the pixels that may differ by more
constexpr double kPumpAcross = 0.212;  // m

struct GoldenCase {
  const char* name;
  std::vector<std::string> planes;
  double yaw = 0.6, pitch = 0.55;
};
void PrintTo(const GoldenCase& golden, std::ostream* out) { *out << golden.name; }

const GoldenCase kGoldenCases[] = {
    {"one_plane", {"z=0.002"}},
    {"two_planes", {"z=0.002", "x=0.003"}, 0.8},
    {"box", {"x=0.085", "-x=-0.085", "y=0.095", "-y=0.01", "z=0.004", "-z=-0.07"}},
    {"turned_plane", {"0.5,0.4,0.75,0.045"}, 0.5, 0.65},
};

/// The shaft in its housing, with the impeller and its nut on it; nothing else is shown.
class GoldenSections : public testing::TestWithParam<GoldenCase> {
 protected:
  void SetUp() override {
    Result<assets::Scene> loaded = assets::loadGltf(sourceFile("assets/scenes/pump.glb"), {});
    ASSERT_TRUE(loaded.ok()) << loaded.error().message;
    scene_ = std::move(*loaded);
    put("housing", 0.0);
    put("shaft", 0.004);
    put("impeller", 0.034);
    put("impeller_nut", 0.075);
  }

  void put(const char* name, double y) {
    const PartId part = assets::findPart(scene_, name);
    ASSERT_NE(part, kNoPart);
    scene_.parts[part].worldFromPart = {{0.0, y, 0.0}, {1.0, 0.0, 0.0, 0.0}};
    shown_.push_back(part);
  }

  /// The picture with each plane `by` m further.
  Picture draw(double by = 0.0) const {
    const auto pictures = StillPictures::open(scene_, kGoldenWidth, kGoldenHeight);
    if (!pictures) return {};
    SectionSet sections;
    EXPECT_TRUE(sections.addAll(GetParam().planes).ok());
    for (std::size_t i = 0; i < sections.count(); ++i) sections.move(i, by);
    Camera camera;
    camera.target = {0.0, 0.045, 0.0};
    camera.distance = 0.3;
    camera.yaw = GetParam().yaw;
    camera.pitch = GetParam().pitch;
    Still still;
    still.worldFromEye = worldFromCamera(camera);
    still.sections = sections.planes();
    still.onlyThese = true;
    still.parts = shown_;
    std::vector<Pose> poses;
    for (const assets::Part& part : scene_.parts) poses.push_back(part.worldFromPart);
    const char* folder = std::getenv("TANDEM_WRITE_PICTURES");
    const std::string path =
        (folder != nullptr ? std::string(folder) + "/" : testing::TempDir() + "golden_") + GetParam().name +
        ".png";
    const std::vector<std::uint8_t> png = (*pictures)->draw(still, poses);
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(png.data()), static_cast<std::streamsize>(png.size()));
    return readPng(path);
  }

  /// Share of the pixels that are off.
  double off(const Picture& picture) const {
    const Picture golden = readPng(sourceFile("tests/client/viewer/sections/") + GetParam().name + ".png");
    return static_cast<double>(countDifferent(picture, golden, kLevelsOff)) / (kGoldenWidth * kGoldenHeight);
  }

  assets::Scene scene_;
  std::vector<PartId> shown_;
};

TEST_P(GoldenSections, LookAsTheyDidAndWouldNotOtherwise) {
  const Picture picture = draw();
  if (picture.width == 0) GTEST_SKIP() << "no OpenGL";
  if (std::getenv("TANDEM_WRITE_PICTURES") != nullptr) GTEST_SKIP() << "written";
  EXPECT_LE(off(picture), kPixelsOff);
  EXPECT_GT(off(draw(-0.02 * kPumpAcross)), kPixelsOff) << "planes that are elsewhere";
  for (assets::Mesh& mesh : scene_.meshes) mesh.closed = false;
  EXPECT_GT(off(draw()), kPixelsOff) << "cuts that are not covered";
}

INSTANTIATE_TEST_SUITE_P(Cases, GoldenSections, testing::ValuesIn(kGoldenCases),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace tandem::client
