#pragma once

// Identifiers of other programs, derived from ours: the same thing has the same identifier in every file, so
// that a file which comes back is known again.

#include <map>
#include <string>

#include "assets/document/entry.h"
#include "assets/scene/scene.h"

namespace tandem::client {

/// The UUID of a name, in lower case: version 8 of RFC 9562, with bits of the BLAKE2b hash of the name.
std::string uuidOf(const std::string& name);
/// The UUID of an entry of the session on a scene. It stays through changes of the entry, and another
/// session on the same scene gives others. `scene`: the hash of the scene package in hexadecimal digits.
std::string uuidOf(const document::Entry& entry, const std::string& scene);

/// The 22 characters of an IFC GUID (ISO 16739, base 64 of its own), made of a name.
std::string ifcGuidOf(const std::string& name);
/// Whether a text has the form of one.
bool isIfcGuid(const std::string& text);

/// The IFC GUIDs of a scene's parts. A part whose name is one already, as IFC converters name nodes, has
/// that; the others have one made of their names, which a later version of the scene keeps.
class PartGuids {
 public:
  explicit PartGuids(const assets::Scene& scene);
  const std::string& guid(PartId part) const { return guids_.at(part); }
  /// The part with this GUID, or kNoPart.
  PartId part(const std::string& guid) const;

 private:
  std::vector<std::string> guids_;  // by part
  std::map<std::string, PartId> parts_;
};

}  // namespace tandem::client
