#include "assets/gltf/foreign_format.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string_view>
#include <utility>

namespace tandem::assets {
namespace {

/// The file's text without a leading byte-order mark and white space.
std::string_view beginning(std::span<const unsigned char> file) {
  std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  if (text.substr(0, 3) == "\xef\xbb\xbf") text.remove_prefix(3);
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  return first == std::string_view::npos ? std::string_view() : text.substr(first);
}

bool begins(std::string_view text, std::string_view with) { return text.substr(0, with.size()) == with; }

}  // namespace

const char* foreignFormat(const std::string& path, std::span<const unsigned char> file) {
  const std::string_view text = beginning(file);
  if (begins(text, "ISO-10303-21")) return "a STEP";
  if (begins(text, "solid ")) return "an STL";
  if (text.empty() || text.front() == '{' || begins(text, "glTF")) return nullptr;
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  constexpr std::pair<const char*, const char*> kEndings[] = {{".step", "a STEP"},  {".stp", "a STEP"},
                                                              {".iges", "an IGES"}, {".igs", "an IGES"},
                                                              {".stl", "an STL"},   {".obj", "an OBJ"}};
  for (const auto& [known, format] : kEndings)
    if (ending == known) return format;
  return nullptr;
}

}  // namespace tandem::assets
