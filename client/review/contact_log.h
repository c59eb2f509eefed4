#pragma once

// Logs the contacts of a held part, tick by tick and summed up: time, force, impulse, and the work of the
// hand. For reviews of an assembly; allocates.

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

  /// `dt`: s, the period of a tick. `rows`: keep a row a contact for csv().
  ContactLog(const assets::Scene& scene, double dt, bool rows) : scene_(scene), dt_(dt), keepsRows_(rows) {}

  /// Logs one tick: its time (s), the device's pose in the world, and the tick's output. `valid`: the reading
  /// is valid. No work is counted from an invalid reading until the next valid one.
  void note(double time, const Pose& device, bool valid, const haptics::TickOutput& tick);

  /// In the order of the first contact.
  const std::vector<Touched>& touched() const { return touched_; }
  /// Work of the hand against the force that it feels, J: the integral of -force . velocity - torque . spin
  /// by the trapezoidal rule, so that a spring gives 1/2 K d^2. work() includes the weight and inertia of the
  /// part; contactWork() counts only the time in which the part touches anything.
  double work() const { return work_; }
  double contactWork() const { return contactWork_; }
  /// Ticks with as many contacts as a tick can report (haptics::kMaxContacts); weaker ones may be missing.
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
