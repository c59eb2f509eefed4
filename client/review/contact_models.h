#pragma once

// The contact model of each part, and its predicted cost: for `tandem check`.

#include <cstddef>
#include <vector>

#include "assets/base/ids.h"
#include "haptics/scene/part_tolerance.h"

namespace tandem::haptics {
class ContactScene;
}

namespace tandem::client {

/// The model of a part that a hand can take, or that such a part may touch.
struct ContactModel {
  PartId part = kNoPart;
  bool held = false;        // a hand can take it
  bool made = false;        // there is a model; if not, the fields below are unset
  bool byFormula = false;   // made of implicit shapes, whose distance is exact: there is no field
  std::size_t samples = 0;  // contact samples
  std::size_t cells = 0;    // of its distance field
  std::size_t bytes = 0;    // of samples and field, shared by all parts of the same mesh
  double tolerance = 0.0;   // m, required
  haptics::PartTolerance::From toleranceFrom = haptics::PartTolerance::From::scene;
  PartId toleranceOf =
      kNoPart;  // the part whose tolerance counts: this one, or the strictest of its instances
  /// m: the clearance from which the tolerance is derived, between toleranceOf and clearanceTo; 0 if it is
  /// not.
  double clearance = 0.0;
  PartId clearanceTo = kNoPart;
  /// m: bound of the field's error on smooth surfaces; nearer queries use the triangles. By formula:
  /// rounding.
  double fieldError = 0.0;
  double cell = 0.0;             // m, side of the field's smallest cells; 0 without any
  double spacing = 0.0;          // m, between samples of sharp edges
  double sag = 0.0;              // m, how far facets may be off the curved surface that they represent
  bool coarsened = false;        // the allowed memory was too small for the required cells
  double seconds = 0.0;          // to make or read it
  bool cached = false;           // read from the cache
  std::vector<double> trial_us;  // of a held part: ticks of a trial on this machine
};

/// Whether the field is as exact as required.
inline bool meetsTolerance(const ContactModel& model) { return model.fieldError <= model.tolerance; }

/// The models of all parts that can be in contact with a held part, in order of parts; empty if no part can
/// be held. With `trial`, a simulated hand takes each part that can be held and has a model, and moves it by
/// 1 % of its size to and fro along each axis in 180 ticks.
std::vector<ContactModel> contactModels(const haptics::ContactScene& contact, bool trial);

}  // namespace tandem::client
