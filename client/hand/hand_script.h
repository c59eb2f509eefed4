#pragma once

// What a scripted person does: a list of timed verbs, as in a simulation scenario or in `tandem join --hand
// FILE`.
//
//   [{"t": 0.5, "do": "grasp", "part": "shaft"}, {"t": 1.5, "do": "move_relative", "by": [0.1, 0, 0],
//   "over_s": 1}, ...]
//
// Verbs (t in s; lengths in m; angles in rad; motions are minimum-jerk, Flash & Hogan 1985):
//   grasp {part [, over_s]}   the hand goes to the part's surface, then the grasp button goes down
//   release                   the grasp button goes up
//   move {to, over_s}         the target goes to a place in the world
//   move_relative {by, over_s}
//   turn {axis, angle, over_s}
//   sine {axis, amplitude, hz, for_s}
//   set {control, value}      asks for a control (its own or its part's name), gives it a value (m, rad)
//   hold                      the target is where the hand is
//   press {part, depth [, over_s]}
//                             the target goes to `depth` inside the nearest point of that part's surface
//   let_go                    the person lets go of the stylus; what it has latched stays
// and, in the session's document (script_writer.h; `tandem simulate` passes over them):
//   note {text [, part]}      pins a note to the place that is touched, or to the nearest one of that part
//   reply {text [, to]}       answers the note whose text begins so, or the last one
//   status {status [, to]}    that note is now open, in progress, resolved or closed
//   view {name}               keeps what this site sees: camera, sections, hidden parts, how parts are drawn
//   measure {measures [, at, parts, name]}
//                             keeps a length, diameter, distance, across, angle or clearance at places in the
//                             world or of two named parts; a missing place is where the hand is
//   find_clashes              searches for clashes of the parts as they stand, and keeps them with a status
//   judge {parts, status [, text]}
//                             that clash is now new, active, reviewed, approved or resolved
//   undo, redo                takes back what this person wrote last; writes it again
// and, for the others in the session (join/headless_view.h; passed over likewise):
//   section {planes}          this site's section planes, each [nx, ny, nz, m]: what lies further than that
//                             in this direction is cut away
//   share {what}              the others follow sections, or view (sections, hidden parts, how parts are
//                             drawn, selection and camera); nothing ends it
//   follow {what}             what others share is followed here: view (all of it), or nothing
//   hide {parts}              this site's hidden parts
//   explode {factor [, parts]}
//                             parts are drawn apart, 0..1: all, or these; nothing is felt meanwhile
//   colour {what}             parts are coloured by body, material or owner, or as made
//   ghosts {on}               hidden parts are seen faintly
//   select {part}
//   inspect [{parts} {at}]    two parts whose clash is looked at, and places in the world, at most two, that
//                             are measured; without either no more
//   look {from, to}           this site's camera
//   point [{part}]            shows the others the place of that part that is nearest to the hand; without
//                             a part no more
//   say {text}                a short message to all; [NAME] is a link to a part

#include <string>
#include <vector>

#include "assets/base/result.h"
#include "assets/document/entry.h"
#include "assets/scene/scene.h"
#include "client/findings/figures.h"
#include "client/session/exchange.h"
#include "haptics/operator/simulated_hand.h"
#include "sync/wire/presentation_messages.h"

