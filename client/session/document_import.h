#pragma once

// Brings the entries of a document file into a session, at a pace that the server allows.
//
// 1. An entry that the session has already, with the same body, is not made again: an import that was broken
//    off may be repeated.
// 2. An entry with a revision is the session's own, as it shall be: a change upon that revision, unless it
// is so
//    already. The ids of the others are the file's, and none of the session's.
// 3. References between entries of the file are kept. An entry whose note was refused is refused too.

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "assets/document/document.h"
#include "sync/wire/document_messages.h"
#include "sync/wire/time.h"

namespace tandem::client {

class DocumentImport {
 public:
  /// Messages a second that it sends; a long one counts for more, as at the server.
  static constexpr double kRate = 150.0;

  /// `there`: the document of the session. `entries` in the order of a DocumentFile.
  DocumentImport(const document::Document& there, std::vector<document::Entry> entries);

  /// The next message, if one may leave at local time `now`.
  std::optional<sync::PutEntry> next(sync::Micros now);
  void handle(const sync::PutReply& reply);

  bool done() const { return next_ == entries_.size() && open_.empty(); }
  double progress() const;  // 0..1
  std::size_t made() const { return made_; }
  std::size_t changed() const { return changed_; }  // of the session's
  std::size_t known() const { return known_; }      // that the session had already
  std::size_t refused() const { return refused_; }
  const std::string& reason() const { return reason_; }  // of the first refusal

 private:
  static constexpr std::size_t kMaxOpen = 128;  // that wait for their answers

  bool ready(const document::Entry& entry) const;
  void settle(document::EntryId inFile, document::EntryId inSession);
  void refuse(document::EntryId inFile, const std::string& reason);

  std::vector<document::Entry> entries_;
  std::size_t next_ = 0;
  std::map<std::string, document::EntryId> there_;                  // by the bytes of the body
  std::map<document::EntryId, document::EntryId> sessionFromFile_;  // 0: refused
  std::map<sync::RequestId, std::size_t> open_;                     // index of the entry
  sync::RequestId lastRequest_ = 0;
  double allowance_ = kRate;
  std::optional<sync::Micros> at_;         // when it was computed
  std::set<document::EntryId> unchanged_;  // entries of the session that are so already
  std::size_t made_ = 0, changed_ = 0, known_ = 0, refused_ = 0;
  std::string reason_;
};

}  // namespace tandem::client
