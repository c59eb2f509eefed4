#pragma once

// What the contact of parts in the hand is computed with, part by part, and what it is going to cost: for
// `tandem check`.

#include <cstddef>
#include <vector>

#include "assets/base/ids.h"
#include "haptics/scene/part_tolerance.h"

namespace tandem::haptics {
class ContactScene;
}

namespace tandem::client {

/// One part that a hand can take, or that such a part may touch.
struct ContactModel {
  PartId part = kNoPart;
  bool held = false;  // a hand can take it
  bool made = false;  // there is a model; else only the first three are known
  bool byFormula =
      false;  // it consists of implicit shapes, whose distance is known exactly: there is no field
  std::size_t samples = 0;  // points with which it can touch first
  std::size_t cells = 0;    // of its field
  std::size_t bytes = 0;    // of both, shared with all parts of the same mesh
  double tolerance = 0.0;   // m, asked for
  haptics::PartTolerance::From toleranceFrom = haptics::PartTolerance::From::scene;
  double clearance = 0.0;        // m, that the tolerance is a share of, if it is
  PartId clearanceTo = kNoPart;  // between which parts that is: this one, or the instance that decides, and
  PartId toleranceOf =
      kNoPart;  // the part whose tolerance counts: this one, or the strictest of its instances
  double fieldError =
      0.0;            // m, proven for smooth surfaces; what is nearer is asked of the triangles. By formula:
                      // what rounding costs
  double cell = 0.0;  // m, side of the field's smallest cells; 0 without any
  double spacing = 0.0;          // m, between samples of sharp edges
  double sag = 0.0;              // m, how far facets may be off the curved surface that they stand for
  bool coarsened = false;        // the memory allowed was too small for the cells asked for
  double seconds = 0.0;          // that making or reading it took
  bool cached = false;           // read from the cache
  std::vector<double> trial_us;  // of a held part: ticks of a trial on this machine
};

/// Whether the field is as exact as asked for.
inline bool meetsTolerance(const ContactModel& model) { return model.fieldError <= model.tolerance; }

/// Of all parts that take part in contact of held parts, in their order; empty where nobody can take any.
/// With `trial`, a hand takes each part that can be held and has a model, where it stands, and draws it 1 % of
/// its size to and fro along each axis, at about a part's length a second: 180 ticks.
std::vector<ContactModel> contactModels(const haptics::ContactScene& contact, bool trial);

}  // namespace tandem::client
