#pragma once

// What other libraries offer for the contact of two meshes, behind one face. Each stands in a file of its
// own, which is built where the library is installed.

#include <memory>
#include <string>

#include "assets/base/pose.h"
#include "assets/scene/scene.h"

namespace tandem::bench {

/// The contacts of one pose.
struct PeerContacts {
  int count = 0;
  double depth = 0.0;  // m, of the deepest
  glm::dvec3 normal{0.0, 0.0,
                    0.0};  // of all, weighed by depth; away from the part that stands still, not normalised
};

class PartPeer {
 public:
  virtual ~PartPeer() = default;
  virtual std::string id() const = 0;
  virtual std::string name() const = 0;
  virtual std::string version() const = 0;
  /// The contacts of the held mesh at a pose with the other one at the origin: what is timed.
  virtual PeerContacts contacts(const Pose& worldFromHeld) = 0;
};

/// Each builds what the library searches; null where the library was not there when this was built. The
/// meshes must outlive the result.
std::unique_ptr<PartPeer> fclPartPeer(const assets::Mesh& held, const assets::Mesh& other);
std::unique_ptr<PartPeer> bulletPartPeer(const assets::Mesh& held, const assets::Mesh& other);
std::unique_ptr<PartPeer> odePartPeer(const assets::Mesh& held, const assets::Mesh& other);

}  // namespace tandem::bench
