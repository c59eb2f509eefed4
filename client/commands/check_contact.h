#pragma once

// What `tandem check` tells of contact between a part in the hand and others.

#include <vector>

#include "assets/base/json.h"
#include "assets/scene/scene.h"
#include "client/review/contact_models.h"

namespace tandem::client {

Json contactJson(const assets::Scene& scene, const std::vector<ContactModel>& models);
void printContact(const assets::Scene& scene, const std::vector<ContactModel>& models);

}  // namespace tandem::client
