#include "client/join/scene_download.h"

#include "assets/base/assert.h"
#include "client/join/local_time.h"

namespace tandem::client {

using namespace sync;

namespace {

constexpr Micros kKeepPeriod = kSecond;             // between copies of an unfinished transfer
constexpr Micros kTransferPatience = 30 * kSecond;  // without a byte

}  // namespace

Status downloadScene(ServerConnection& connection, const SceneStore& store, const Progress& progress,
                     const std::function<void(sync::Micros)>& step) {
  ASSERT(connection.stage() == ServerConnection::Stage::needScene);
  const assets::ContentHash hash = connection.welcome().sceneHash;
  connection.startTransfer(store.beginning(hash));
  Micros lastProgress = localTime(), lastKept = lastProgress;
  double lastShare = -1.0;
  while (connection.stage() != ServerConnection::Stage::haveScene) {
    if (connection.stage() == ServerConnection::Stage::ended)
      return Error{"the session ended: " + connection.reason()};
    if (connection.stage() == ServerConnection::Stage::needScene)
      connection.startTransfer(connection.scenePackage());  // reconnected
    const Micros now = localTime();
    const bool stopped = !progress(connection.transferProgress(), "fetching the scene");
    if (connection.transferProgress() != lastShare) {
      lastShare = connection.transferProgress();
      lastProgress = now;
    }
    const bool stalled = now - lastProgress > kTransferPatience;
    if (stopped || stalled || now - lastKept > kKeepPeriod) {
      lastKept = now;
      store.keepBeginning(hash, connection.scenePackage());
    }
    if (stopped) return Error{"interrupted; the scene's transfer will go on from here next time"};
    if (stalled) return Error{"the scene's transfer stands still; it will go on from here next time"};
    step(now);
  }
  if (assets::contentHash(connection.scenePackage()) != hash) {
    store.forgetBeginning(hash);
    return Error{
        "the scene arrived damaged (its hash is not the announced one); enter again to fetch it anew"};
  }
  store.keep(hash, connection.scenePackage());
  return {};
}

}  // namespace tandem::client
