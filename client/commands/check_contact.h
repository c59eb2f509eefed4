#pragma once

// The output of `tandem check` about contact between a held part and others.

#include <vector>

#include "assets/base/json.h"
#include "assets/scene/scene.h"
#include "client/review/contact_models.h"

namespace tandem::client {

/// What is too costly to hold, the worst first: parts whose predicted tick takes longer than a tick's period.
/// Nothing where no part was tried.
void printTooCostly(const assets::Scene& scene, const std::vector<ContactModel>& models);

Json contactJson(const assets::Scene& scene, const std::vector<ContactModel>& models);
void printContact(const assets::Scene& scene, const std::vector<ContactModel>& models);

}  // namespace tandem::client
