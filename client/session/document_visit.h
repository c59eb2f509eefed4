#pragma once

// A short visit to a session for its document, without a hand in its scene: fetches it, brings entries in,
// and fetches the bytes of the scene for who wants to draw it. One thread calls.

#include <optional>
#include <string>
#include <vector>

#include "client/session/document_import.h"
#include "client/session/document_replica.h"
#include "client/session/scene_fetch.h"
#include "sync/transport/transport.h"
#include "sync/wire/control_message.h"

namespace tandem::client {

class DocumentVisit {
 public:
  enum class Stage : std::uint8_t {
    entering,  // until the Welcome
    fetching,  // until the document is complete
    there,
    ended  // refused, or the connection was lost; see reason()
  };

  /// `transport` has begun to connect, and outlives this.
  DocumentVisit(sync::Transport& transport, sync::Hello hello);

  /// Everything that has come or is due at local time `now`.
  void step(sync::Micros now);
  Stage stage() const { return stage_; }
  const std::string& reason() const { return reason_; }

  /// As of stage `there`.
  const sync::Welcome& welcome() const { return welcome_; }
  const document::Document& content() const { return replica_.content(); }

  /// Begins to bring entries in, in the order of a DocumentFile. In stage `there`, once.
  void bringIn(std::vector<document::Entry> entries);
  /// Null before bringIn().
  const DocumentImport* bringing() const { return import_ ? &*import_ : nullptr; }

  /// Begins to fetch the scene package, after the bytes that are there already. In stage `there`, once.
  void fetchScene(std::vector<std::byte> have);
  const SceneFetch& scene() const { return scene_; }

  void leave();

 private:
  void send(const sync::ControlMessage& message);
  void receive(std::span<const std::byte> bytes);
  void end(const std::string& reason);

  sync::Transport& transport_;
  sync::Hello hello_;
  Stage stage_ = Stage::entering;
  std::string reason_;
  sync::Welcome welcome_;
  DocumentReplica replica_;
  std::optional<DocumentImport> import_;
  SceneFetch scene_;
};

}  // namespace tandem::client
