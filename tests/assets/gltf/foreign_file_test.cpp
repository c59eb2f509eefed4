#include "assets/gltf/foreign_file.h"

#include <gtest/gtest.h>
#include <string>

namespace tandem::assets {
namespace {

std::string messageFor(const std::string& path, const std::string& text) {
  return foreignFile(path, {reinterpret_cast<const unsigned char*>(text.data()), text.size()}).value_or("");
}

bool isNamed(const char* what, const std::string& path, const std::string& text) {
  const std::string message = messageFor(path, text);
  return message.find(std::string("this is ") + what) == 0;
}

TEST(ForeignFile, IsKnownByItsFirstBytesWhateverItsName) {
  EXPECT_TRUE(isNamed("a STEP file;", "pump.glb", "ISO-10303-21;\nHEADER;"));
  EXPECT_TRUE(isNamed("a STEP file;", "pump", "\xef\xbb\xbf\r\n ISO-10303-21;"));
  EXPECT_TRUE(isNamed("an STL file;", "pump.gltf", "solid pump\n facet normal"));
  EXPECT_TRUE(isNamed("an FBX file;", "pump.glb", std::string("Kaydara FBX Binary  \0\x1a", 22)));
  EXPECT_TRUE(isNamed("a USD file;", "pump.gltf", "#usda 1.0\n(\n)"));
  EXPECT_TRUE(isNamed("a USD file;", "pump.glb", "PXR-USDC"));
  EXPECT_TRUE(isNamed("a gzip archive: unpack", "pump.glb", "\x1f\x8b\x08"));
  EXPECT_TRUE(isNamed("a picture;", "pump.glb", "\x89PNG\r\n\x1a\n"));
}

TEST(ForeignFile, ThatStandsInPlaceOfADownloadSaysWhatHelps) {
  const std::string pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n";
  EXPECT_NE(messageFor("pump.glb", pointer).find("git lfs pull"), std::string::npos);
  EXPECT_TRUE(isNamed("a web page, perhaps", "pump.glb", "<!DOCTYPE html>\n<html>"));
  EXPECT_TRUE(isNamed("a web page, perhaps", "pump.glb", "\n <HTML><body>404"));
}

TEST(ForeignFile, IsKnownByTheEndOfItsName) {
  EXPECT_TRUE(isNamed("an STL file;", "a.dir/pump.STL", std::string(84, '\0')));
  EXPECT_TRUE(isNamed("an IGES file;", "pump.igs", "                    S      1"));
  EXPECT_TRUE(isNamed("an OBJ file;", "pump.obj", "v 0 0 0"));
  EXPECT_TRUE(isNamed("a USD file;", "pump.usdz", "PK\x03\x04"));
  EXPECT_TRUE(isNamed("a 3MF file;", "pump.3mf", "PK\x03\x04"));
  EXPECT_NE(messageFor("pump.3mf", "PK\x03\x04").find("tandem-import"), std::string::npos);
  EXPECT_TRUE(isNamed("a COLLADA file;", "pump.dae", "<?xml version=\"1.0\"?>"));
}

TEST(ForeignFile, OfAnUnknownKindIsSaidToBeNoGltf) {
  EXPECT_TRUE(isNamed("neither binary glTF", "pump.glb", "solidworks"));
  EXPECT_TRUE(isNamed("neither binary glTF", "pump.glb", std::string(100, '\0')));
  EXPECT_TRUE(isNamed("a ZIP archive", "pump.glb", "PK\x03\x04"));
}

TEST(ForeignFile, IsNotWhatBeginsLikeGltf) {
  EXPECT_EQ(messageFor("pump.stl", "{\"asset\": {}}"), "");
  EXPECT_EQ(messageFor("pump.step", "glTF\2"), "");
  EXPECT_EQ(messageFor("pump.stl", ""), "");
}

}  // namespace
}  // namespace tandem::assets
