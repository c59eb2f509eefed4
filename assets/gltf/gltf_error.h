#pragma once

// How the loader's sources report a broken file to each other.

#include <exception>
#include <string>
#include <utility>

namespace tandem::assets {

/// What is wrong with a file, and where: "accessors[3].count", "header".
struct GltfError : std::exception {
  GltfError(std::string inPlace, std::string why) : place(std::move(inPlace)), reason(std::move(why)) {}
  const char* what() const noexcept override { return reason.c_str(); }

  std::string place, reason;
};

/// "section[index]" or "section[index].key", as places are named in messages.
std::string placeName(const char* section, std::size_t index, const char* key = nullptr);

}  // namespace tandem::assets
