#pragma once

// The grasp of one hand as a state machine:
//
// reaching -button down on a part-> asking -granted-> taking -the replica is in place-> holding -button up->
// reaching
//
// A part that this site simulates already goes from reaching to holding at once; one whose owner shares it
// goes from asking to holding. A denial, a lost connection or a part that is taken away lead back to
// reaching, and so does a button that is up by the time at which the hand would hold.
//
// It knows neither the tick nor the network: Grasps carries out what its states demand. Haptic thread.

#include <cstdint>

#include "sync/wire/ownership_messages.h"
#include "sync/wire/time.h"

namespace tandem::client {

class Grasp {
 public:
  enum class Stage : std::uint8_t {
    reaching,  // the hand holds nothing and waits for nothing
    asking,    // the server has been asked for part()
    taking,    // part() is granted, and its replica moves to where the grant has it
    holding,   // part() is coupled to the device
  };
  enum class Button : std::uint8_t { unchanged, pressed, lifted };

  Stage stage() const { return stage_; }
  /// What the hand asks for, takes or holds.
  PartId part() const { return part_; }
  bool is(Stage stage, PartId part) const { return stage_ == stage && part_ == part; }
  bool isPending() const { return stage_ == Stage::asking || stage_ == Stage::taking; }
  /// Whether the hand still wants what it asked for.
  bool buttonIsDown() const { return buttonDown_; }

  /// Notes the button, once a tick, and returns what it did.
  Button setButton(bool down);

  /// From reaching: the server has been asked for the part.
  void ask(PartId part);
  /// Not from holding: the part is granted; its replica has until `until` to be in place.
  void take(const sync::PartRecord& grant, sync::Micros until);
  /// The part is simulated here now. True if the hand holds it; if the button is up by now, the hand reaches
  /// again.
  bool hold(PartId part);
  /// Back to reaching, whatever the stage.
  void end() { stage_ = Stage::reaching; }

  /// While taking.
  const sync::PartRecord& grant() const { return grant_; }
  sync::Micros takingUntil() const { return takingUntil_; }

 private:
  Stage stage_ = Stage::reaching;
  PartId part_ = kNoPart;
  bool buttonDown_ = false;
  sync::PartRecord grant_;
  sync::Micros takingUntil_ = 0;
};

}  // namespace tandem::client
