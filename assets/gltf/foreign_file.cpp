#include "assets/gltf/foreign_file.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string_view>

namespace tandem::assets {
namespace {

enum class FileKind { model, importable, page, pointer, archive, document };

struct Known {
  const char* mark;  // the first bytes, or the end of the name
  const char* what;
  FileKind kind;
};

constexpr Known kBeginnings[] = {
    {"ISO-10303-21", "a STEP file", FileKind::importable},
    {"solid ", "an STL file", FileKind::importable},
    {"Kaydara FBX Binary", "an FBX file", FileKind::model},
    {"; FBX", "an FBX file", FileKind::model},
    {"#usda", "a USD file", FileKind::model},
    {"PXR-USDC", "a USD file", FileKind::model},
    {"ply\n", "a PLY file", FileKind::importable},
    {"ply\r", "a PLY file", FileKind::importable},
    {"AutoCAD", "a DXF file", FileKind::model},
    {"version https://git-lfs", "a Git LFS pointer, not the file itself", FileKind::pointer},
    {"<!doctype html", "a web page", FileKind::page},
    {"<html", "a web page", FileKind::page},
    {"\x1f\x8b", "a gzip archive", FileKind::archive},
    {"7z\xbc\xaf", "a 7z archive", FileKind::archive},
    {"Rar!", "a RAR archive", FileKind::archive},
    {"%PDF", "a PDF document", FileKind::document},
    {"\x89PNG", "a picture", FileKind::document},
    {"\xff\xd8\xff", "a picture", FileKind::document},
};

constexpr Known kEndings[] = {
    {".step", "a STEP file", FileKind::importable}, {".stp", "a STEP file", FileKind::importable},
    {".iges", "an IGES file", FileKind::model},     {".igs", "an IGES file", FileKind::model},
    {".stl", "an STL file", FileKind::importable},  {".obj", "an OBJ file", FileKind::importable},
    {".fbx", "an FBX file", FileKind::model},       {".dae", "a COLLADA file", FileKind::model},
    {".usd", "a USD file", FileKind::model},        {".usdz", "a USD file", FileKind::model},
    {".3mf", "a 3MF file", FileKind::importable},   {".ply", "a PLY file", FileKind::importable},
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
    case FileKind::page:
      return what + ", perhaps in place of a download that failed; Tandem reads glTF (.glb, .gltf)";
    case FileKind::pointer:
      return what + ": fetch that with git lfs pull";
    case FileKind::archive:
      return what + ": unpack it first";
    case FileKind::document:
      return what + "; Tandem reads glTF (.glb, .gltf)";
    case FileKind::importable:
      return what + "; Tandem reads glTF (.glb, .gltf): tandem-import makes that of it";
    case FileKind::model:
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
  if (begins(text, "PK\x03\x04")) return sentence({"", "a ZIP archive", FileKind::archive});
  return "this is neither binary glTF (.glb) nor JSON (.gltf)";
}

}  // namespace tandem::assets
