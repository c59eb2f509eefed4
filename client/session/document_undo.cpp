#include "client/session/document_undo.h"

#include <utility>

#include "assets/base/assert.h"

namespace tandem::client {

void DocumentUndo::push(Direction direction, Step step) {
  std::deque<Step>& all = steps(direction);
  all.push_back(std::move(step));
  if (all.size() > kMaxSteps) all.pop_front();
}

void DocumentUndo::changed(Step step) {
  undone_.clear();
  push(Direction::undo, std::move(step));
}

const DocumentUndo::Step* DocumentUndo::next(Direction direction) const {
  const std::deque<Step>& all = direction == Direction::undo ? done_ : undone_;
  return all.empty() ? nullptr : &all.back();
}

void DocumentUndo::taken(Direction direction, document::Body left, document::Revision now,
                         const Pose& stood) {
  std::deque<Step>& all = steps(direction);
  ASSERT(!all.empty());
  const Step step = std::move(all.back());
  all.pop_back();
  for (Step& earlier : all)
    if (earlier.concernsSame(step) && earlier.after == step.base) earlier.after = now;
  push(direction == Direction::undo ? Direction::redo : Direction::undo,
       {step.id, step.after, now, std::move(left), step.part, stood});
}

void DocumentUndo::drop(Direction direction) {
  ASSERT(!steps(direction).empty());
  const Step last = steps(direction).back();
  std::erase_if(steps(direction), [&](const Step& step) { return step.concernsSame(last); });
}

}  // namespace tandem::client
