#include "client/exchange/guid.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <string_view>

#include "assets/scene/scene_package.h"

namespace tandem::client {
namespace {

constexpr std::string_view kIfcDigits = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_$";
constexpr std::size_t kIfcLength = 22;

assets::ContentHash hashOf(const std::string& name) {
  return assets::contentHash(std::as_bytes(std::span(name)));
}

}  // namespace

std::string uuidOf(const std::string& name) {
  assets::ContentHash hash = hashOf("uuid\n" + name);
  hash[6] = static_cast<std::uint8_t>(0x80 | (hash[6] & 0x0f));
  hash[8] = static_cast<std::uint8_t>(0x80 | (hash[8] & 0x3f));
  const std::string hex = assets::toHex(hash);
  return hex.substr(0, 8) + '-' + hex.substr(8, 4) + '-' + hex.substr(12, 4) + '-' + hex.substr(16, 4) + '-' +
         hex.substr(20, 12);
}

std::string uuidOf(const document::Entry& entry, const std::string& scene) {
  std::string name = scene;
  for (const std::int64_t part :
       {static_cast<std::int64_t>(entry.id), static_cast<std::int64_t>(entry.author),
        static_cast<std::int64_t>(entry.creation), entry.made})
    name += '\n' + std::to_string(part);
  return uuidOf(name + '\n' + entry.authorName);
}

std::string ifcGuidOf(const std::string& name) {
  const assets::ContentHash hash = hashOf("part\n" + name);
  // 128 bits: 2 for the first digit, 6 for each of the others.
  std::string guid;
  unsigned bits = 0;
  int count = 4;  // so that the first digit takes 2 bits of the first byte
  for (std::size_t i = 0; i < 16; ++i) {
    bits = bits << 8 | hash[i];
    for (count += 8; count >= 6; count -= 6) guid += kIfcDigits[bits >> (count - 6) & 63];
    bits &= (1u << count) - 1;
  }
  ASSERT(isIfcGuid(guid));
  return guid;
}

bool isIfcGuid(const std::string& text) {
  return text.size() == kIfcLength && text.front() >= '0' && text.front() <= '3' &&
         text.find_first_not_of(kIfcDigits) == std::string::npos;
}

PartGuids::PartGuids(const assets::Scene& scene) {
  for (const assets::Part& part : scene.parts) {
    const auto id = static_cast<PartId>(guids_.size());
    guids_.push_back(isIfcGuid(part.name) ? part.name : ifcGuidOf(part.name));
    parts_.emplace(guids_.back(), id);
  }
}

PartId PartGuids::part(const std::string& guid) const {
  const auto found = parts_.find(guid);
  return found == parts_.end() ? kNoPart : found->second;
}

}  // namespace tandem::client
