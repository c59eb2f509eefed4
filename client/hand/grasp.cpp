#include "client/hand/grasp.h"

#include "assets/base/assert.h"

namespace tandem::client {

Grasp::Button Grasp::setButton(bool down) {
  if (down == buttonDown_) return Button::unchanged;
  buttonDown_ = down;
  return down ? Button::pressed : Button::lifted;
}

void Grasp::ask(PartId part) {
  ASSERT(stage_ == Stage::reaching);
  stage_ = Stage::asking;
  part_ = part;
}

void Grasp::take(const sync::PartRecord& grant, sync::Micros until) {
  ASSERT(stage_ == Stage::reaching || stage_ == Stage::asking);
  stage_ = Stage::taking;
  part_ = grant.part;
  grant_ = grant;
  takingUntil_ = until;
}

bool Grasp::hold(PartId part) {
  ASSERT(stage_ != Stage::holding);
  stage_ = buttonDown_ ? Stage::holding : Stage::reaching;
  part_ = part;
  return buttonDown_;
}

}  // namespace tandem::client
