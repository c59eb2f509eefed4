#include "client/picture/scene_renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtx/quaternion.hpp>

#include "assets/base/assert.h"
#include "client/picture/shaders.h"

namespace tandem::client {
namespace {

constexpr double kHair = 1e-5;        // of the size of the scene
constexpr double kLinePull = 1.2e-3;  // share of the distance by which edges stand before their surfaces
constexpr double kEdgesFrom = 14.0;   // pixels across a part below which its edges are not drawn
constexpr double kEdgesFull = 90.0;   // pixels from which on they are fully dark
constexpr float kFaint = 0.15f;       // opacity of a part below which its edges are no stronger
constexpr float kEdgeOpacity = 0.62f;
constexpr glm::vec3 kThinEdgeColour(0.10f, 0.12f, 0.15f);

glm::mat4 matrixOf(const Pose& pose) {
  glm::dmat4 m = glm::mat4_cast(pose.orientation);
  m[3] = glm::dvec4(pose.position, 1.0);
  return glm::mat4(m);
}

bool hasVolume(const assets::Bounds& bounds) {
  return bounds.min.x <= bounds.max.x && bounds.min.y <= bounds.max.y && bounds.min.z <= bounds.max.z;
}

Sphere sphereAround(const assets::Bounds& bounds) {
  if (!hasVolume(bounds)) return {};
  return {0.5 * (bounds.min + bounds.max), 0.5 * glm::length(bounds.max - bounds.min)};
}

void append(RenderMesh& to, const RenderMesh& from) {
  const auto firstVertex = static_cast<std::uint32_t>(to.vertices.size());
  const auto firstIndex = static_cast<std::uint32_t>(to.indices.size());
  to.vertices.insert(to.vertices.end(), from.vertices.begin(), from.vertices.end());
  for (const std::uint32_t index : from.indices) to.indices.push_back(firstVertex + index);
  for (RenderRange range : from.ranges) {
    range.firstIndex += firstIndex;
    to.ranges.push_back(range);
  }
  for (RenderCluster cluster : from.clusters) {
    cluster.firstIndex += firstIndex;
    to.clusters.push_back(cluster);
  }
  to.featureEdges.insert(to.featureEdges.end(), from.featureEdges.begin(), from.featureEdges.end());
}

/// The part of the projection that maps one pixel onto the whole of a 1 x 1 target.
glm::dmat4 pickProjection(const View& view, const glm::dvec2& pixel) {
  const glm::dvec2 centre(2.0 * pixel.x / view.size.x - 1.0, 1.0 - 2.0 * pixel.y / view.size.y);
  const glm::dmat4 scale = glm::scale(glm::dmat4(1.0), glm::dvec3(view.size, 1.0));
  return scale * glm::translate(glm::dmat4(1.0), glm::dvec3(-centre, 0.0)) * view.eyeToClip;
}

double depthFromBuffer(const View& view, double value) {
  const double ndc = 2.0 * value - 1.0;
  return 2.0 * view.near * view.far / (view.far + view.near - ndc * (view.far - view.near));
}

}  // namespace

Result<SceneRenderer::Programs> SceneRenderer::makePrograms(const char* sections) {
  const std::string version = "#version 330 core\n", vertex = version + sections;
  auto part = GlProgram::make("part", vertex + shaders::kPartVertex,
                              version + shaders::kLighting + shaders::kPartFragment);
  if (!part) return part.error();
  auto thin = GlProgram::make("thin line", vertex + shaders::kThinLineVertex, shaders::kFlatFragment);
  if (!thin) return thin.error();
  auto wide = GlProgram::make("line", vertex + shaders::kLineVertex, shaders::kFlatFragment);
  if (!wide) return wide.error();
  auto pick = GlProgram::make("pick", vertex + shaders::kPartVertex, shaders::kPickFragment);
  if (!pick) return pick.error();
  return Programs{std::move(*part), std::move(*thin), std::move(*wide), std::move(*pick)};
}

Result<std::unique_ptr<SceneRenderer>> SceneRenderer::make(const assets::Scene& scene, const Detail& detail) {
  auto background = GlProgram::make("background", shaders::kBackgroundVertex, shaders::kBackgroundFragment);
  if (!background) return background.error();
  auto whole = makePrograms(shaders::kNoSections);
  if (!whole) return whole.error();
  auto cut = makePrograms(shaders::kSections);
  if (!cut) return cut.error();
  return std::unique_ptr<SceneRenderer>(
      new SceneRenderer(scene, detail, std::move(*background), std::move(*whole), std::move(*cut)));
}

SceneRenderer::SceneRenderer(const assets::Scene& scene, const Detail& detail, GlProgram background,
                             Programs whole, Programs cut)
    : scene_(scene),
      background_(std::move(background)),
      whole_(std::move(whole)),
      cut_(std::move(cut)),
      meshes_(scene.meshes.size()),
      levels_(DrawnLevels::of(scene, detail)) {
  if (levels_) runs_.resize(scene.meshes.size());
  for (std::uint32_t m = 0; m < scene.meshes.size(); ++m) {
    DrawnMesh& mesh = meshes_[m];
    if (!levels_ || !levels_->has(m)) mesh.gpu = upload(makeRenderMesh(scene.meshes[m]));
    for (const glm::dvec3& p : scene.meshes[m].positions) mesh.bounds.include(glm::dvec3(glm::vec3(p)));
    mesh.sphere = sphereAround(mesh.bounds);
    mesh.closed = scene.meshes[m].closed;
  }
  const double extent =
      hasVolume(scene.bounds) ? 2.0 * glm::length(scene.bounds.max - scene.bounds.min) : 1.0;
  meshOfPart_.reserve(scene.parts.size());
  for (const assets::Part& part : scene.parts) {
    meshOfPart_.push_back(part.mesh);
    if (part.mesh == assets::kNone && !part.shapes.empty()) addShapes(part, extent);
  }
  const std::vector<RenderVertex> corners{
      {{-1, -1, 0}, {0, 0, 1}}, {{1, -1, 0}, {0, 0, 1}}, {{-1, 1, 0}, {0, 0, 1}}, {{1, 1, 0}, {0, 0, 1}}};
  glBindVertexArray(cap_.id());
  fill(capVertices_, GL_ARRAY_BUFFER, corners);
  floatAttribute(0, 3, sizeof(RenderVertex), offsetof(RenderVertex, position));
  floatAttribute(1, 3, sizeof(RenderVertex), offsetof(RenderVertex, normal));
  glBindVertexArray(0);
  pickTarget_.resize({1, 1}, 0, GL_RGBA8);
}

/// What is drawn of a part that has only implicit shapes.
void SceneRenderer::addShapes(const assets::Part& part, double extent) {
  RenderMesh merged;
  for (const assets::ImplicitShape& shape : part.shapes) append(merged, makeRenderMesh(shape, extent));
  meshOfPart_.back() = static_cast<std::uint32_t>(meshes_.size());
  DrawnMesh& mesh = meshes_.emplace_back();
  mesh.gpu = upload(merged);
  for (const RenderVertex& vertex : merged.vertices) mesh.bounds.include(glm::dvec3(vertex.position));
  mesh.sphere = sphereAround(mesh.bounds);
  mesh.closed = std::none_of(part.shapes.begin(), part.shapes.end(), [](const auto& shape) {
    return shape.kind == assets::ImplicitShape::Kind::plane;
  });
}

void SceneRenderer::receive() {
  if (levels_ && levels_->receive()) ++detailVersion_;
}

double SceneRenderer::pixelsOff() const {
  double most = 0.0;
  for (std::size_t p = 0; levels_ && p < meshOfPart_.size(); ++p)
    if (levels_->has(meshOfPart_[p])) most = std::max(most, levels_->pixelsOff(static_cast<PartId>(p)));
  return most;
}

const SceneRenderer::DrawnMesh* SceneRenderer::meshOf(PartId part) const {
  ASSERT(part < meshOfPart_.size());
  const std::uint32_t index = meshOfPart_[part];
  return index < meshes_.size() ? &meshes_[index] : nullptr;
}

bool SceneRenderer::isCut(const Sphere& sphere) const {
  return std::any_of(sections_.begin(), sections_.end(), [&](const document::SectionPlane& section) {
    return std::abs(glm::dot(section.normal, sphere.centre - section.point)) <= sphere.radius;
  });
}

const GpuMesh& SceneRenderer::choose(const View& view, PartId part, const Sphere& sphere) const {
  if (!drawnByLevels(part)) return meshOf(part)->gpu;
  // Off the middle of a picture, what is off along the line of sight is seen too.
  const double tanY = std::tan(0.5 * view.camera.fieldOfView), tanX = tanY * view.size.x / view.size.y;
  const double depth = std::max(view.depthOf(sphere.centre) - sphere.radius, view.near);
  const double pixel = view.metresPerPixel(depth) / std::sqrt(1.0 + tanX * tanX + tanY * tanY);
  return levels_->meshFor(part, meshOfPart_[part], pixel, isCut(sphere));
}

Sphere SceneRenderer::worldSphere(PartId part, const Pose& worldFromPart) const {
  const DrawnMesh* mesh = meshOf(part);
  if (!mesh) return {worldFromPart.position, 0.0};
  return {transformPoint(worldFromPart, mesh->sphere.centre), mesh->sphere.radius};
}

assets::Bounds SceneRenderer::bounds(std::span<const Pose> worldFromPart,
                                     std::span<const PartId> parts) const {
  assets::Bounds box;
  for (const PartId part : parts) {
    const DrawnMesh* mesh = part < meshOfPart_.size() ? meshOf(part) : nullptr;
    if (!mesh || !hasVolume(mesh->bounds)) continue;
    for (int corner = 0; corner < 8; ++corner) {
      const auto& b = mesh->bounds;
      const glm::dvec3 point((corner & 1) ? b.max.x : b.min.x, (corner & 2) ? b.max.y : b.min.y,
                             (corner & 4) ? b.max.z : b.min.z);
      box.include(transformPoint(worldFromPart[part], point));
    }
  }
  return box;
}

double SceneRenderer::reachFrom(const glm::dvec3& centre, std::span<const Pose> worldFromPart) const {
  double reach = 0.0;
  for (std::size_t p = 0; p < worldFromPart.size(); ++p) {
    const Sphere sphere = worldSphere(static_cast<PartId>(p), worldFromPart[p]);
    reach = std::max(reach, glm::length(sphere.centre - centre) + sphere.radius);
  }
  return reach;
}

/// Notes what holds all parts, for the covers of cuts.
void SceneRenderer::lookAround(std::span<const Pose> worldFromPart) const {
  if (sections_.empty()) return;
  around_.centre = 0.5 * (scene_.bounds.min + scene_.bounds.max);
  around_.radius = reachFrom(around_.centre, worldFromPart);
}

bool SceneRenderer::inView(const View& view, const Sphere& sphere) const {
  const glm::dvec3 eye = transformPoint(view.eyeFromWorld, sphere.centre);
  const double depth = -eye.z;
  if (depth < view.near - sphere.radius || depth > view.far + sphere.radius) return false;
  const double tanY = std::tan(0.5 * view.camera.fieldOfView), tanX = tanY * view.size.x / view.size.y;
  const double marginX = sphere.radius * std::hypot(1.0, tanX),
               marginY = sphere.radius * std::hypot(1.0, tanY);
  return std::abs(eye.x) <= depth * tanX + marginX && std::abs(eye.y) <= depth * tanY + marginY;
}

void SceneRenderer::drawBackground(const Background& background) const {
  glDisable(GL_DEPTH_TEST);
  background_.use();
  background_.set("top", background.top);
  background_.set("bottom", background.bottom);
  glBindVertexArray(empty_.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glEnable(GL_DEPTH_TEST);
}

void SceneRenderer::draw(const View& view, std::span<const Pose> worldFromPart,
                         std::span<const PartLook> looks, std::span<const PartId> parts, bool edges) const {
  lookAround(worldFromPart);
  ASSERT(looks.size() == worldFromPart.size() && looks.size() == meshOfPart_.size());
  struct Drawn {
    PartId part;
    const GpuMesh* mesh;
    double order;  // along the line of sight, furthest first
  };
  std::vector<Drawn> transparent, opaque;
  for (const PartId part : parts) {
    if (!meshOf(part)) continue;
    const Sphere sphere = worldSphere(part, worldFromPart[part]);
    if (!looks[part].visible || !inView(view, sphere)) {
      if (drawnByLevels(part)) levels_->notShown(part);
      continue;
    }
    const Drawn drawn{part, &choose(view, part, sphere), -view.depthOf(sphere.centre)};
    (looks[part].alpha < 1.0f ? transparent : opaque).push_back(drawn);
  }
  std::stable_sort(transparent.begin(), transparent.end(),
                   [](const Drawn& a, const Drawn& b) { return a.order < b.order; });

  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  const glm::vec3 up(view.eyeFromWorld.orientation * glm::dvec3(0.0, 1.0, 0.0));
  for (const GlProgram* program : {&programs().part, &programs().thinLine, &programs().wideLine}) {
    program->use();
    program->set("clipFromEye", glm::mat4(view.eyeToClip));
    setPlanes(*program, view);
  }
  programs().part.use();
  programs().part.set("upInEye", up);
  useCut(Cut::all);
  for (const Drawn& d : opaque) drawSurface(view, d.part, *d.mesh, worldFromPart[d.part], looks[d.part]);
  glEnable(GL_BLEND);
  if (edges)
    for (const Drawn& d : opaque) drawEdges(view, d.part, *d.mesh, worldFromPart[d.part], looks[d.part]);
  glDepthMask(GL_FALSE);
  for (const Drawn& d : transparent) {
    drawSurface(view, d.part, *d.mesh, worldFromPart[d.part], looks[d.part]);
    if (edges) drawEdges(view, d.part, *d.mesh, worldFromPart[d.part], looks[d.part]);
  }
  glDepthMask(GL_TRUE);
  useCut(Cut::none);
  glDisable(GL_BLEND);
  glBindVertexArray(0);
}

void SceneRenderer::setSections(std::span<const document::SectionPlane> sections) {
  ASSERT(sections.size() <= document::kMaxSections);
  sections_.assign(sections.begin(), sections.end());
  for (document::SectionPlane& section : sections_) section.normal = glm::normalize(section.normal);
}

void SceneRenderer::setPlanes(const GlProgram& program, const View& view) const {
  for (std::size_t i = 0; i < sections_.size(); ++i) {
    const glm::dvec3 kept = -(view.eyeFromWorld.orientation * sections_[i].normal);
    const glm::dvec3 point = transformPoint(view.eyeFromWorld, sections_[i].point);
    const std::string name = "sections[" + std::to_string(i) + "]";
    program.set(name.c_str(), glm::vec4(glm::dvec4(kept, -glm::dot(kept, point))));
  }
}

void SceneRenderer::useCut(Cut cut, std::size_t one) const {
  for (std::size_t i = 0; i < sections_.size(); ++i) {
    const bool on = cut == Cut::all || (cut == Cut::one && i == one) || (cut == Cut::allButOne && i != one);
    (on ? glEnable : glDisable)(GL_CLIP_DISTANCE0 + static_cast<GLenum>(i));
  }
}

// Behind a plane that the eye stands in front of, a ray leaves a closed mesh once more than it enters it
// exactly where it meets the plane inside the mesh: the stencil counts that.
template <typename DrawMesh>
void SceneRenderer::drawCaps(const View& view, const GlProgram& program, PartId part,
                             const Pose& worldFromPart, DrawMesh drawMesh) const {
  if (!meshOf(part)->closed) return;
  const Sphere sphere = worldSphere(part, worldFromPart);
  for (std::size_t i = 0; i < sections_.size(); ++i) {
    const document::SectionPlane& section = sections_[i];
    const double eyeInFront = glm::dot(section.normal, view.worldFromEye.position - section.point);
    // Seen from behind, a cap is hidden by the part itself.
    if (eyeInFront <= 0.0) continue;
    if (std::abs(glm::dot(section.normal, sphere.centre - section.point)) > sphere.radius) continue;

    glEnable(GL_STENCIL_TEST);
    glClear(GL_STENCIL_BUFFER_BIT);
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    glDisable(GL_DEPTH_TEST);
    glStencilFunc(GL_ALWAYS, 0, 0xff);
    glStencilOpSeparate(GL_FRONT, GL_KEEP, GL_KEEP, GL_DECR_WRAP);
    glStencilOpSeparate(GL_BACK, GL_KEEP, GL_KEEP, GL_INCR_WRAP);
    useCut(Cut::one, i);
    drawMesh();

    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glEnable(GL_DEPTH_TEST);
    glStencilFunc(GL_NOTEQUAL, 0, 0xff);
    glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
    useCut(Cut::allButOne, i);
    // One square for all parts, so that the depths of their caps do not compete. It reaches no further than
    // the parts: a rasteriser loses its precision on a square that passes behind the eye.
    // It stands behind the plane by a hair, which no rasteriser may cut away.
    const double height = glm::dot(section.normal, around_.centre - section.point) + kHair * around_.radius;
    const glm::dvec3 foot = around_.centre - height * section.normal;
    const Pose worldFromCap{foot, glm::rotation(glm::dvec3(0.0, 0.0, 1.0), section.normal)};
    program.set("eyeFromPart", matrixOf(view.eyeFromWorld * worldFromCap) *
                                   glm::mat4(glm::scale(glm::dmat4(1.0), glm::dvec3(around_.radius))));
    glBindVertexArray(cap_.id());
    glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
    glDisable(GL_STENCIL_TEST);
    useCut(Cut::all);
  }
}

template <typename Test>
void SceneRenderer::drawClusters(const GpuMesh& mesh, std::uint32_t first, std::uint32_t count,
                                 const Pose& worldFromPart, Test visible) {
  std::uint32_t runStart = first, runCount = 0;
  const auto flush = [&] {
    if (runCount == 0) return;
    const std::uintptr_t offset = std::uintptr_t{runStart} * sizeof(std::uint32_t);
    glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(runCount), GL_UNSIGNED_INT,
                   reinterpret_cast<const void*>(offset));
    runCount = 0;
  };
  auto cluster =
      std::lower_bound(mesh.clusters.begin(), mesh.clusters.end(), first,
                       [](const RenderCluster& c, std::uint32_t index) { return c.firstIndex < index; });
  for (; cluster != mesh.clusters.end() && cluster->firstIndex < first + count; ++cluster) {
    const Sphere sphere{transformPoint(worldFromPart, glm::dvec3(cluster->centre)),
                        static_cast<double>(cluster->radius) * 1.001};
    if (!visible(sphere)) {
      flush();
      continue;
    }
    if (runCount == 0) runStart = cluster->firstIndex;
    runCount += cluster->indexCount;
  }
  flush();
}

bool SceneRenderer::hidesBacks(const View& view, PartId part, const GpuMesh& mesh,
                               const Pose& worldFromPart) const {
  if (!mesh.facesOutward || !sections_.empty()) return false;
  const Sphere sphere = worldSphere(part, worldFromPart);
  return view.depthOf(sphere.centre) - sphere.radius > view.near;
}

void SceneRenderer::drawSurface(const View& view, PartId part, const GpuMesh& mesh, const Pose& worldFromPart,
                                const PartLook& look) const {
  const GlProgram& program = programs().part;
  program.use();
  program.set("tint", look.tint);
  program.set("tintAmount", look.tintAmount);
  program.set("rimAmount", look.rimAmount);
  const auto dress = [&](const RenderRange& range) {
    const assets::Material& material =
        scene_.materials[std::min<std::size_t>(range.material, scene_.materials.size() - 1)];
    const auto& c = material.baseColour;
    program.set("baseColour", glm::vec4(c[0], c[1], c[2], look.alpha));
    program.set("metallic", material.metallic);
    program.set("roughness", std::max(material.roughness, 0.2f));
  };
  // Back-face culling: a software renderer sets up every triangle, even where a nearer one hides it.
  const bool skipsBacks = hidesBacks(view, part, mesh, worldFromPart) && look.alpha >= 1.0f;
  if (skipsBacks) glEnable(GL_CULL_FACE);
  const RenderRange* largest = nullptr;
  const auto drawMesh = [&](auto&& before) {
    program.set("eyeFromPart", matrixOf(view.eyeFromWorld * worldFromPart));
    glBindVertexArray(mesh.surface.id());
    for (const RenderRange& range : mesh.ranges) {
      before(range);
      drawClusters(mesh, range.firstIndex, range.indexCount, worldFromPart,
                   [&](const Sphere& sphere) { return mesh.clusters.size() < 4 || inView(view, sphere); });
    }
  };
  drawMesh([&](const RenderRange& range) {
    dress(range);
    if (largest == nullptr || range.indexCount > largest->indexCount) largest = &range;
  });
  glDisable(GL_CULL_FACE);
  if (sections_.empty() || largest == nullptr) return;
  dress(*largest);
  drawCaps(view, program, part, worldFromPart, [&] { drawMesh([](const RenderRange&) {}); });
}

void SceneRenderer::drawEdges(const View& view, PartId part, const GpuMesh& mesh, const Pose& worldFromPart,
                              const PartLook& look) const {
  if (mesh.edgeCount == 0) return;
  const Sphere sphere = worldSphere(part, worldFromPart);
  const double depth = std::max(view.depthOf(sphere.centre), view.near);
  const double across = 2.0 * sphere.radius / view.metresPerPixel(depth);
  const bool wide = look.edgeWidth > 0.0f;
  const auto fade =
      static_cast<float>(std::clamp((across - kEdgesFrom) / (kEdgesFull - kEdgesFrom), 0.0, 1.0));
  if (!wide && fade <= 0.0f) return;
  const GlProgram& program = wide ? programs().wideLine : programs().thinLine;
  program.use();
  program.set("eyeFromPart", matrixOf(view.eyeFromWorld * worldFromPart));
  program.set("pull", static_cast<float>(kLinePull));
  const float opacity = look.alpha < kFaint ? look.alpha : std::max(look.alpha, 0.5f);
  if (wide) {
    program.set("viewport", glm::vec2(view.size));
    program.set("width", look.edgeWidth);
    program.set("nearPlane", static_cast<float>(view.near));
    program.set("flatColour", glm::vec4(look.edgeColour, opacity));
    glBindVertexArray(mesh.wideEdges.id());
    glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, mesh.edgeCount);
  } else {
    program.set("flatColour", glm::vec4(kThinEdgeColour, kEdgeOpacity * fade * opacity));
    glBindVertexArray(mesh.thinEdges.id());
    glDrawArrays(GL_LINES, 0, 2 * mesh.edgeCount);
  }
}

