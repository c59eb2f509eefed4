#pragma once

// People who change the document of one session on virtual time, each with the connection of a real client.

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "assets/document/document_json.h"
#include "client/session/document_words.h"
#include "client/session/server_connection.h"
#include "tests/server/session_rig.h"

namespace tandem::client {

using document::Change;
using document::Comment;
using document::Entry;
using document::EntryId;
using document::Note;
using document::NoteStatus;
using document::Removed;
using server::SessionRig;
using sync::kMillisecond;
using sync::kSecond;
using Kind = DocumentWish::Kind;

inline Note note(const std::string& text, NoteStatus status = NoteStatus::open) {
  Note n;
  n.text = text;
  n.status = status;
  return n;
}

/// A person at a site, and what the window of that site knows.
struct Person {
  std::unique_ptr<Exchange> exchange = std::make_unique<Exchange>();
  std::unique_ptr<ServerConnection> connection;
  document::Document shown;
  std::vector<std::string> notices;

  SessionDocument& document() { return connection->document(); }
  void write(EntryId id, const document::Body& body) {
    const Entry* entry = document().content().find(id);
    document().want({Kind::change, {id, entry == nullptr ? 0 : entry->revision, body}});
  }
  void undo() { document().want({Kind::undo, {}}); }
  void redo() { document().want({Kind::redo, {}}); }
  /// The entry with this text; 0 if there is none.
  EntryId find(const std::string& text) {
    for (const auto& [id, entry] : document().content().entries())
      if (inWords(entry.body).find('"' + text + '"') != std::string::npos) return id;
    return 0;
  }
  bool wasTold(const std::string& words) const {
    return std::any_of(notices.begin(), notices.end(),
                       [&](const std::string& notice) { return notice.find(words) != std::string::npos; });
  }
};

struct SessionDocuments : testing::Test, SessionRig {
  std::vector<std::unique_ptr<Person>> people;
  unsigned missesEvery = 0;  // a mistake: one of so many entries does not get to the window; 0: none

  /// A site's window is told of an entry.
  virtual void onTold(const Person&, const Entry&) {}

  void afterStep() override {
    for (const auto& person : people) {
      ServerConnection& connection = *person->connection;
      connection.step(now);
      if (connection.stage() == ServerConnection::Stage::needScene) connection.skipTransfer();
      if (connection.stage() == ServerConnection::Stage::haveScene)
        connection.sceneReady(scene, *person->exchange);
      DocumentNews news = connection.document().drainNews();
      if (news.anew) person->shown.clear();
      for (const Entry& entry : news.entries) {
        onTold(*person, entry);
        if (missesEvery == 0 || ++news_ % missesEvery != 0) person->shown.put(entry);
      }
      for (const Notice& notice : connection.drainNotices()) person->notices.push_back(notice.text);
    }
  }
  Person& enter(const std::string& name, sync::Role role = sync::Role::participant) {
    auto person = std::make_unique<Person>();
    ConnectionOptions options;
    options.name = name;
    options.token = token(role);
    person->connection = std::make_unique<ServerConnection>(
        options,
        [this, name]() -> Result<std::unique_ptr<sync::Transport>> { return network.connect(name); });
    people.push_back(std::move(person));
    SessionRig::run(300 * kMillisecond);
    EXPECT_TRUE(people.back()->document().standing().complete) << name;
    return *people.back();
  }
  void settle() { SessionRig::run(200 * kMillisecond); }
  /// Both replicas of everybody are what the server has.
  void expectOneDocument() {
    const std::string truth = toJson(session->document(), "s");
    for (const auto& person : people) {
      EXPECT_TRUE(person->document().standing().complete);
      EXPECT_EQ(person->document().standing().unsent, 0u);
      EXPECT_EQ(toJson(person->document().content(), "s"), truth);
      EXPECT_EQ(toJson(person->shown, "s"), truth);
    }
  }
  const document::Body& truth(EntryId id) { return session->document().find(id)->body; }
  std::string text(EntryId id) { return std::get<Note>(truth(id)).text; }

 private:
  unsigned news_ = 0;
};

}  // namespace tandem::client
