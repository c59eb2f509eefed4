#include "client/base/json_input.h"

#include <filesystem>
#include <fstream>
#include <sstream>

namespace tandem::client {

namespace {

constexpr int kMaxDepth = 32;  // a scenario needs 5
constexpr std::uintmax_t kLargestFile = 64u << 20;

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

Result<Json> parseJson(const std::string& text, const std::string& source) {
  if (Json::nesting(text) > kMaxDepth)
    return Error{source + ": JSON nested deeper than " + std::to_string(kMaxDepth) + " levels"};
  Result<Json> parsed = Json::parse(text);
  if (!parsed) return Error{source + ": not JSON: " + parsed.error().message};
  return parsed;
}

}  // namespace tandem::client
