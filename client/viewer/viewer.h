#pragma once

// The window on a scene: GLFW, OpenGL 3.3 core through epoxy, Dear ImGui. Main thread only.

#include <memory>
#include <string>

#include "assets/base/result.h"
#include "client/marks/section_set.h"
#include "client/session/view_model.h"

namespace tandem::client {

struct UiState;

struct ViewerOptions {
  std::string title = "Tandem";
  int width = 1440, height = 900;
  bool panels = true;                           // false: the scene alone
  bool stylusFromMouse = true;                  // no hardware device: mouse and keyboard move the stylus
  SectionSet sections{};                        // how the scene is cut open at first, for this person alone
  document::PartStyle style{};                  // how parts are drawn at first
  std::vector<PartId> hidden{};                 // at first
  bool follows = true;                          // what others share is followed
  sync::Shares shares = sync::Shares::nothing;  // by this person, at first
  bool levels = true;                           // large meshes of a large scene are drawn by levels of detail
  std::string cacheDirectory{};                 // where levels are kept; empty: nowhere
};

class Viewer {
 public:
  /// Opens a window; the error says that there is no display, or what GL lacks.
  static Result<std::unique_ptr<Viewer>> open(const assets::Scene& scene, const ViewerOptions& options);
  /// The same pictures without a display, through EGL (surfaceless Mesa or any EGL device).
  static Result<std::unique_ptr<Viewer>> openOffscreen(const assets::Scene& scene,
                                                       const ViewerOptions& options);

  virtual ~Viewer() = default;
  /// Draws one frame, waits for the display's refresh (a window only), and returns what the person did.
  virtual ViewActions frame(const ViewModel& model) = 0;
  /// By how many pixels a part of the last frame may be off at most; more than one only while levels of
  /// detail are being made.
  virtual double pixelsOff() const = 0;
  /// Writes the last frame as a PNG.
  virtual Status screenshot(const std::string& path) = 0;
  virtual Camera& camera() = 0;
  /// What the panels change.
  virtual UiState& ui() = 0;
  /// A key (GLFW's code) for the next frame, as if it had been pressed.
  virtual void pressKey(int key) = 0;
  /// The mouse of the next frames, window pixels, for a viewer without a window.
  virtual void pointMouse(const glm::dvec2& cursor, bool leftDown) = 0;
  /// Shows the list of clashes, requests a search, and chooses the first clash that is found.
  virtual void openClashes(const ClashQuestion& question) = 0;
  /// Shows the list of notes, with the thread that changed last.
  virtual void openNotes() = 0;
  /// Shows the panel of measures, and those that the document has in the scene.
  virtual void openMeasures() = 0;
  /// Fits the view to all parts and styli as the next frame's model has them.
  virtual void fitAll() = 0;
};

/// Whether a display can be expected (DISPLAY or WAYLAND_DISPLAY is set).
bool displayPresent();

}  // namespace tandem::client
