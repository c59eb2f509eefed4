#include "client/picture/scene_picture.h"

#include <algorithm>
#include <utility>

#include "assets/base/assert.h"
#include "assets/base/fnv1a.h"

namespace tandem::client {
namespace {

constexpr int kSamples = 4;
constexpr std::uint32_t kFramesToRest =
    20;  // a part that has stood still for fewer frames stays out of the layer

void add(Fnv1a& hash, const Pose& pose) {
  hash.addComponents(pose.position);
  hash.addComponents(pose.orientation);
}

void add(Fnv1a& hash, const PartLook& look) {
  for (const float value : {look.alpha, look.tintAmount, look.rimAmount, look.edgeWidth}) hash.add(value);
  hash.addComponents(look.tint);
  hash.addComponents(look.edgeColour);
}

bool same(const Pose& a, const Pose& b) { return a.position == b.position && a.orientation == b.orientation; }

void copy(const GlTarget& from, const GlTarget& to, GLbitfield what) {
  const glm::ivec2 size = from.size();
  ASSERT(to.size() == size);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, from.framebuffer());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, to.framebuffer());
  glBlitFramebuffer(0, 0, size.x, size.y, 0, 0, size.x, size.y, what, GL_NEAREST);
}

}  // namespace

void ScenePicture::sortParts(const Content& content) {
  const std::size_t count = content.worldFromPart.size();
  ASSERT(content.looks.size() == count);
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

std::uint64_t ScenePicture::hashOfLayer(const Content& content, const glm::ivec2& size,
                                        const SceneRenderer& parts) const {
  Fnv1a hash;
  hash.add(parts.detailVersion());
  for (const document::SectionPlane& section : parts.sections()) {
    hash.addComponents(section.point);
    hash.addComponents(section.normal);
  }
  add(hash, content.view.worldFromEye);
  hash.addComponents(content.view.size);
  hash.add(content.view.near);
  hash.add(content.view.far);
  hash.addComponents(size);
  hash.add(content.edges);
  for (const PartId part : resting_) {
    hash.add(part);
    add(hash, content.worldFromPart[part]);
    add(hash, content.looks[part]);
  }
  return hash.value();
}

std::uint64_t ScenePicture::hashOfRest(const Content& content) const {
  Fnv1a hash;
  for (const PartId part : moving_) {
    hash.add(part);
    add(hash, content.worldFromPart[part]);
    add(hash, content.looks[part]);
  }
  hash.add(content.again);
  for (const Pose& pose : content.worldFromAgain) add(hash, pose);
  add(hash, content.lookAgain);
  for (const GlyphBatch::Vertex& vertex : content.glyphs.triangles()) {
    hash.addComponents(vertex.position);
    hash.addComponents(vertex.colour);
  }
  return hash.value();
}

void ScenePicture::drawResting(const Content& content, const SceneRenderer& parts,
                               const GlTarget& target) const {
  target.bind();
  glDepthMask(GL_TRUE);
  glClear(GL_DEPTH_BUFFER_BIT);
  parts.drawBackground(content.background);
  parts.draw(content.view, content.worldFromPart, content.looks, resting_, content.edges);
}

void ScenePicture::drawAgain(const Content& content, const SceneRenderer& parts) {
  if (content.again >= content.worldFromPart.size() || content.worldFromAgain.empty()) return;
  posesAgain_.assign(content.worldFromPart.begin(), content.worldFromPart.end());
  looksAgain_.assign(content.looks.begin(), content.looks.end());
  looksAgain_[content.again] = content.lookAgain;
  for (const Pose& pose : content.worldFromAgain) {
    posesAgain_[content.again] = pose;
    parts.draw(content.view, posesAgain_, looksAgain_, {&content.again, 1}, content.edges);
  }
}

void ScenePicture::update(const Content& content, const glm::ivec2& size, const SceneRenderer& parts,
                          const GlyphRenderer& glyphs) {
  sortParts(content);
  const std::uint64_t layer = hashOfLayer(content, size, parts), rest = hashOfRest(content);
  if (layer == lastLayer_ && rest == lastRest_) return;
  layer_.resize(size, kSamples, GL_RGBA8);
  multisampled_.resize(size, kSamples, GL_RGBA8);
  resolved_.resize(size, 0, GL_RGBA8);
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_CULL_FACE);
  glEnable(GL_MULTISAMPLE);
  glDepthFunc(GL_LESS);
  // A layer that changes in each picture, as while the camera turns, is of use to no other: it is not kept.
  const bool changed = std::exchange(layerChanges_, layer != lastLayer_);
  if (layerChanges_) layerKept_ = false;
  if (layerChanges_ && changed) {
    drawResting(content, parts, multisampled_);
  } else {
    if (!std::exchange(layerKept_, true)) drawResting(content, parts, layer_);
    copy(layer_, multisampled_, GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    multisampled_.bind();
  }
  parts.draw(content.view, content.worldFromPart, content.looks, moving_, content.edges);
  drawAgain(content, parts);
  glyphs.draw(content.glyphs);
  copy(multisampled_, resolved_, GL_COLOR_BUFFER_BIT);
  lastLayer_ = layer;
  lastRest_ = rest;
}

void ScenePicture::show(unsigned framebuffer, const glm::ivec2& corner) const {
  const glm::ivec2 size = resolved_.size();
  ASSERT(size.x > 0 && size.y > 0);  // update() comes first
  glBindFramebuffer(GL_READ_FRAMEBUFFER, resolved_.framebuffer());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
  glBlitFramebuffer(0, 0, size.x, size.y, corner.x, corner.y, corner.x + size.x, corner.y + size.y,
                    GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

}  // namespace tandem::client
