#include "client/session/document_visit.h"

#include <utility>

#include "assets/base/assert.h"
#include "sync/wire/wire.h"

namespace tandem::client {

using sync::TransportEvent;

DocumentVisit::DocumentVisit(sync::Transport& transport, sync::Hello hello)
    : transport_(transport), hello_(std::move(hello)) {}

void DocumentVisit::send(const sync::ControlMessage& message) {
  transport_.sendControl(0, sync::encodeControl(message));
}

void DocumentVisit::step(sync::Micros now) {
  TransportEvent event;
  while (stage_ != Stage::ended && transport_.poll(event)) {
    if (event.kind == TransportEvent::Kind::connected) send(hello_);
    if (event.kind == TransportEvent::Kind::control) receive(event.bytes);
    if (event.kind == TransportEvent::Kind::closed)
      end(event.reason.empty() ? "the connection was closed" : event.reason);
  }
  if (stage_ != Stage::there || !import_) return;
  while (const std::optional<sync::PutEntry> next = import_->next(now)) send(*next);
}

void DocumentVisit::receive(std::span<const std::byte> bytes) {
  Result<sync::ControlMessage> message = sync::decodeControl(bytes);
  if (!message) {
    transport_.close(0);
    return end("the server sent something that is not of this protocol: " + message.error().message);
  }
  if (auto* welcome = std::get_if<sync::Welcome>(&*message);
      welcome != nullptr && stage_ == Stage::entering) {
    welcome_ = std::move(*welcome);
    stage_ = Stage::fetching;
    send(replica_.request());
  } else if (const auto* refused = std::get_if<sync::Refused>(&*message)) {
    end("refused: " + refused->reason);
  } else if (const auto* chunk = std::get_if<sync::DocumentChunk>(&*message)) {
    replica_.handle(*chunk);
    if (stage_ == Stage::fetching && replica_.complete()) stage_ = Stage::there;
  } else if (const auto* change = std::get_if<sync::DocumentChanged>(&*message)) {
    replica_.handle(*change);
  } else if (const auto* bytesOfScene = std::get_if<sync::SceneChunk>(&*message)) {
    if (scene_.handle(*bytesOfScene)) return;
    transport_.close(0);
    end("the server sent bytes of the scene that do not follow");
  } else if (const auto* reply = std::get_if<sync::PutReply>(&*message); reply != nullptr && import_) {
    import_->handle(*reply);
  }
}

void DocumentVisit::end(const std::string& reason) {
  stage_ = Stage::ended;
  reason_ = reason;
}

void DocumentVisit::bringIn(std::vector<document::Entry> entries) {
  ASSERT(stage_ == Stage::there && !import_);
  send(sync::Ready{});
  import_.emplace(replica_.content(), std::move(entries));
}

void DocumentVisit::fetchScene(std::vector<std::byte> have) {
  ASSERT(stage_ == Stage::there);
  scene_.expect(welcome_.sceneBytes);
  const sync::SceneRequest request = scene_.start(std::move(have));
  if (!scene_.complete()) send(request);
}

void DocumentVisit::leave() {
  if (stage_ == Stage::ended) return;
  send(sync::Goodbye{});
  transport_.close(0);
  end("left");
}

}  // namespace tandem::client
