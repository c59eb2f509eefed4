#pragma once

// What `tandem check` tells of contact between a part in the hand and others.

#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "assets/scene/scene.h"
#include "client/review/contact_models.h"

namespace tandem::client {

nlohmann::ordered_json contactJson(const assets::Scene& scene, const std::vector<ContactModel>& models);
void printContact(const assets::Scene& scene, const std::vector<ContactModel>& models);

}  // namespace tandem::client
