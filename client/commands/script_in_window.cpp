#include "client/commands/script_in_window.h"

#include <algorithm>

#include "assets/base/assert.h"
#include "client/join/headless_view.h"
#include "client/session/said_parts.h"
#include "client/viewer/ui_state.h"

namespace tandem::client {

using Verb = ScriptStep::Verb;

void showInWindow(const ScriptStep& step, const ViewModel& model, Viewer& viewer,
                  std::vector<sync::Say>& says) {
  ASSERT(step.shows());
  UiState& ui = viewer.ui();
  switch (step.verb) {
    case Verb::section:
      ui.sections = SectionSet(step.planes);
      break;
    case Verb::share:
      ui.shared.shares = step.shares;
      break;
    case Verb::follow:
      ui.shared.followLater(step.shares != sync::Shares::nothing);
      break;
    case Verb::hide:
      for (std::size_t p = 0; p < ui.parts.partCount(); ++p) {
        const auto part = static_cast<PartId>(p);
        ui.parts.setHidden(part, std::find(step.parts.begin(), step.parts.end(), part) != step.parts.end());
      }
      break;
    case Verb::inspect:
      ui.shared.lookAtClash(step.inspection);
      ui.measures = {};
      ui.measures.open = step.inspection.measuring;
      ui.measures.marks = step.inspection.marks;
      break;
    case Verb::select:
      ui.parts.selected = step.part;
      break;
    case Verb::look:
      viewer.camera() = cameraFrom(step.from, step.vector, viewer.camera());
      ui.following = kNoSite;
      break;
    case Verb::point:
      ui.shared.pointAt(nearestToHand(step.part, model));
      break;
    case Verb::say:
      says.push_back(saidWithLinks(step.text, *model.scene));
      break;
    default:
      changeStyle(step, ui.parts.style);
      break;
  }
}

}  // namespace tandem::client
