#include "client/viewer/viewer.h"

#include <epoxy/gl.h>

#include <GLFW/glfw3.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <utility>

#include "assets/base/assert.h"
#include "client/marks/exploded_scene.h"
#include "client/marks/hand_glyphs.h"
#include "client/marks/note_list.h"
#include "client/marks/verdict_list.h"
#include "client/marks/way_out_picture.h"
#include "client/picture/colours.h"
#include "client/picture/field_glyphs.h"
#include "client/picture/glyphs.h"
#include "client/picture/png.h"
#include "client/picture/scene_picture.h"
#include "client/picture/scene_renderer.h"
#include "client/viewer/camera_drag.h"
#include "client/viewer/imgui_interface.h"
#include "client/viewer/panels.h"
#include "client/viewer/section_handles.h"
#include "client/viewer/stylus_control.h"
#include "client/viewer/surface.h"

namespace tandem::client {
namespace {

constexpr std::size_t kPosesOnWay = 5;  // at which a part is drawn on its way out

class SceneViewer final : public Viewer {
 public:
  static Result<std::unique_ptr<Viewer>> make(const assets::Scene& scene, const ViewerOptions& options,
                                              std::unique_ptr<Surface> surface) {
    surface->makeCurrent();
    auto parts = SceneRenderer::make(scene, {options.levels, options.cacheDirectory});
    if (!parts) return parts.error();
    auto glyphs = GlyphRenderer::make();
    if (!glyphs) return glyphs.error();
    return std::unique_ptr<Viewer>(
        new SceneViewer(scene, options, std::move(surface), std::move(*parts), std::move(*glyphs)));
  }

  ~SceneViewer() override { surface_->makeCurrent(); }

  ViewActions frame(const ViewModel& model) override;
  double pixelsOff() const override { return renderer_->pixelsOff(); }
  Status screenshot(const std::string& path) override;
  Camera& camera() override { return camera_; }
  UiState& ui() override { return ui_; }
  void pressKey(int key) override { queuedKeys_.push_back(key); }
  void pointMouse(const glm::dvec2& cursor, bool leftDown) override {
    surface_->pointMouse(cursor, leftDown);
  }
  void openClashes(const ClashQuestion& question) override {
    ui_.clashes = {};
    ui_.clashes.question = question;
    ui_.clashes.open = ui_.clashes.choosesFirst = true;
  }
  void openNotes() override { ui_.notes.wanted = ui_.notes.choosesFirst = true; }
  void openMeasures() override { ui_.measures.open = true; }
  void fitAll() override { ui_.fit = std::vector<PartId>{}; }

 private:
  SceneViewer(const assets::Scene& scene, const ViewerOptions& options, std::unique_ptr<Surface> surface,
              std::unique_ptr<SceneRenderer> parts, std::unique_ptr<GlyphRenderer> glyphs)
      : options_(options),
        surface_(std::move(surface)),
        renderer_(std::move(parts)),
        glyphs_(std::move(glyphs)),
        interface_(std::make_unique<Interface>(*surface_)),
        tree_(scene),
        ui_(scene.parts.size()),
        sceneBounds_(scene.bounds) {
    camera_ = fitView(sceneBounds_, 1.0);
    ui_.sections = options_.sections;
    ui_.parts.style = options_.style;
    for (const PartId part : options_.hidden) ui_.parts.setHidden(part, true);
    ui_.shared = SharedView(options_.follows);
    ui_.shared.shares = options_.shares;
  }