template <typename Test>
GLsizei SceneRenderer::gatherExact(std::uint32_t mesh, const Pose& worldFromPart, Test meetsRay) {
  if (!runs_[mesh]) runs_[mesh] = std::make_unique<TriangleRuns>(scene_.meshes[mesh]);
  std::vector<glm::vec3> corners;
  runs_[mesh]->gather(
      [&](const RenderCluster& run) {
        return meetsRay(Sphere{transformPoint(worldFromPart, glm::dvec3(run.centre)),
                               static_cast<double>(run.radius) * 1.001});
      },
      corners);
  glBindVertexArray(pickTriangles_.id());
  fill(pickCorners_, GL_ARRAY_BUFFER, corners, GL_STREAM_DRAW);
  floatAttribute(0, 3, sizeof(glm::vec3), 0);
  return static_cast<GLsizei>(corners.size());
}

std::optional<Hit> SceneRenderer::pick(const View& view, const glm::dvec2& pixel,
                                       std::span<const Pose> worldFromPart, std::span<const PartLook> looks) {
  ASSERT(looks.size() == worldFromPart.size() && looks.size() == meshOfPart_.size());
  lookAround(worldFromPart);
  const glm::dvec3 direction = glm::normalize(view.pointAt(pixel, 1.0) - view.worldFromEye.position);
  const double pixelAtFar = view.metresPerPixel(view.far);  // the target's pixel is a thin pyramid, not a ray
  const auto meetsRay = [&](const Sphere& sphere) {
    const glm::dvec3 toCentre = sphere.centre - view.worldFromEye.position;
    return glm::length(glm::cross(toCentre, direction)) <= sphere.radius + pixelAtFar;
  };
  pickTarget_.bind();
  glEnable(GL_DEPTH_TEST);
  glClearColor(0.0f, 0.0f, 0.0f, 0.0f);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  const GlProgram& program = programs().pick;
  program.use();
  program.set("clipFromEye", glm::mat4(pickProjection(view, pixel)));
  setPlanes(program, view);
  useCut(Cut::all);
  for (std::size_t p = 0; p < worldFromPart.size(); ++p) {
    const auto part = static_cast<PartId>(p);
    const DrawnMesh* mesh = meshOf(part);
    if (!mesh || !looks[p].visible || !looks[p].pickable) continue;
    const Sphere sphere = worldSphere(part, worldFromPart[p]);
    if (!meetsRay(sphere) || !inView(view, sphere)) continue;
    program.set("partIndex", static_cast<float>(p));
    const bool exact = drawnByLevels(part);
    const GLsizei corners = exact ? gatherExact(meshOfPart_[p], worldFromPart[p], meetsRay) : 0;
    const auto drawMesh = [&] {
      program.set("eyeFromPart", matrixOf(view.eyeFromWorld * worldFromPart[p]));
      glBindVertexArray(exact ? pickTriangles_.id() : mesh->gpu.surface.id());
      if (exact) glDrawArrays(GL_TRIANGLES, 0, corners);
      for (const RenderRange& range : mesh->gpu.ranges)
        drawClusters(mesh->gpu, range.firstIndex, range.indexCount, worldFromPart[p], meetsRay);
    };
    drawMesh();
    drawCaps(view, program, part, worldFromPart[p], drawMesh);
  }
  useCut(Cut::none);
  glBindVertexArray(0);
  std::array<std::uint8_t, 4> colour{};
  float depth = 1.0f;
  glReadPixels(0, 0, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, colour.data());
  glReadPixels(0, 0, 1, 1, GL_DEPTH_COMPONENT, GL_FLOAT, &depth);
  if (colour[3] == 0) return std::nullopt;
  Hit hit;
  hit.part = static_cast<PartId>(colour[0] + 256 * colour[1]);
  ASSERT(hit.part < worldFromPart.size());
  hit.depth = depthFromBuffer(view, depth);
  hit.point = view.pointAt(pixel, hit.depth);
  return hit;
}

}  // namespace tandem::client
