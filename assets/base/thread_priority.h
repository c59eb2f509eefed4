#pragma once

namespace tandem {

/// Puts the calling thread, and those that it starts from then on, behind the hand's loop and the window.
void lowerThreadPriority();

}  // namespace tandem
