#include "client/session/session_document.h"

#include <utility>

#include "assets/base/assert.h"
#include "client/session/document_words.h"

namespace tandem::client {

using document::Body;
using document::Change;
using document::Entry;
using document::EntryId;
using document::Refusal;
using document::Removed;
using Kind = DocumentWish::Kind;
using Direction = DocumentUndo::Direction;

namespace {

Direction directionOf(Kind kind) {
  ASSERT(kind != Kind::change);
  return kind == Kind::undo ? Direction::undo : Direction::redo;
}

/// What a wish is about: a change by what the entry will be, a reversal by what it is; removed says nothing.
std::string subject(Kind kind, const Body& before, const Body& after) {
  const Body& first = kind == Kind::change ? after : before;
  const Body& second = kind == Kind::change ? before : after;
  return inWords(std::holds_alternative<Removed>(first) ? second : first);
}

}  // namespace

// ---- what the server tells ----

bool SessionDocument::withinLimits() const {
  return content().size() <= document::kMaxEntries && content().bytes() <= document::kMaxBytes;
}

bool SessionDocument::handle(const sync::DocumentChunk& message) {
  replica_.handle(message);
  if (message.first) {
    news_ = {true, {}};
    for (const auto& [revision, id] : content().byRevision()) tell(*content().find(id));
  } else {
    for (const Entry& entry : message.entries) tell(entry);
  }
  return withinLimits();
}

bool SessionDocument::handle(const sync::DocumentChanged& message) {
  replica_.handle(message);
  tell(message.entry);
  return withinLimits();
}

DocumentNews SessionDocument::drainNews() { return std::exchange(news_, {}); }

void SessionDocument::enter() {
  inSession_ = true;
  sender_.send(replica_.request());
}

void SessionDocument::connectionLost() {
  inSession_ = false;
  replica_.connectionLost();
  if (open_) open_->sent = false;
  if (placing_) notPlaced("the connection is lost");
}

DocumentStanding SessionDocument::standing() const {
  DocumentStanding standing{replica_.complete(), waiting_.size() + (open_ ? 1 : 0), {}, {}};
  if (const DocumentUndo::Step* step = undo_.next(Direction::undo)) standing.undo = words(*step);
  if (const DocumentUndo::Step* step = undo_.next(Direction::redo)) standing.redo = words(*step);
  return standing;
}

std::string SessionDocument::words(const DocumentUndo::Step& step) const {
  if (step.part != kNoPart) return "move of " + scene_->parts[step.part].name;
  const Entry* entry = content().find(step.id);
  return subject(Kind::undo, entry == nullptr ? Body{} : entry->body, step.before);
}

// ---- what the person wants ----

void SessionDocument::want(DocumentWish wish) {
  if (waiting_.size() < kMaxWaiting) return waiting_.push_back(std::move(wish));
  people_.notice(Notice::Level::warning, "not done: too many changes wait for the server");
}

void SessionDocument::step(sync::Micros now) {
  ASSERT(inSession_);
  now_ = now;
  // What was done is seen here before the next change is made upon it.
  if (open_ && open_->answer != 0 && replica_.complete() && content().revision() >= open_->answer)
    open_.reset();
  if (placing_ && now > placing_->until) notPlaced("the part cannot be had");
  noteMoves();
  if (!busy() && replica_.complete()) begin();
  if (!open_ || open_->sent || open_->answer != 0 || now < open_->notBefore) return;
  open_->sent = true;
  open_->notBefore = now + kAgain;
  sender_.send(open_->request);
}

/// Takes wishes from the line until one is under way.
void SessionDocument::begin() {
  while (!busy() && !waiting_.empty()) {
    DocumentWish wish = std::move(waiting_.front());
    waiting_.pop_front();
    if (wish.kind == Kind::change)
      beginChange(std::move(wish.change));
    else
      beginReversal(wish.kind);
  }
}

void SessionDocument::beginChange(Change change) {
  Body before;
  if (const Entry* entry = content().find(change.id)) {
    before = entry->body;
    if (entry->revision != change.base)
      return refuse(Kind::change, change, before, whoChanged(change.id) + " has changed it since");
  }
  open(Kind::change, std::move(change), std::move(before));
}

void SessionDocument::beginReversal(Kind kind) {
  const DocumentUndo::Step* step = undo_.next(directionOf(kind));
  if (step == nullptr) {
    people_.notice(Notice::Level::info, kind == Kind::undo ? "nothing to undo" : "nothing to redo");
    return;
  }
  if (step->part != kNoPart) return place(kind, *step);
  const Entry* entry = content().find(step->id);
  Change change = DocumentUndo::changeFor(*step);
  if (entry == nullptr || entry->revision != step->after) {
    const std::string why = entry == nullptr ? std::string("it is no longer there")
                                             : whoChanged(step->id) + " has changed it since";
    refuse(kind, change, entry == nullptr ? Body{} : entry->body, why);
    undo_.drop(directionOf(kind));
    return;
  }
  open(kind, std::move(change), entry->body);
}

void SessionDocument::open(Kind kind, Change change, Body before) {
  ASSERT(!open_);
  open_ = Open{kind, {++lastRequest_, std::move(change)}, std::move(before), 0, false, 0};
}

std::string SessionDocument::whoChanged(EntryId id) const {
  const Entry* entry = content().find(id);
  return entry == nullptr ? "another" : people_.nameOf(entry->editor);
}

// ---- poses ----

void SessionDocument::sceneReady(const assets::Scene& scene, HandEvents& events) {
  scene_ = &scene;
  events_ = &events;
}

void SessionDocument::onOwnership(const sync::PartRecord& record) {
  moves_.onOwnership(record, people_.self());
}

void SessionDocument::onRelease(const sync::Release& release) {
  std::optional<DocumentUndo::Step> step = moves_.onRelease(release);
  if (placing_ && placing_->part == release.part && placing_->epoch == release.epoch) return placed(release);
  if (step) moved_.push_back(std::move(*step));
}

/// Steps that came about while another was under way are added once it is not.
void SessionDocument::noteMoves() {
  for (; !busy() && !moved_.empty(); moved_.pop_front()) undo_.changed(std::move(moved_.front()));
}

/// Lets the hand move a part back that nobody has owned since this person released it.
void SessionDocument::place(Kind kind, const DocumentUndo::Step& step) {
  const sync::PartRecord* record = moves_.record(step.part);
  ASSERT(record != nullptr && events_ != nullptr);
  const auto after = static_cast<Epoch>(step.after);
  placing_ = Placing{kind, step.part, after + 1, record->worldFromPart, now_ + kPlacing};
  if (record->owner != kNoSite) return notPlaced(people_.nameOf(record->owner) + " holds it");
  if (record->epoch != after) return notPlaced("another has moved it since");
  NetworkEvent event;
  event.kind = NetworkEvent::Kind::place;
  event.record = {step.part, kNoSite, after, step.worldFromPart};
  events_->push(event);
}

void SessionDocument::placed(const sync::Release& release) {
  const Placing was = *std::exchange(placing_, {});
  people_.notice(Notice::Level::info, std::string(was.kind == Kind::undo ? "undone: " : "done again: ") +
                                          words(*undo_.next(directionOf(was.kind))));
  undo_.taken(directionOf(was.kind), {}, release.epoch, was.stood);
}

void SessionDocument::notPlaced(const std::string& why) {
  const Placing was = *std::exchange(placing_, {});
  const char* verb = was.kind == Kind::undo ? "not undone: " : "not done again: ";
  people_.notice(Notice::Level::warning, verb + words(*undo_.next(directionOf(was.kind))) + ": " + why);
  undo_.drop(directionOf(was.kind));
}

// ---- answers ----

bool SessionDocument::handle(const sync::PutReply& message) {
  if (!open_ || open_->answer != 0 || message.request != open_->request.request) return false;
  if (message.refusal == Refusal::none) {
    const EntryId changed = open_->request.change.id;
    if (message.entry == 0 || message.revision == 0 || (changed != 0 && message.entry != changed))
      return false;
    done(message);
  } else if (message.refusal == Refusal::notNow) {
    open_->sent = false;  // sent again after kAgain
  } else {
    refused(message.refusal, message.reason);
  }
  return true;
}

void SessionDocument::done(const sync::PutReply& reply) {
  open_->answer = reply.revision;
  const Change& change = open_->request.change;
  if (open_->kind == Kind::change) {
    // Later wishes of this person that were made upon the same revision know of this change.
    for (DocumentWish& wish : waiting_)
      if (change.id != 0 && wish.change.id == change.id && wish.change.base == change.base)
        wish.change.base = reply.revision;
    undo_.changed({reply.entry, change.base, reply.revision, open_->before});
    return;
  }
  people_.notice(Notice::Level::info, std::string(open_->kind == Kind::undo ? "undone: " : "done again: ") +
                                          subject(open_->kind, open_->before, change.body));
  undo_.taken(directionOf(open_->kind), open_->before, reply.revision);
}

void SessionDocument::refused(Refusal refusal, const std::string& reason) {
  const Open was = *std::exchange(open_, {});
  const bool overtaken = refusal == Refusal::changedSince;
  refuse(was.kind, was.request.change, was.before, overtaken ? "another has changed it since" : reason);
  if (was.kind != Kind::change) undo_.drop(directionOf(was.kind));
}

void SessionDocument::refuse(Kind kind, const Change& change, const Body& before, const std::string& why) {
  const char* verb = kind == Kind::change ? "not done" : kind == Kind::undo ? "not undone" : "not done again";
  people_.notice(Notice::Level::warning,
                 std::string(verb) + ": " + subject(kind, before, change.body) + ": " + why);
}

}  // namespace tandem::client
