#pragma once

// ImGui in one viewer: its context, fonts and input.

#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include "client/viewer/surface.h"
#include "client/viewer/theme.h"

namespace tandem::client {

/// ImGui's context of one viewer; several may live in one process.
class Interface {
 public:
  explicit Interface(Surface& surface) : surface_(surface), context_(ImGui::CreateContext()) {
    ImGui::SetCurrentContext(context_);
    ImGui::GetIO().IniFilename = nullptr;
    scale_ = surface.contentScale();
    fonts_ = theme::apply(scale_);
    surface_.startInterface();
    ImGui_ImplOpenGL3_Init("#version 330 core");
  }
  ~Interface() {
    surface_.makeCurrent();
    ImGui::SetCurrentContext(context_);
    ImGui_ImplOpenGL3_Shutdown();
    surface_.stopInterface();
    ImGui::DestroyContext(context_);
  }
  Interface(const Interface&) = delete;
  Interface& operator=(const Interface&) = delete;

  void begin(Input& input) {
    ImGui::SetCurrentContext(context_);
    ImGui_ImplOpenGL3_NewFrame();
    surface_.beginFrame(input);
    ImGui::NewFrame();
    const ImGuiIO& io = ImGui::GetIO();
    input.cursor = {static_cast<double>(io.MousePos.x), static_cast<double>(io.MousePos.y)};
    input.cursorMove = {static_cast<double>(io.MouseDelta.x), static_cast<double>(io.MouseDelta.y)};
    for (std::size_t b = 0; b < 3; ++b) {
      const int button = static_cast<int>(b);
      input.down[b] = io.MouseDown[button];
      input.pressed[b] = ImGui::IsMouseClicked(button);
      input.released[b] = ImGui::IsMouseReleased(button);
    }
    input.wheel = static_cast<double>(io.MouseWheel);
    input.shift = io.KeyShift;
    input.ctrl = io.KeyCtrl;
  }
  void end() {
    ImGui::Render();
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  }
  const Fonts& fonts() const { return fonts_; }
  float scale() const { return scale_; }

 private:
  Surface& surface_;
  ImGuiContext* context_;
  Fonts fonts_;
  float scale_ = 1.0f;
};

}  // namespace tandem::client
