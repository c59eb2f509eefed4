#include <epoxy/gl.h>

#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <string>
#include <thread>

#include "client/viewer/surface.h"

namespace tandem::client {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kFrameInterval = std::chrono::microseconds(16600);
constexpr auto kSoftwareInterval = std::chrono::microseconds(33000);

std::string lastGlfwError() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text ? text : "unknown reason";
}

bool rendersInSoftware() {
  const auto* renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  return renderer && (std::strstr(renderer, "llvmpipe") || std::strstr(renderer, "softpipe"));
}

class WindowSurface final : public Surface {
 public:
  explicit WindowSurface(GLFWwindow* window) : window_(window) {
    glfwSetWindowUserPointer(window_, this);
    // These callbacks are installed first: ImGui's call them.
    glfwSetKeyCallback(window_, [](GLFWwindow* w, int key, int, int action, int) {
      auto* self = static_cast<WindowSurface*>(glfwGetWindowUserPointer(w));
      if (action == GLFW_PRESS && key >= 0) self->keysPressed_.push_back(key);
    });
    glfwSetCursorPosCallback(window_, [](GLFWwindow* w, double x, double y) {
      static_cast<WindowSurface*>(glfwGetWindowUserPointer(w))->cursor_ = {x, y};
    });
    glfwSetMouseButtonCallback(window_, [](GLFWwindow* w, int, int action, int) {
      auto* self = static_cast<WindowSurface*>(glfwGetWindowUserPointer(w));
      if (action == GLFW_PRESS) self->pressedAt_ = self->cursor_;
    });
    glfwMakeContextCurrent(window_);
    glfwSwapInterval(1);
    software_ = rendersInSoftware();
  }
  ~WindowSurface() override {
    glfwDestroyWindow(window_);
    glfwTerminate();
  }

  void makeCurrent() override { glfwMakeContextCurrent(window_); }
  glm::ivec2 size() const override {
    glm::ivec2 size(0);
    glfwGetWindowSize(window_, &size.x, &size.y);
    return size;
  }
  glm::ivec2 framebufferSize() const override {
    glm::ivec2 size(0);
    glfwGetFramebufferSize(window_, &size.x, &size.y);
    return size;
  }
  unsigned framebuffer() const override { return 0; }
  float contentScale() const override {
    float x = 1.0f, y = 1.0f;
    glfwGetWindowContentScale(window_, &x, &y);
    const float pixelsPerUnit =
        static_cast<float>(framebufferSize().x) / static_cast<float>(std::max(size().x, 1));
    return std::clamp(x / std::max(pixelsPerUnit, 1.0f), 1.0f, 4.0f);
  }
  void startInterface() override { ImGui_ImplGlfw_InitForOpenGL(window_, true); }
  void stopInterface() override { ImGui_ImplGlfw_Shutdown(); }

  void beginFrame(Input& input) override {
    frameStart_ = Clock::now();
    glfwPollEvents();
    ImGui_ImplGlfw_NewFrame();
    const auto& io = ImGui::GetIO();
    input = Input{};
    input.keysPressed.swap(keysPressed_);
    input.pressedAt = pressedAt_;
    for (std::size_t key = 0; key < kKeyCount; ++key) input.keysDown[key] = io.KeysDown[key];
    input.dt = io.DeltaTime;
  }

  void present() override {
    const auto drawn = Clock::now();
    glfwSwapBuffers(window_);
    // A display without vertical synchronisation, such as a virtual one, would let the loop run free. A
    // software renderer uses every core, so it pauses for half as long as it drew to leave one to the haptic
    // loop.
    auto until = frameStart_ + (software_ ? kSoftwareInterval : kFrameInterval);
    if (software_) until = std::max(until, Clock::now() + (drawn - frameStart_) / 2);
    std::this_thread::sleep_until(until);
  }
  bool closeRequested() const override { return glfwWindowShouldClose(window_) != 0; }
  void pointMouse(const glm::dvec2&, bool) override {}
  bool live() const override { return true; }

 private:
  GLFWwindow* window_;
  std::vector<int> keysPressed_;
  glm::dvec2 cursor_{-1e9, -1e9}, pressedAt_{-1e9, -1e9};
  Clock::time_point frameStart_ = Clock::now();
  bool software_ = false;
};

}  // namespace

Result<std::unique_ptr<Surface>> openWindow(const ViewerOptions& options) {
  if (!glfwInit()) return Error{"no window can be opened: " + lastGlfwError()};
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  glfwWindowHint(GLFW_DEPTH_BITS, 0);
  GLFWwindow* window =
      glfwCreateWindow(options.width, options.height, options.title.c_str(), nullptr, nullptr);
  if (!window) {
    const std::string reason = lastGlfwError();
    glfwTerminate();
    return Error{"no window with OpenGL 3.3 can be opened: " + reason};
  }
  return std::unique_ptr<Surface>(std::make_unique<WindowSurface>(window));
}

}  // namespace tandem::client
