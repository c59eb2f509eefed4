// The panel of a part's way out: how far the search is, what it found, and a button to end it.

#include <imgui.h>

#include "client/session/holding_words.h"
#include "client/viewer/panels.h"

namespace tandem::client {

void drawWayOut(const PanelContext& context) {
  const WayOutView& wayOut = context.model.wayOut;
  const std::string name = partName(context.model, wayOut.part);
  ImGui::PushTextWrapPos(0.0f);
  if (wayOut.running) {
    ImGui::TextUnformatted(name.c_str());
    ImGui::TextColored(theme::kMuted, "%s", wayOut.words.c_str());
  } else {
    ImGui::TextColored(wayOut.free ? theme::kText : theme::kWarning, "%s %s", name.c_str(),
                       wayOut.words.c_str());
  }
  ImGui::PopTextWrapPos();
  if (wayOut.running) ImGui::ProgressBar(static_cast<float>(wayOut.done), ImVec2(-1.0f, 0.0f));
  if (ImGui::SmallButton(wayOut.running ? "Cancel" : "Clear")) context.actions.clearWayOut = true;
}

}  // namespace tandem::client
