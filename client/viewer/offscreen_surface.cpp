#include <epoxy/egl.h>

#include <imgui.h>

#include <array>
#include <optional>
#include <string>

#include "client/picture/gl_objects.h"
#include "client/viewer/surface.h"

namespace tandem::client {
namespace {

bool clientSupports(const char* extension) { return epoxy_has_egl_extension(EGL_NO_DISPLAY, extension); }

/// The displays to try, in order: Mesa without any window system, then the default one.
std::array<EGLDisplay, 2> candidateDisplays() {
  EGLDisplay surfaceless = EGL_NO_DISPLAY;
  if (clientSupports("EGL_EXT_platform_base") && clientSupports("EGL_MESA_platform_surfaceless"))
    surfaceless = eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  return {surfaceless, eglGetDisplay(EGL_DEFAULT_DISPLAY)};
}

EGLContext createContext(EGLDisplay display) {
  if (!eglBindAPI(EGL_OPENGL_API)) return EGL_NO_CONTEXT;
  const EGLint wanted[] = {EGL_SURFACE_TYPE, EGL_DONT_CARE, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  if (!eglChooseConfig(display, wanted, &config, 1, &count) || count < 1) return EGL_NO_CONTEXT;
  const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION,
                            3,
                            EGL_CONTEXT_MINOR_VERSION,
                            3,
                            EGL_CONTEXT_OPENGL_PROFILE_MASK,
                            EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                            EGL_NONE};
  return eglCreateContext(display, config, EGL_NO_CONTEXT, version);
}

/// A context of EGL. The display is not terminated at the end, because EGL gives the same one to the whole
/// process.
class EglContext {
 public:
  EglContext() = default;
  EglContext(EGLDisplay display, EGLContext context) : display_(display), context_(context) {}
  EglContext(EglContext&& other) noexcept
      : display_(other.display_), context_(std::exchange(other.context_, EGL_NO_CONTEXT)) {}
  ~EglContext() {
    if (context_ == EGL_NO_CONTEXT) return;
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
  }
  bool makeCurrent() const { return eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_); }

 private:
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
};

class OffscreenSurface final : public Surface {
 public:
  OffscreenSurface(EglContext context, glm::ivec2 size) : context_(std::move(context)), size_(size) {
    target_.resize(size, 0, GL_RGBA8);
  }
  void makeCurrent() override { context_.makeCurrent(); }
  glm::ivec2 size() const override { return size_; }
  glm::ivec2 framebufferSize() const override { return size_; }
  unsigned framebuffer() const override { return target_.framebuffer(); }
  float contentScale() const override { return 1.0f; }
  void startInterface() override {}
  void stopInterface() override {}
  void beginFrame(Input& input) override {
    input = Input{};
    ImGuiIO& io = ImGui::GetIO();
    io.DisplaySize = ImVec2(static_cast<float>(size_.x), static_cast<float>(size_.y));
    io.DeltaTime = static_cast<float>(input.dt);
    if (!mouse_) return;
    io.MousePos = ImVec2(static_cast<float>(mouse_->x), static_cast<float>(mouse_->y));
    io.MouseDown[0] = leftDown_;
    input.pressedAt = *mouse_;
  }
  void present() override { glFinish(); }
  bool closeRequested() const override { return false; }
  void pointMouse(const glm::dvec2& cursor, bool leftDown) override {
    mouse_ = cursor;
    leftDown_ = leftDown;
  }
  bool live() const override { return false; }

 private:
  EglContext context_;
  glm::ivec2 size_;
  GlTarget target_;
  std::optional<glm::dvec2> mouse_;
  bool leftDown_ = false;
};

}  // namespace

Result<std::unique_ptr<Surface>> openOffscreenSurface(const ViewerOptions& options) {
  for (const EGLDisplay display : candidateDisplays()) {
    if (display == EGL_NO_DISPLAY || !eglInitialize(display, nullptr, nullptr)) continue;
    const EGLContext handle = createContext(display);
    if (handle == EGL_NO_CONTEXT) continue;
    EglContext context(display, handle);
    if (!context.makeCurrent()) continue;
    return std::unique_ptr<Surface>(
        std::make_unique<OffscreenSurface>(std::move(context), glm::ivec2(options.width, options.height)));
  }
  return Error{"no OpenGL 3.3 without a display: EGL offers neither a surfaceless nor a default display"};
}

}  // namespace tandem::client
