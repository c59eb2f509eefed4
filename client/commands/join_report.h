#pragma once

// What `tandem join` writes down of a run: its JSON, and the poses of parts as the site has them.

#include <fstream>
#include <string>
#include <vector>

#include "client/join/headless_view.h"
#include "client/join/joined_site.h"

namespace tandem::client {

/// Ownership and grabs over the run, for --json.
struct JoinReport {
  std::vector<OwnershipNote> ownership;
  std::vector<GrabNote> grabs;
  int faultClears = 0;
  double modelSeconds = 0.0;  // until held parts could collide
  void collect(JoinedSite& site) {
    for (OwnershipNote& note : site.drainOwnershipNotes()) ownership.push_back(note);
    for (GrabNote& note : site.drainGrabNotes()) grabs.push_back(note);
  }
};

/// The value of --json; `end` says why the run ended, `view` is null for a site with a window.
std::string reportJson(JoinedSite& site, const ViewModel& model, const JoinReport& report,
                       const HeadlessView* view, const std::string& end);

/// Writes the poses of all parts at this site, one row a part, to be compared with those of other sites.
class PoseTrace {
 public:
  explicit PoseTrace(const std::string& path);
  bool good() const { return file_.good(); }
  void add(const ShownPose& shown, const assets::Scene& scene);

 private:
  std::ofstream file_;
};

}  // namespace tandem::client
