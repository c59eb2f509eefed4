#pragma once

// What one person can take back and do again: that person's own changes of entries of the session's document
// and of poses of parts, the last one first.
//
// 1. Taking back is a change like any other, upon the revision in which this person left the entry. Where
//    another has changed the entry since, the server refuses it, and nothing is lost but the step.
// 2. Taking back a step leaves the entry as the step before it had left it. So that step is rebased: it is
//    from then on conditional on the new revision.
// 3. Of a part the epoch stands for the revision: once another has owned the part, it has another epoch.
//
// Network thread.

#include <deque>
#include <optional>

#include "assets/document/document.h"

namespace tandem::client {

class DocumentUndo {
 public:
  static constexpr std::size_t kMaxSteps = 200;

  /// A change that took an entry from the revision `base`, where it had the body `before`, to `after`; or one
  /// that took a part from the pose `worldFromPart`.
  struct Step {
    document::EntryId id = 0;  // 0: of a part
    document::Revision base = 0, after = 0;
    document::Body before{};
    PartId part = kNoPart;
    Pose worldFromPart{};
    bool concernsSame(const Step& other) const { return id == other.id && part == other.part; }
  };
  enum class Direction : std::uint8_t { undo, redo };

  /// This person has changed an entry otherwise than by undo and redo: nothing can be done again any more.
  void changed(Step step);
  /// The step that is next in this direction; null if there is none.
  const Step* next(Direction direction) const;
  /// The change that takes the step back.
  static document::Change changeFor(const Step& step) { return {step.id, step.after, step.before}; }

  /// The next step was taken back: the entry had the body `left`, or the part stood at `stood`, and the
  /// revision is `now`.
  void taken(Direction direction, document::Body left, document::Revision now, const Pose& stood = {});
  /// The next step cannot be taken back any more, and neither can those of its entry before it.
  void drop(Direction direction);

 private:
  std::deque<Step>& steps(Direction direction) { return direction == Direction::undo ? done_ : undone_; }
  void push(Direction direction, Step step);

  std::deque<Step> done_, undone_;  // the last one is the next
};

}  // namespace tandem::client