namespace tandem::client {

/// Lengths in scripts and scenarios beyond this are mistakes, m.
inline constexpr double kFarthest = 1e6;

struct ScriptStep {
  enum class Verb : std::uint8_t {
    grasp,
    release,
    move,
    moveRelative,
    turn,
    sine,
    hold,
    press,
    letGo,
    set,
    note,  // the first of those that write in the document
    reply,
    status,
    view,
    measure,
    findClashes,
    judge,
    undo,
    redo,
    section,  // the first of those that the others see
    share,
    follow,
    hide,
    explode,
    colour,
    ghosts,
    select,
    inspect,
    look,
    point,
    say
  };
  double at = 0.0;  // s
  Verb verb = Verb::hold;
  PartId part = kNoPart;
  glm::dvec3 vector{0.0, 0.0, 0.0};  // to, by, or axis (unit)
  double over = 0.0;                 // s: over_s, for_s
  double amount = 0.0;               // angle, amplitude, depth or value
  double hz = 0.0;
  std::string text, to;  // of a verb that writes; a view's name is its text
  document::NoteStatus status = document::NoteStatus::open;  // of the verb `status`
  FigureKind figure = FigureKind::distance;                  // of the verb `measure`, and its places
  std::vector<glm::dvec3> places;
  std::vector<PartId> parts;                                   // of `judge`, `hide` and `explode`, too
  document::PartStyle style;                                   // of `explode`, `colour` and `ghosts`
  sync::Inspection inspection;                                 // of `inspect`, once it has come
  document::ClashStatus clash = document::ClashStatus::fresh;  // of the verb `judge`
  std::vector<document::SectionPlane> planes;
  glm::dvec3 from{0.0, 0.0, 0.0};               // of a camera
  sync::Shares shares = sync::Shares::nothing;  // of `share` and `follow`

  /// Whether it is done by the main thread, for the document or the others, and not by the hand.
  bool writes() const { return verb >= Verb::note; }
  bool shows() const { return verb >= Verb::section; }
};

struct HandScript {
  std::vector<ScriptStep> steps;  // in the order of their times
  double toolRadius = 0.0;        // m, of the ball that the person touches surfaces with
};

/// Reads the JSON text of a script. An error names `source`, the step and the reason.
Result<HandScript> parseHandScript(const std::string& json, const std::string& source,
                                   const assets::Scene& scene);
/// Checks a script before its scene is known: everything but whether its parts and controls exist.
Status checkHandScript(const std::string& path);
Result<HandScript> loadHandScript(const std::string& path, const assets::Scene& scene);

/// Nearest point of a part's surface (its mesh, or else its shapes) to a point, world frame, with
/// outward normal.
struct SurfacePoint {
  glm::dvec3 point{0.0, 0.0, 0.0};
  glm::dvec3 normal{0.0, 1.0, 0.0};
};
SurfacePoint nearestSurfacePoint(const assets::Scene& scene, PartId part, const Pose& worldFromPart,
                                 const glm::dvec3& from);

/// Plays a script: where the person aims at each instant, and what the fingers do.
class ScriptedPerson {
 public:
  ScriptedPerson(const assets::Scene& scene, HandScript script, const Pose& worldFromStart);

  struct Intent {
    haptics::HandTarget target;
    bool graspButton = false;
    PartId wish = kNoPart;
    ControlWish control;        // of the last `set`
    std::uint32_t written = 0;  // steps so far that the main thread does
  };
  /// At time t in s, not going back; `worldFromHand` is where the device is, `worldFromPart(id)` where parts
  /// are.
  template <typename WorldFromPart>
  Intent at(double t, const Pose& worldFromHand, const WorldFromPart& worldFromPart) {
    while (next_ < script_.steps.size() && script_.steps[next_].at <= t) {
      const ScriptStep& step = script_.steps[next_++];
      begin(step, worldFromHand, step.part == kNoPart ? Pose{} : worldFromPart(step.part));
    }
    return evaluate(t);
  }

  /// Whether no step is left and no motion goes on at time t.
  bool finished(double t) const { return next_ == script_.steps.size() && t >= motionStart_ + motionLength_; }

 private:
  enum class Motion : std::uint8_t { still, straight, turn, sine };
  void begin(const ScriptStep& step, const Pose& worldFromHand, const Pose& worldFromPart);
  void moveTo(const Pose& goal, double start, double over);
  Intent evaluate(double t);

  const assets::Scene& scene_;
  HandScript script_;
  std::size_t next_ = 0;
  Motion motion_ = Motion::still;
  Pose from_, to_;  // of the present motion
  glm::dvec3 axis_{0.0, 0.0, 0.0};
  double motionStart_ = 0.0, motionLength_ = 0.0, amount_ = 0.0, hz_ = 0.0;
  bool holdsStylus_ = true, button_ = false;
  PartId wish_ = kNoPart;
  ControlWish control_;
  std::uint32_t written_ = 0;
  double buttonDownAt_ = -1.0;  // a grasp's button waits for the hand to arrive
};

}  // namespace tandem::client
