#include "client/session/document_import.h"

#include <algorithm>
#include <utility>

#include "assets/document/entry_check.h"
#include "sync/wire/document_codec.h"

namespace tandem::client {
namespace {

using document::EntryId;

constexpr double kBytesPerMessage = 1024.0;  // as the server counts

std::string bytesOf(const document::Entry& entry) {
  const std::vector<std::uint8_t> bytes = sync::encodeBody(entry.body);
  return {bytes.begin(), bytes.end()};
}

}  // namespace

DocumentImport::DocumentImport(const document::Document& there, std::vector<document::Entry> entries)
    : entries_(std::move(entries)) {
  for (const auto& [id, entry] : there.entries())
    if (!entry.removed()) there_.emplace(bytesOf(entry), id);
  for (const document::Entry& entry : entries_) {
    const document::Entry* old = entry.revision == 0 ? nullptr : there.find(entry.id);
    if (old != nullptr && bytesOf(*old) == bytesOf(entry)) unchanged_.insert(entry.id);
  }
}

/// Whether what the entry refers to has been answered.
bool DocumentImport::ready(const document::Entry& entry) const {
  const EntryId note = document::reference(entry.body);
  return note == 0 || sessionFromFile_.contains(note);
}

void DocumentImport::settle(EntryId inFile, EntryId inSession) { sessionFromFile_[inFile] = inSession; }

void DocumentImport::refuse(EntryId inFile, const std::string& reason) {
  ++refused_;
  settle(inFile, 0);
  if (reason_.empty()) reason_ = reason;
}

std::optional<sync::PutEntry> DocumentImport::next(sync::Micros now) {
  if (at_) allowance_ = std::min(kRate, allowance_ + sync::toSeconds(now - *at_) * kRate);
  at_ = now;
  while (allowance_ >= 1.0 && open_.size() < kMaxOpen && next_ < entries_.size() && ready(entries_[next_])) {
    document::Entry& entry = entries_[next_];
    const bool changes = entry.revision != 0;
    if (changes && unchanged_.contains(entry.id)) {
      ++known_;
      settle(entry.id, entry.id);
      ++next_;
      continue;
    }
    if (auto* comment = std::get_if<document::Comment>(&entry.body)) {
      const EntryId note = sessionFromFile_.at(comment->note);
      if (note == 0) {
        refuse(entry.id, "its note was refused");
        ++next_;
        continue;
      }
      comment->note = note;
    }
    const std::string bytes = bytesOf(entry);
    if (const auto same = there_.find(bytes); !changes && same != there_.end()) {
      ++known_;
      settle(entry.id, same->second);
      ++next_;
      continue;
    }
    allowance_ -= 1.0 + static_cast<double>(bytes.size()) / kBytesPerMessage;
    open_[++lastRequest_] = next_;
    ++next_;
    return sync::PutEntry{lastRequest_, {changes ? entry.id : 0, entry.revision, entry.body}};
  }
  return std::nullopt;
}

void DocumentImport::handle(const sync::PutReply& reply) {
  const auto asked = open_.find(reply.request);
  if (asked == open_.end()) return;
  const document::Entry& entry = entries_[asked->second];
  open_.erase(asked);
  if (reply.refusal == document::Refusal::none) {
    ++(entry.revision == 0 ? made_ : changed_);
    settle(entry.id, reply.entry);
  } else {
    refuse(entry.id, reply.reason);
  }
}

double DocumentImport::progress() const {
  if (entries_.empty()) return 1.0;
  return static_cast<double>(made_ + changed_ + known_ + refused_) / static_cast<double>(entries_.size());
}

}  // namespace tandem::client
