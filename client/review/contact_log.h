#pragma once

// What a part in the hand touches while it is moved, tick by tick and summed up: for how long, how hard, what impulse,
// and what work the hand did. For reviews of an assembly; allocates.

#include <cstdint>
#include <string>
#include <vector>

#include "haptics/tick.h"

namespace tandem::client {

class ContactLog {
 public:
  /// Sums over all ticks with one other part.
  struct Touched {
    PartId part = kNoPart;
    std::uint64_t ticks = 0;
    double largestForce = 0.0;  // N, along the normals, all contacts with the part together
    double impulse = 0.0;       // N·s, the same over time
  };

  /// `dt` in s; `rows`: whether to keep a row a contact for csv().
  ContactLog(const assets::Scene& scene, double dt, bool rows) : scene_(scene), dt_(dt), keepsRows_(rows) {}

  /// One tick: its time (s), where the device was, world, and what the tick answered. `valid`: the device told where it
  /// is; where not, no work is counted until it does again.
  void note(double time, const Pose& device, bool valid, const haptics::TickOutput& tick);

  /// In the order in which they were first touched.
  const std::vector<Touched>& touched() const { return touched_; }
  /// Work that the hand did against what it felt, J: the integral of -force . velocity and -torque . spin, between ticks
  /// with the mean of both ends, so that a spring gives 1/2 K d^2. In all, with weight and inertia of the part; and
  /// while the part touched anything.
  double work() const { return work_; }
  double contactWork() const { return contactWork_; }
  /// Ticks with as many contacts as a tick tells (haptics::kMaxContacts): there may have been weaker ones.
  std::uint64_t fullTicks() const { return fullTicks_; }
  /// t,part,px,py,pz,nx,ny,nz,force: a row a contact, SI, world; the normal points away from `part`.
  std::string csv() const;

 private:
  struct Row {
    double time = 0.0;
    haptics::Contact contact;
  };
  Touched& entryOf(PartId part);

  const assets::Scene& scene_;
  double dt_;
  bool keepsRows_;
  std::vector<Row> rows_;
  std::vector<Touched> touched_;
  std::vector<double> forceNow_;  // N, of this tick, one an entry of touched_
  double work_ = 0.0, contactWork_ = 0.0;
  std::uint64_t fullTicks_ = 0;
  bool started_ = false, touching_ = false;
  Pose device_;
  Wrench toHand_;
};

/// A part's name as one cell of a CSV file: file formats allow commas, quotes and more in it.
std::string csvCell(const std::string& name);

}  // namespace tandem::client
