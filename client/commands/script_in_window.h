#pragma once

// What a script shows the others, done in a window: what it sets is what the person at the window may change.

#include <vector>

#include "client/hand/hand_script.h"
#include "client/viewer/viewer.h"

namespace tandem::client {

/// Does in the window what a step of a script shows; a message goes to the end of `says`.
void showInWindow(const ScriptStep& step, const ViewModel& model, Viewer& viewer,
                  std::vector<sync::Say>& says);

}  // namespace tandem::client
