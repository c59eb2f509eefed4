#include "client/base/json_input.h"

#include <filesystem>
#include <fstream>
#include <sstream>

#include <nlohmann/json.hpp>

namespace tandem::client {

using nlohmann::json;

namespace {

constexpr int kDeepest = 32;  // a scenario needs 5
constexpr std::uintmax_t kLargestFile = 64u << 20;

/// Whether brackets outside of strings nest deeper than kDeepest.
bool tooDeep(const std::string& text) {
  int depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted) {
      if (c == '\\') ++i;
      if (c == '"') quoted = false;
    } else if (c == '"') {
      quoted = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kDeepest) return true;
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return false;
}

/// The library's message without its own name and number in front.
std::string reasonOf(const json::exception& error) {
  const std::string text = error.what();
  const std::size_t end = text.find("] ");
  return end == std::string::npos ? text : text.substr(end + 2);
}

}  // namespace

Result<std::string> readTextFile(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) return Error{path + ": cannot be read"};
  if (std::filesystem::is_directory(status)) return Error{path + ": is a directory"};
  if (const auto size = std::filesystem::file_size(path, error); !error && size > kLargestFile)
    return Error{path + ": larger than 64 MiB"};
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) return Error{path + ": cannot be read"};
  return text.str();
}

Result<json> parseJson(const std::string& text, const std::string& source) {
  if (tooDeep(text))
    return Error{source + ": JSON nested deeper than " + std::to_string(kDeepest) + " levels"};
  try {
    return json::parse(text);
  } catch (const json::exception& error) {
    return Error{source + ": not JSON: " + reasonOf(error)};
  }
}

}  // namespace tandem::client
