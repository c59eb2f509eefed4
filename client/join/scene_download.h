#pragma once

// The transfer of the scene package into this user's store, before the site's threads run.

#include <functional>

#include "assets/base/result.h"
#include "client/join/scene_store.h"
#include "client/session/server_connection.h"
#include "sync/wire/time.h"

namespace tandem::client {

/// Called every few milliseconds with the share done, 0..1, and what is being done; false stops the work.
using Progress = std::function<bool(double, const char*)>;

/// Fetches the package that the Welcome announced, from where an earlier transfer broke off. What has come is
/// kept every second and when the transfer stops; after kTransferPatience without a byte it ends with an
/// error. The package must have the announced hash. `step` waits for the network and steps the connection at
/// the given local time.
Status downloadScene(ServerConnection& connection, const SceneStore& store, const Progress& progress,
                     const std::function<void(sync::Micros)>& step);

}  // namespace tandem::client
