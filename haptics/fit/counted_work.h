#pragma once

// Work that is counted, so that what takes longer than a tick is done in portions that depend on no clock:
// the same inputs, the same bits.

namespace tandem::haptics {

/// A portion of work, in units of some 50 ns.
class CountedWork {
 public:
  // What a piece of work costs, in units; measured on parts of an engine.
  static constexpr int kReading = 1;  // of a field
  static constexpr int kShift = 8;    // of a sample by an interference fit, with the reading there
  static constexpr int kQuery = 40;   // of the exact distance to a mesh
  static constexpr int kTouch = 60;   // of the exact contact of a sample, with a descent or without

  static constexpr int kLargest = 3200;  // no piece of work takes more
  /// Work that pauses once `units` are spent, or, in a hurry, goes on without what can be done without.
  explicit CountedWork(int units, bool hurried = false) : left_(units), hurried_(hurried) {}

  /// Whether this much is left.
  bool affords(int units) const { return units <= left_; }
  /// Whether a piece of work that cannot be left out has to wait for the next portion.
  bool pauses(int units) const { return !hurried_ && !affords(units); }
  bool hurried() const { return hurried_; }
  void spend(int units) {
    left_ -= units;
    spent_ += units;
  }
  int spent() const { return spent_; }

 private:
  int left_, spent_ = 0;
  bool hurried_;
};

}  // namespace tandem::haptics
