#include "client/picture/drawn_levels.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <utility>

#include "assets/base/assert.h"
#include "assets/base/parallel.h"
#include "client/picture/level_choice.h"

namespace tandem::client {
namespace {

constexpr std::size_t kLargeScene = 300'000;     // triangles, from which on levels are worth their making
constexpr std::size_t kExactBytes = 320u << 20;  // of exact meshes on the GPU, unless one picture needs more
constexpr std::chrono::milliseconds kUploadTime{4};
constexpr std::uint8_t kNoLevel = 0xff;

}  // namespace

std::unique_ptr<DrawnLevels> DrawnLevels::of(const assets::Scene& scene, const Detail& detail) {
  if (!detail.levels || assets::triangleCount(scene) < kLargeScene) return nullptr;
  std::vector<std::uint32_t> large;
  for (std::uint32_t m = 0; m < scene.meshes.size(); ++m)
    if (scene.meshes[m].triangles.size() >= kLevelsFrom) large.push_back(m);
  if (large.empty()) return nullptr;
  return std::unique_ptr<DrawnLevels>(new DrawnLevels(scene, std::move(large), detail));
}

DrawnLevels::DrawnLevels(const assets::Scene& scene, std::vector<std::uint32_t> large, const Detail& detail)
    : scene_(scene),
      owner_(scene.meshes.size(), assets::kNone),
      shapes_(scene.meshes.size()),
      last_(scene.parts.size(), kNoLevel),
      pixelsOff_(scene.parts.size(), 0.0) {
  std::vector<assets::ContentHash> contents(large.size());
  parallelFor(large.size(), [&](std::size_t i) { contents[i] = levelContent(scene.meshes[large[i]]); });
  std::map<assets::ContentHash, std::uint32_t> first;
  std::vector<LevelMaker::Source> owners;
  for (std::size_t i = 0; i < large.size(); ++i) {
    const auto [found, isNew] = first.emplace(contents[i], large[i]);
    owner_[large[i]] = found->second;
    if (isNew) owners.push_back({large[i], contents[i]});
  }
  makeStandIns(owners);
  maker_ = std::make_unique<LevelMaker>(scene, owners, detail.cacheDirectory);
}

void DrawnLevels::makeStandIns(const std::vector<LevelMaker::Source>& meshes) {
  std::vector<Level> standIns(meshes.size());
  parallelFor(meshes.size(), [&](std::size_t i) { standIns[i] = standInFor(scene_.meshes[meshes[i].mesh]); });
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    Shape& shape = shapes_[meshes[i].mesh];
    shape.levels.push_back(upload(standIns[i].mesh));
    shape.errors.push_back(standIns[i].error);
  }
}

bool DrawnLevels::receive() {
  const auto until = std::chrono::steady_clock::now() + kUploadTime;
  bool any = false;
  // From the second frame on it is known what is near.
  if (frame_++ == 1) maker_->begin();
  while (std::chrono::steady_clock::now() < until) {
    std::optional<LevelMaker::Made> made = maker_->take();
    if (!made) break;
    add(std::move(*made));
    any = true;
  }
  dropOldExact();
  return any;
}

void DrawnLevels::add(LevelMaker::Made made) {
  Shape& shape = shapes_[made.mesh];
  if (made.exact) {
    shape.exact = upload(made.levels.front().mesh);
    shape.exactUsed = frame_;
    shape.exactAsked = false;
    return;
  }
  if (made.levels.empty()) return;  // the stand-in stays, and what is nearer is exact
  shape.levels.clear();
  shape.errors.clear();
  for (const Level& level : made.levels) {
    shape.levels.push_back(upload(level.mesh));
    shape.levels.back().facesOutward = level.facesOutward;
    shape.errors.push_back(level.error);
  }
  shape.standsIn = false;
  for (std::size_t p = 0; p < scene_.parts.size(); ++p)
    if (has(scene_.parts[p].mesh) && owner_[scene_.parts[p].mesh] == made.mesh) last_[p] = kNoLevel;
}

/// Frees exact meshes that no picture has needed for longest, down to kExactBytes.
void DrawnLevels::dropOldExact() {
  std::size_t bytes = 0;
  for (const Shape& shape : shapes_) bytes += shape.exact ? shape.exact->bytes : 0;
  while (bytes > kExactBytes) {
    Shape* oldest = nullptr;
    for (Shape& shape : shapes_)
      if (shape.exact && shape.exactUsed + 1 < frame_ &&
          (oldest == nullptr || shape.exactUsed < oldest->exactUsed))
        oldest = &shape;
    if (oldest == nullptr) return;
    bytes -= oldest->exact->bytes;
    oldest->exact.reset();
  }
}

void DrawnLevels::askExact(Shape& shape, std::uint32_t mesh) {
  if (std::exchange(shape.exactAsked, true)) return;
  maker_->askExact(mesh);
}

const GpuMesh& DrawnLevels::meshFor(std::uint32_t part, std::uint32_t mesh, double pixel, bool exact) {
  ASSERT(has(mesh) && part < last_.size() && pixel > 0.0);
  const std::uint32_t owner = owner_[mesh];
  Shape& shape = shapes_[owner];
  const std::size_t level = chooseLevel(shape.errors, pixel, last_[part]);
  last_[part] = static_cast<std::uint8_t>(level);
  const double off = shape.errors[level] / pixel;
  // While levels are to come, the exact mesh of all that stands near would be more than can be drawn.
  if (exact || (off > kMostPixels && (!shape.standsIn || maker_->left() == 0))) {
    if (shape.exact) {
      shape.exactUsed = frame_;
      pixelsOff_[part] = 0.0;
      return *shape.exact;
    }
    askExact(shape, owner);
  }
  pixelsOff_[part] = off;
  if (shape.standsIn) {
    if (std::exchange(shape.urgentIn, frame_) != frame_) shape.urgency = 0.0;
    if (off > shape.urgency) maker_->setUrgency(owner, static_cast<float>(shape.urgency = off));
  }
  return shape.levels[level];
}

}  // namespace tandem::client
