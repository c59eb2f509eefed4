#include "assets/gltf/foreign_file.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string_view>

namespace tandem::assets {
namespace {

enum class Kind { model, importable, page, pointer, archive, document };

struct Known {
  const char* mark;  // the first bytes, or the end of the name
  const char* what;
  Kind kind;
};

constexpr Known kBeginnings[] = {
    {"ISO-10303-21", "a STEP file", Kind::importable},
    {"solid ", "an STL file", Kind::importable},
    {"Kaydara FBX Binary", "an FBX file", Kind::model},
    {"; FBX", "an FBX file", Kind::model},
    {"#usda", "a USD file", Kind::model},
    {"PXR-USDC", "a USD file", Kind::model},
    {"ply\n", "a PLY file", Kind::importable},
    {"ply\r", "a PLY file", Kind::importable},
    {"AutoCAD", "a DXF file", Kind::model},
    {"version https://git-lfs", "a Git LFS pointer, not the file itself", Kind::pointer},
    {"<!doctype html", "a web page", Kind::page},
    {"<html", "a web page", Kind::page},
    {"\x1f\x8b", "a gzip archive", Kind::archive},
    {"7z\xbc\xaf", "a 7z archive", Kind::archive},
    {"Rar!", "a RAR archive", Kind::archive},
    {"%PDF", "a PDF document", Kind::document},
    {"\x89PNG", "a picture", Kind::document},
    {"\xff\xd8\xff", "a picture", Kind::document},
};

constexpr Known kEndings[] = {
    {".step", "a STEP file", Kind::importable}, {".stp", "a STEP file", Kind::importable},
    {".iges", "an IGES file", Kind::model},     {".igs", "an IGES file", Kind::model},
    {".stl", "an STL file", Kind::importable},  {".obj", "an OBJ file", Kind::importable},
    {".fbx", "an FBX file", Kind::model},       {".dae", "a COLLADA file", Kind::model},
    {".usd", "a USD file", Kind::model},        {".usdz", "a USD file", Kind::model},
    {".3mf", "a 3MF file", Kind::model},        {".ply", "a PLY file", Kind::importable},
};

/// The file's text without a leading byte-order mark and white space.
std::string_view beginning(std::span<const unsigned char> file) {
  std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  if (text.substr(0, 3) == "\xef\xbb\xbf") text.remove_prefix(3);
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  return first == std::string_view::npos ? std::string_view() : text.substr(first);
}

bool sameLetter(char a, char b) {
  return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
}

bool begins(std::string_view text, std::string_view with) {
  return text.size() >= with.size() && std::equal(with.begin(), with.end(), text.begin(), sameLetter);
}

std::string sentence(const Known& known) {
  const std::string what = std::string("this is ") + known.what;
  switch (known.kind) {
    case Kind::page:
      return what + ", perhaps in place of a download that failed; Tandem reads glTF (.glb, .gltf)";
    case Kind::pointer:
      return what + ": fetch that with git lfs pull";
    case Kind::archive:
      return what + ": unpack it first";
    case Kind::document:
      return what + "; Tandem reads glTF (.glb, .gltf)";
    case Kind::importable:
      return what + "; Tandem reads glTF (.glb, .gltf): tandem-import makes that of it";
    case Kind::model:
      break;
  }
  return what + "; Tandem reads glTF (.glb, .gltf): export it as that from your CAD program or FreeCAD";
}

}  // namespace

std::optional<std::string> foreignFile(const std::string& path, std::span<const unsigned char> file) {
  const std::string_view text = beginning(file);
  if (text.empty() || text.front() == '{' || begins(text, "glTF")) return std::nullopt;
  for (const Known& known : kBeginnings)
    if (begins(text, known.mark)) return sentence(known);
  const std::string ending = std::filesystem::path(path).extension().string();
  for (const Known& known : kEndings)
    if (ending.size() == std::string_view(known.mark).size() && begins(ending, known.mark))
      return sentence(known);
  if (begins(text, "PK\x03\x04")) return sentence({"", "a ZIP archive", Kind::archive});
  return "this is neither binary glTF (.glb) nor JSON (.gltf)";
}

}  // namespace tandem::assets
