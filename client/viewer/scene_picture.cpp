#include "client/viewer/scene_picture.h"

#include <algorithm>
#include <cstring>
#include <type_traits>

namespace tandem::client {
namespace {

constexpr int kSamples = 4;
constexpr std::uint32_t kFramesToRest = 20;  // a part that pauses for less stays out of the layer

/// A number that differs when the values given to it differ (FNV-1a over their bytes).
class Fingerprint {
 public:
  template <typename T>
  void add(const T& value) {
    static_assert(std::has_unique_object_representations_v<T> || std::is_floating_point_v<T>);
    unsigned char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    for (const unsigned char byte : bytes) hash_ = (hash_ ^ byte) * 1099511628211ull;
  }
  template <typename T>
  void addVector(const T& v) {
    for (int i = 0; i < T::length(); ++i) add(v[i]);
  }
  void add(const Pose& pose) {
    addVector(pose.position);
    addVector(pose.orientation);
  }
  void add(const PartLook& look) {
    for (const float value : {look.alpha, look.tintAmount, look.rimAmount, look.edgeWidth}) add(value);
    addVector(look.tint);
    addVector(look.edgeColour);
  }
  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 14695981039346656037ull;
};

bool same(const Pose& a, const Pose& b) { return a.position == b.position && a.orientation == b.orientation; }

void copy(const GlTarget& from, const GlTarget& to, GLbitfield what) {
  const glm::ivec2 size = from.size();
  glBindFramebuffer(GL_READ_FRAMEBUFFER, from.framebuffer());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, to.framebuffer());
  glBlitFramebuffer(0, 0, size.x, size.y, 0, 0, size.x, size.y, what, GL_NEAREST);
}

}  // namespace

void ScenePicture::sortParts(const Content& content) {
  const std::size_t count = content.worldFromPart.size();
  lastPose_.resize(count);
  framesAtRest_.resize(count, kFramesToRest);
  resting_.clear();
  moving_.clear();
  for (std::size_t p = 0; p < count; ++p) {
    const Pose& pose = content.worldFromPart[p];
    const bool first = lastLayer_ == 0;
    framesAtRest_[p] = first || same(pose, lastPose_[p]) ? std::min(framesAtRest_[p] + 1, kFramesToRest) : 0;
    lastPose_[p] = pose;
    if (!content.looks[p].visible) continue;
    const bool rests = framesAtRest_[p] >= kFramesToRest && content.looks[p].alpha >= 1.0f;
    (rests ? resting_ : moving_).push_back(static_cast<PartId>(p));
  }
}

std::uint64_t ScenePicture::printOfLayer(const Content& content, const glm::ivec2& size) const {
  Fingerprint print;
  print.add(content.view.worldFromEye);
  print.addVector(content.view.size);
  print.add(content.view.near);
  print.add(content.view.far);
  print.addVector(size);
  print.add(content.edges);
  for (const PartId part : resting_) {
    print.add(part);
    print.add(content.worldFromPart[part]);
    print.add(content.looks[part]);
  }
  return print.value();
}

std::uint64_t ScenePicture::printOfRest(const Content& content) const {
  Fingerprint print;
  for (const PartId part : moving_) {
    print.add(part);
    print.add(content.worldFromPart[part]);
    print.add(content.looks[part]);
  }
  for (const GlyphBatch::Vertex& vertex : content.glyphs.triangles()) {
    print.addVector(vertex.position);
    print.addVector(vertex.colour);
  }
  return print.value();
}

void ScenePicture::drawLayer(const Content& content, const SceneRenderer& parts) const {
  layer_.bind();
  glDepthMask(GL_TRUE);
  glClear(GL_DEPTH_BUFFER_BIT);
  parts.drawBackground(content.background);
  parts.draw(content.view, content.worldFromPart, content.looks, resting_, content.edges);
}

void ScenePicture::update(const Content& content, const glm::ivec2& size, const SceneRenderer& parts,
                          const GlyphRenderer& glyphs) {
  sortParts(content);
  const std::uint64_t layer = printOfLayer(content, size), rest = printOfRest(content);
  if (layer == lastLayer_ && rest == lastRest_) return;
  layer_.resize(size, kSamples, GL_RGBA8);
  multisampled_.resize(size, kSamples, GL_RGBA8);
  resolved_.resize(size, 0, GL_RGBA8);
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_CULL_FACE);
  glEnable(GL_MULTISAMPLE);
  glDepthFunc(GL_LESS);
  if (layer != lastLayer_) drawLayer(content, parts);
  copy(layer_, multisampled_, GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  multisampled_.bind();
  parts.draw(content.view, content.worldFromPart, content.looks, moving_, content.edges);
  glyphs.draw(content.glyphs);
  copy(multisampled_, resolved_, GL_COLOR_BUFFER_BIT);
  lastLayer_ = layer;
  lastRest_ = rest;
}

void ScenePicture::show(unsigned framebuffer, const glm::ivec2& corner) const {
  const glm::ivec2 size = resolved_.size();
  glBindFramebuffer(GL_READ_FRAMEBUFFER, resolved_.framebuffer());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
  glBlitFramebuffer(0, 0, size.x, size.y, corner.x, corner.y, corner.x + size.x, corner.y + size.y,
                    GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

}  // namespace tandem::client