  void keys(const ViewModel& model, const Input& input, ViewActions& actions);
  void partKey(int key, bool shift);
  void fit(const ViewModel& model);
  void turnByMouse(const Input& input, const View& view, const glm::dvec2& cursor, bool cursorInView);
  void moveStylus(const ViewModel& model, const Input& input, const View& view, bool cursorInView,
                  ViewActions& actions);
  void pointAt(const ViewModel& model, std::vector<Label>& labels);
  void partMenuOverScene(const PanelContext& context, const Input& input, bool cursorInView);
  void steerCamera(const ViewModel& model, double dt);
  void follow(const ViewModel& model);
  void chooseClash(const ViewModel& model);
  const FoundClash* shownClash(const ViewModel& model) const;
  void flyToClash(const ViewModel& model);
  void startNote(const ViewModel& model);
  void flyToNote(const ViewModel& model);
  std::optional<Camera> cameraOf(const ViewModel& model, const document::Entry& entry) const;
  void keepView(ViewActions& actions);
  void showOthers(const ViewModel& model, const Input& input, ViewActions& actions);
  View currentView(const ViewModel& model) const;
  void addGlyphs(const ViewModel& model, GlyphBatch& batch, std::vector<Label>& labels);
  void drawScene(const View& view, const ViewModel& model, const GlyphBatch& batch);
  glm::dvec2 pixelScale() const;
  SharedView::Window window() { return {ui_.sections, ui_.parts, ui_.measures, ui_.following}; }
  /// Whether parts are drawn elsewhere than they are, or will be in the next frame.
  bool apart() const { return apartNow_ || ui_.parts.style.explode > 0.0; }
  glm::dvec3 middle() const { return 0.5 * (sceneBounds_.min + sceneBounds_.max); }

