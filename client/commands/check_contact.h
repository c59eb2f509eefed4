#pragma once

// The output of `tandem check` about contact between a held part and others.

#include <vector>

#include "assets/base/json.h"
#include "assets/scene/scene.h"
#include "client/review/contact_models.h"

namespace tandem::client {

Json contactJson(const assets::Scene& scene, const std::vector<ContactModel>& models);
void printContact(const assets::Scene& scene, const std::vector<ContactModel>& models);

}  // namespace tandem::client
