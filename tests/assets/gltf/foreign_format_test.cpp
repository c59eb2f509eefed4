#include "assets/gltf/foreign_format.h"

#include <gtest/gtest.h>
#include <string>

namespace tandem::assets {
namespace {

std::string formatOf(const std::string& path, const std::string& text) {
  const char* format =
      foreignFormat(path, {reinterpret_cast<const unsigned char*>(text.data()), text.size()});
  return format == nullptr ? "" : format;
}

TEST(ForeignFormat, IsKnownByItsFirstBytesWhateverItsName) {
  EXPECT_EQ(formatOf("pump.glb", "ISO-10303-21;\nHEADER;"), "a STEP");
  EXPECT_EQ(formatOf("pump", "\xef\xbb\xbf\r\n ISO-10303-21;"), "a STEP");
  EXPECT_EQ(formatOf("pump.gltf", "solid pump\n facet normal"), "an STL");
}

TEST(ForeignFormat, IsKnownByTheEndOfItsName) {
  EXPECT_EQ(formatOf("a.dir/pump.STL", std::string(84, '\0')), "an STL");
  EXPECT_EQ(formatOf("pump.igs", "                    S      1"), "an IGES");
  EXPECT_EQ(formatOf("pump.obj", "v 0 0 0"), "an OBJ");
}

TEST(ForeignFormat, IsNotWhatBeginsLikeGltf) {
  EXPECT_EQ(formatOf("pump.stl", "{\"asset\": {}}"), "");
  EXPECT_EQ(formatOf("pump.step", "glTF\2"), "");
  EXPECT_EQ(formatOf("pump.glb", "solidworks"), "");
  EXPECT_EQ(formatOf("pump.stl", ""), "");
}

}  // namespace
}  // namespace tandem::assets
