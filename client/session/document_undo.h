#pragma once

// What one person can take back in the session's document, and do again: that person's own changes, the last
// one first.
//
// 1. Taking back is a change like any other, upon the revision in which this person left the entry. Where
//    another has changed the entry since, the server refuses it, and nothing is lost but the step.
// 2. Taking back a step leaves the entry as the step before it had left it. So that step is rebased: it is
//    from then on conditional on the new revision.
//
// Network thread.

#include <deque>
#include <optional>

#include "assets/document/document.h"

namespace tandem::client {

class DocumentUndo {
 public:
  static constexpr std::size_t kMaxSteps = 200;

  /// A change that took an entry from the revision `base`, where it had the body `before`, to `after`.
  struct Step {
    document::EntryId id = 0;
    document::Revision base = 0, after = 0;
    document::Body before;
  };
  enum class Direction : std::uint8_t { undo, redo };

  /// This person has changed an entry otherwise than by undo and redo: nothing can be done again any more.
  void changed(Step step);
  /// The step that is next in this direction; null if there is none.
  const Step* next(Direction direction) const;
  /// The change that takes the step back.
  static document::Change changeFor(const Step& step) { return {step.id, step.after, step.before}; }

  /// The next step was taken back: the entry had the body `left`, and has the revision `now`.
  void taken(Direction direction, document::Body left, document::Revision now);
  /// The next step cannot be taken back any more, and neither can those of its entry before it.
  void drop(Direction direction);

 private:
  std::deque<Step>& steps(Direction direction) { return direction == Direction::undo ? done_ : undone_; }
  void push(Direction direction, Step step);

  std::deque<Step> done_, undone_;  // the last one is the next
};

}  // namespace tandem::client