  ViewerOptions options_;
  std::unique_ptr<Surface> surface_;
  std::unique_ptr<SceneRenderer> renderer_;
  std::unique_ptr<GlyphRenderer> glyphs_;
  std::unique_ptr<Interface> interface_;
  PartTree tree_;
  UiState ui_;
  std::vector<int> queuedKeys_;  // for the next frame
  StylusControl stylus_;
  SectionHandles sectionHandles_;
  Camera camera_;
  CameraFlight flight_;
  assets::Bounds sceneBounds_;
  Rect viewport_;  // window pixels
  std::vector<PartLook> looks_;
  std::optional<Hit> underCursor_;
  CameraDrag drag_;
  bool started_ = false;
  ExplodedScene exploded_;
  bool apartNow_ = false;  // in this frame's picture
  PartId menuPart_ = kNoPart;
  PartId graspedAt_ = kNoPart;  // under the cursor when the stylus began to grasp
  ScenePicture picture_;
};

glm::dvec2 SceneViewer::pixelScale() const {
  return glm::dvec2(surface_->framebufferSize()) / glm::max(glm::dvec2(surface_->size()), glm::dvec2(1.0));
}

/// Says what the others may see of this window.
void SceneViewer::showOthers(const ViewModel& model, const Input& input, ViewActions& actions) {
  ui_.shared.pointing = input.keysDown[GLFW_KEY_X] && !ImGui::GetIO().WantTextInput;
  const PartId part = underCursor_ && !drag_.active() ? underCursor_->part : kNoPart;
  const auto clash = inspectionOf(model.clashes.findings.get(), ui_.clashes, model.worldFromPart);
  actions.shown = ui_.shared.shown(model, {ui_.sections, ui_.parts, ui_.measures, clash}, part,
                                   underCursor_ ? underCursor_->point : glm::dvec3(0.0));
}

View SceneViewer::currentView(const ViewModel& model) const {
  Sphere content{0.5 * (sceneBounds_.min + sceneBounds_.max), 0.0};
  content.radius = renderer_->reachFrom(content.centre, model.worldFromPart);
  const auto includePoint = [&](const glm::dvec3& point) {
    content.radius = std::max(content.radius, glm::length(point - content.centre) + 0.05 * camera_.distance);
  };
  if (model.hand.present) includePoint(model.hand.worldFromProxy.position);
  if (!model.hand.second.deviceName.empty()) includePoint(model.hand.second.worldFromProxy.position);
  for (const SiteView& site : model.sites)
    if (site.seen && site.info.connected && !site.self) {
      includePoint(site.presence.worldFromTool.position);
      includePoint(site.presence.worldFromCamera.position);
    }
  // The radius changes in coarse steps. A moving hand must not change the depth planes, and with them the
  // whole picture, in each frame.
  if (content.radius > 0.0) content.radius = std::exp2(std::ceil(4.0 * std::log2(content.radius)) / 4.0);
  return makeView(camera_, viewport_.size(), content);
}

void SceneViewer::fit(const ViewModel& model) {
  ASSERT(ui_.fit.has_value());
  std::vector<PartId> parts = *ui_.fit;
  ui_.fit.reset();
  const bool everything = parts.empty();
  if (everything)
    for (std::size_t p = 0; p < model.worldFromPart.size(); ++p)
      if (ui_.parts.visible(static_cast<PartId>(p))) parts.push_back(static_cast<PartId>(p));
  const glm::dvec2 size = viewport_.size();
  assets::Bounds bounds = renderer_->bounds(model.worldFromPart, parts);
  if (everything) includePeople(model, bounds);
  for (const Pose& pose : everything ? posesAlong(model.wayOut.path, 1) : std::vector<Pose>{}) {
    bounds.include(pose.position);
  }
  const Camera goal = fitFrom(camera_, bounds, size.x / std::max(size.y, 1.0));
  if (std::exchange(ui_.fitFlies, false))
    flight_.start(camera_, goal);
  else
    camera_ = goal;
  ui_.following = kNoSite;
}

void reverse(bool again, ViewActions& actions) {
  actions.documentWishes.push_back({again ? DocumentWish::Kind::redo : DocumentWish::Kind::undo, {}});
}

void SceneViewer::partKey(int key, bool shift) {
  if (key == GLFW_KEY_H && shift) {
    ui_.parts.showAll();
    return;
  }
  const PartId part = ui_.parts.selected;
  if (part == kNoPart) return;
  if (key == GLFW_KEY_H) ui_.parts.setHidden(part, ui_.parts.visible(part));
  if (key == GLFW_KEY_I) ui_.parts.isolate({part});
  if (key == GLFW_KEY_T) ui_.parts.setTransparent(part, !ui_.parts.transparent(part));
}

void SceneViewer::keys(const ViewModel& model, const Input& input, ViewActions& actions) {
  const bool typing = ImGui::GetIO().WantTextInput;
  for (const int key : input.keysPressed) {
    if (key == GLFW_KEY_F1) ui_.showHelp = !ui_.showHelp;
    if (typing && !(key == GLFW_KEY_SPACE && input.ctrl)) continue;
    switch (key) {
      case GLFW_KEY_SPACE:
        actions.settings.zeroForce = !actions.settings.zeroForce;
        actions.settingsChanged = true;
        break;
      case GLFW_KEY_C:
        actions.resetFault = hasFault(model);
        break;
      case GLFW_KEY_F:
        ui_.fit =
            ui_.parts.selected != kNoPart ? std::vector<PartId>{ui_.parts.selected} : std::vector<PartId>{};
        break;
      case GLFW_KEY_HOME:
        ui_.fit = std::vector<PartId>{};
        break;
      case GLFW_KEY_1:
      case GLFW_KEY_KP_1:
        look(camera_, StandardView::front);
        break;
      case GLFW_KEY_3:
      case GLFW_KEY_KP_3:
        look(camera_, StandardView::right);
        break;
      case GLFW_KEY_7:
      case GLFW_KEY_KP_7:
        look(camera_, StandardView::top);
        break;
      case GLFW_KEY_P:
        actions.togglePlay = model.replay;
        break;
      case GLFW_KEY_N:
        startNote(model);
        break;
      case GLFW_KEY_M:
        measureKey(ui_.measures, model, underCursor_ ? underCursor_->part : kNoPart,
                   underCursor_ ? underCursor_->point : glm::dvec3(0.0));
        break;
      case GLFW_KEY_B:
        ui_.notes.goBack = true;
        break;
      case GLFW_KEY_Z:
      case GLFW_KEY_Y:
        if (input.ctrl && mayWrite(model)) reverse(key == GLFW_KEY_Y || input.shift, actions);
        break;
      case GLFW_KEY_TAB:
        ui_.showPanels = !ui_.showPanels;
        break;
      case GLFW_KEY_ESCAPE:
        if (!ui_.showHelp) ui_.parts.selected = ui_.clashes.a = ui_.clashes.b = kNoPart;
        ui_.notes.chosen = 0;
        ui_.notes.draft.reset();
        clearMeasure(ui_.measures);
        ui_.showHelp = false;
        ui_.following = kNoSite;
        break;
      case GLFW_KEY_H:
      case GLFW_KEY_I:
      case GLFW_KEY_T:
        partKey(key, input.shift);
        break;
      default:
        break;
    }
  }
}

/// Moves the camera to what was asked for: a fit, another person's view, or a clash.
void SceneViewer::steerCamera(const ViewModel& model, double dt) {
  if (!started_ && camera_.distance == fitView(sceneBounds_, 1.0).distance)
    camera_ = fitFrom(camera_, sceneBounds_, viewport_.size().x / std::max(viewport_.size().y, 1.0));
  if (ui_.fit) {
    flight_.stop();
    fit(model);
  }
  ui_.shared.follow(model, window());
  follow(model);
  chooseClash(model);
  flyToClash(model);
  flyToNote(model);
  if (flight_.flying()) camera_ = flight_.step(dt);
}

void SceneViewer::follow(const ViewModel& model) {
  if (ui_.following == kNoSite) return;
  const auto site = std::find_if(model.sites.begin(), model.sites.end(),
                                 [&](const SiteView& s) { return s.info.site == ui_.following; });
  if (site == model.sites.end() || !site->info.connected) {
    ui_.following = kNoSite;
  } else if (site->seen) {
    camera_ = cameraAt(site->presence.worldFromCamera, camera_);
  }
}

/// The chosen clash, while its list is open.
const FoundClash* SceneViewer::shownClash(const ViewModel& model) const {
  return ui_.clashes.open ? chosenClash(model.clashes.findings.get(), ui_.clashes) : nullptr;
}

void SceneViewer::chooseClash(const ViewModel& model) {
  const ClashFindings* findings = model.clashes.findings.get();
  if (!ui_.clashes.choosesFirst || findings == nullptr) return;
  ui_.clashes.choosesFirst = false;
  const std::vector<ClashRow> rows = clashRows(*findings, *model.scene, ui_.clashes.touches);
  if (rows.empty()) return;
  ui_.clashes.a = rows.front().found->clash.a;
  ui_.clashes.b = rows.front().found->clash.b;
  ui_.clashes.fly = true;
}

/// Moves the camera to the chosen pair of parts, found by a search or kept from an earlier one.
void SceneViewer::flyToClash(const ViewModel& model) {
  const ClashUi& ui = ui_.clashes;
  if (!std::exchange(ui_.clashes.fly, false) || !ui.open || ui.a == kNoPart) return;
  std::optional<ClashWitness> witness;
  if (const FoundClash* found = apartNow_ ? nullptr : shownClash(model))
    witness = witnessOf(*model.clashes.findings, *found, model.worldFromPart);
  const auto boundsOf = [&](PartId part) { return renderer_->bounds(model.worldFromPart, std::array{part}); };
  const double aspect = viewport_.size().x / std::max(viewport_.size().y, 1.0);
  if (!ui_.notes.back) ui_.notes.back = NoteBack{camera_, {}, {}};
  ui_.following = kNoSite;
  flight_.start(camera_, cameraForPair(camera_, witness, boundsOf(ui.a), boundsOf(ui.b), aspect));
}

/// A note at the place under the cursor, or where the tool is.
void SceneViewer::startNote(const ViewModel& model) {
  NoteUi& notes = ui_.notes;
  if (!mayWrite(model) || notes.draft) return;
  notes.draft = underCursor_ ? noteAt(model, underCursor_->part, underCursor_->point)
                             : noteAt(model, model.hand.touched, model.hand.worldFromProxy.position);
  notes.focus = notes.wanted = ui_.showPanels = true;
}

std::optional<Camera> SceneViewer::cameraOf(const ViewModel& model, const document::Entry& entry) const {
  if (const auto* view = std::get_if<document::NamedView>(&entry.body)) return cameraOfView(*view, camera_);
  const auto* note = std::get_if<document::Note>(&entry.body);
  const std::optional<glm::dvec3> place = note != nullptr ? placeOf(*note, model) : std::nullopt;
  if (!place) return std::nullopt;
  const assets::Bounds around =
      note->part == kNoPart ? sceneBounds_ : renderer_->bounds(model.worldFromPart, std::array{note->part});
  return cameraForNote(camera_, *place, glm::length(around.max - around.min));
}

/// Moves the camera to a chosen note or view, or back to where it was before.
void SceneViewer::flyToNote(const ViewModel& model) {
  NoteUi& notes = ui_.notes;
  const document::EntryId chosen = std::exchange(notes.flyTo, 0);
  if (std::exchange(notes.goBack, false) && notes.back) {
    const NoteBack back = *std::exchange(notes.back, {});
    if (back.sections) ui_.sections = *back.sections;
    if (back.parts) ui_.parts = *back.parts;
    flight_.start(camera_, back.camera);
  }
  const document::Entry* entry = model.document != nullptr ? model.document->find(chosen) : nullptr;
  const std::optional<Camera> goal = entry != nullptr ? cameraOf(model, *entry) : std::nullopt;
  if (!goal) return;
  if (!notes.back) notes.back = NoteBack{camera_, {}, {}};
  if (std::holds_alternative<document::NamedView>(entry->body)) ui_.shared.stop(window());
  if (const auto* view = std::get_if<document::NamedView>(&entry->body)) {
    if (!notes.back->sections) {
      notes.back->sections = ui_.sections;
      notes.back->parts = ui_.parts;
    }
    applyView(*view, ui_.sections, ui_.parts);
  }
  ui_.following = kNoSite;
  flight_.start(camera_, *goal);
}

void SceneViewer::keepView(ViewActions& actions) {
  NoteUi& notes = ui_.notes;
  if (!std::exchange(notes.keepsView, false)) return;
  actions.documentWishes.push_back(newEntry(viewAs(notes.viewName.data(), camera_, ui_.sections, ui_.parts)));
  notes.viewName = {};
}

void SceneViewer::turnByMouse(const Input& input, const View& view, const glm::dvec2& cursor,
                              bool cursorInView) {
  if (cursorInView)
    drag_.begin(input, !options_.stylusFromMouse, underCursor_ ? underCursor_->point : view.camera.target);
  bool moved = drag_.move(input, view, camera_);
  if (cursorInView && !input.ctrl && input.wheel != 0.0) {
    zoom(camera_, input.wheel, underCursor_ ? underCursor_->point : view.pointAt(cursor, camera_.distance));
    moved = true;
  }
  if (!moved) return;
  ui_.following = kNoSite;
  flight_.stop();
}

void SceneViewer::moveStylus(const ViewModel& model, const Input& input, const View& view, bool cursorInView,
                             ViewActions& actions) {
  if (!started_) {
    const auto middle = renderer_->pick(view, 0.5 * view.size, model.worldFromPart, looks_);
    stylus_.place(view, (middle ? middle->depth : camera_.distance) - model.hand.toolRadius);
    actions.stylusMoved = true;
  }
  StylusControl::Situation now{view, input};
  now.cursor = input.cursor - viewport_.min;
  now.cursorInView = cursorInView;
  now.cameraMoving = drag_.active();
  now.keysFree = !ImGui::GetIO().WantTextInput;
  now.mayGrasp = model.role != sync::Role::observer && !model.replay && !apart();
  now.holding = model.hand.held != kNoPart;
  now.followSurface = ui_.followSurface;
  now.toolRadius = model.hand.toolRadius;
  now.surface = underCursor_;
  const bool grasped = stylus_.grasping();
  if (stylus_.update(now)) actions.stylusMoved = true;
  actions.worldFromStylus = stylus_.worldFromStylus();
  actions.grasp = stylus_.grasping();
  if (!actions.grasp)
    graspedAt_ = kNoPart;
  else if (!grasped)
    graspedAt_ = underCursor_ ? underCursor_->part : kNoPart;
  actions.graspedAt = graspedAt_;
}

/// Lights the part under the cursor and names it. Where the mouse moves the stylus, a click takes that part,
/// so it is the one in reach, not the part that happens to be nearest to the tip.
void SceneViewer::pointAt(const ViewModel& model, std::vector<Label>& labels) {
  ui_.parts.inReach = kNoPart;
  if (!underCursor_ || drag_.active() || model.hand.held != kNoPart) return;
  const PartId part = underCursor_->part;
  if (options_.stylusFromMouse && !model.replay && !apart())
    ui_.parts.inReach = part;
  else
    ui_.parts.hovered = part;
  labels.push_back(nameAt(model, part, underCursor_->point));
}

void SceneViewer::partMenuOverScene(const PanelContext& context, const Input& input, bool cursorInView) {
  const bool click = input.released[1] && !drag_.moved() && cursorInView;
  const bool select =
      (!options_.stylusFromMouse || apart()) && input.released[0] && !drag_.moved() && cursorInView;
  if (click || select) ui_.parts.selected = underCursor_ ? underCursor_->part : kNoPart;
  if (click && underCursor_) {
    menuPart_ = underCursor_->part;
    ImGui::OpenPopup("part menu");
  }
  if (!ImGui::BeginPopup("part menu")) return;
  if (context.model.scene && menuPart_ < context.model.scene->parts.size())
    ImGui::TextDisabled("%s", context.model.scene->parts[menuPart_].name.c_str());
  ImGui::Separator();
  partMenu(context, {menuPart_});
  ImGui::EndPopup();
}

void SceneViewer::drawScene(const View& view, const ViewModel& model, const GlyphBatch& batch) {
  const glm::ivec2 size = glm::max(glm::ivec2(viewport_.size() * pixelScale()), glm::ivec2(1));
  ScenePicture::Content content{view, model.worldFromPart, looks_, batch, theme::kBackground, ui_.showEdges};
  const std::vector<Pose> along =
      apartNow_ ? std::vector<Pose>{} : posesAlong(model.wayOut.path, kPosesOnWay);
  content.again = model.wayOut.part;
  content.worldFromAgain = along;
  content.lookAgain = wayLook(model.wayOut.free);
  picture_.update(content, size, *renderer_, *glyphs_);
  const glm::ivec2 window = surface_->framebufferSize();
  const glm::ivec2 corner(viewport_.min * pixelScale());
  glBindFramebuffer(GL_FRAMEBUFFER, surface_->framebuffer());
  glViewport(0, 0, window.x, window.y);
  picture_.show(surface_->framebuffer(), {corner.x, window.y - corner.y - size.y});
  glBindFramebuffer(GL_FRAMEBUFFER, surface_->framebuffer());
}

/// Everything over the parts: what is chosen or written at them, and the people.
void SceneViewer::addGlyphs(const ViewModel& model, GlyphBatch& batch, std::vector<Label>& labels) {
  const sync::Inspection& theirs = ui_.shared.clash(model);
  const auto own = inspectionOf(model.clashes.findings.get(), ui_.clashes, model.worldFromPart);
  addInspection(theirs.a != kNoPart ? theirs : own, model, apartNow_, looks_, batch, labels);
  if (!apartNow_) addWayOut(model, batch);
  markBlockers(model.wayOut, looks_);
  addNotes(model, ui_.notes, batch, labels);
  addMeasures(model, ui_.measures, batch, labels);
  addFields(model, batch);
  if (options_.panels && !ui_.shared.following().followsSections())
    sectionHandles_.draw(ui_.sections, middle(), batch);
  addPeople(model, batch, labels);
  addPoints(model, batch, labels);
}

ViewActions SceneViewer::frame(const ViewModel& model) {
  ASSERT(model.scene && model.worldFromPart.size() == model.scene->parts.size());
  surface_->makeCurrent();
  renderer_->receive();
  Input input;
  interface_->begin(input);
  input.keysPressed.insert(input.keysPressed.end(), queuedKeys_.begin(), queuedKeys_.end());
  queuedKeys_.clear();
  ViewActions actions;
  actions.settings = model.settings;
  actions.quit = surface_->closeRequested();
  const PanelContext context{model, ui_, actions, interface_->fonts(), interface_->scale(), surface_->live()};

  apartNow_ = ui_.parts.style.explode > 0.0;
  const ViewModel& drawn = exploded_.drawn(model, ui_.parts.style, *renderer_);
  ui_.parts.hovered = kNoPart;
  viewport_ = {{0.0, 0.0}, glm::dvec2(surface_->size())};
  keys(drawn, input, actions);
  if (options_.panels && ui_.showPanels) viewport_ = drawPanels(context, tree_, glm::dvec2(surface_->size()));
  steerCamera(drawn, input.dt);
  keepView(actions);

  // In a slow frame the mouse has moved since the click: a click on a panel must not grasp the part that is
  // under the mouse by now.
  if (!viewport_.contains(input.pressedAt)) input.pressed.fill(false);
  const glm::dvec2 cursor = input.cursor - viewport_.min;
  bool cursorInView = !ImGui::GetIO().WantCaptureMouse && viewport_.contains(input.cursor);
  View view = currentView(drawn);
  if (!drag_.active() && !ui_.shared.following().followsSections() &&
      sectionHandles_.update(view, input, cursor, cursorInView, middle(), ui_.sections)) {
    input.pressed[0] = cursorInView = false;  // the mouse is the handle's
  }
  actions.sections = ui_.sections.planes();
  renderer_->setSections(actions.sections);
  partLooks(model, ui_.parts, looks_);
  if (!drag_.active())
    underCursor_ = cursorInView ? renderer_->pick(view, cursor, drawn.worldFromPart, looks_) : std::nullopt;
  turnByMouse(input, view, cursor, cursorInView);
  view = currentView(drawn);
  if (options_.stylusFromMouse) moveStylus(drawn, input, view, cursorInView, actions);
  partMenuOverScene(context, input, cursorInView);

  std::vector<Label> labels;
  pointAt(drawn, labels);
  partLooks(model, ui_.parts, looks_);
  GlyphBatch batch(view);
  addGlyphs(drawn, batch, labels);
  showOthers(drawn, input, actions);
  drawLabels(view, viewport_, labels, context);
  if (options_.panels) {
    drawNotices(context, viewport_);
    drawReplayBar(context, viewport_);
    drawMeasures(context, viewport_);
    drawApart(context, viewport_);
    if (ui_.showHelp) drawHelp(context);
  }
  drawScene(view, drawn, batch);
  interface_->end();
  surface_->present();
  started_ = true;
  actions.marks = ui_.measures.marks;
  actions.worldFromCamera = view.worldFromEye;
  actions.lifted = apart();
  return actions;
}

Status SceneViewer::screenshot(const std::string& path) {
  surface_->makeCurrent();
  const glm::ivec2 size = surface_->framebufferSize();
  std::vector<std::uint8_t> rgb(static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) * 3);
  glBindFramebuffer(GL_FRAMEBUFFER, surface_->framebuffer());
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, size.x, size.y, GL_RGB, GL_UNSIGNED_BYTE, rgb.data());
  return writePng(path, size.x, size.y, rgb);
}

}  // namespace

Result<std::unique_ptr<Viewer>> Viewer::open(const assets::Scene& scene, const ViewerOptions& options) {
  if (!displayPresent()) return Error{"no window can be opened: neither DISPLAY nor WAYLAND_DISPLAY is set"};
  auto surface = openWindow(options);
  if (!surface) return surface.error();
  return SceneViewer::make(scene, options, std::move(*surface));
}

Result<std::unique_ptr<Viewer>> Viewer::openOffscreen(const assets::Scene& scene,
                                                      const ViewerOptions& options) {
  auto surface = openOffscreenSurface(options);
  if (!surface) return surface.error();
  return SceneViewer::make(scene, options, std::move(*surface));
}

bool displayPresent() {
  const auto set = [](const char* name) {
    const char* value = std::getenv(name);
    return value && *value;
  };
  return set("DISPLAY") || set("WAYLAND_DISPLAY");
}

}  // namespace tandem::client
