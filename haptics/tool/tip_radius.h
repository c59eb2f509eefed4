#pragma once

// The ball that a hand touches with where nobody has chosen another.

#include "haptics/scene/contact_scene.h"

namespace tandem::haptics {

/// Radius of the tip that suits a scene, m: 2^-8 of the scene, some three pixels where it fills a window, and
/// no more than 2^-4 of the median part, so that most parts can be told apart by touch.
double tipRadius(const ContactScene& scene);

}  // namespace tandem::haptics
