#include "client/hand/script_writer.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

#include "assets/base/assert.h"
#include "client/findings/verdicts.h"
#include "client/review/clash_search.h"
#include "client/session/document_words.h"
#include "client/session/shown_clash.h"

namespace tandem::client {

using namespace document;
using Verb = ScriptStep::Verb;

namespace {

/// The newest note whose text begins so; null if there is none.
const Entry* noteThatBegins(const Document& document, const std::string& text) {
  const auto& entries = document.entries();
  const auto found = std::find_if(entries.rbegin(), entries.rend(), [&](const auto& each) {
    const Note* note = std::get_if<Note>(&each.second.body);
    return note != nullptr && note->text.compare(0, text.size(), text) == 0;
  });
  return found == entries.rend() ? nullptr : &found->second;
}

bool answers(Verb verb) { return verb == Verb::reply || verb == Verb::status || verb == Verb::judge; }

/// The note or verdict that a step answers; null if there is none.
const Entry* answered(const ScriptStep& step, const Document& document) {
  if (step.verb != Verb::judge) return noteThatBegins(document, step.to);
  const auto verdicts = verdictsByPair(document);
  const auto found = verdicts.find(pairOf(step.parts[0], step.parts[1]));
  return found == verdicts.end() ? nullptr : found->second;
}

std::string missing(const ScriptStep& step) {
  if (step.verb == Verb::judge) return "there is no clash of these parts to judge";
  return "there is no note that begins with \"" + shortened(step.to, 40) + '"';
}

/// `note` is what the step answers, if it answers.
DocumentWish wishOf(const ScriptStep& step, const ViewModel& model, const Camera& camera, const Entry* note) {
  using Kind = DocumentWish::Kind;
  switch (step.verb) {
    case Verb::undo:
      return {Kind::undo, {}};
    case Verb::redo:
      return {Kind::redo, {}};
    case Verb::reply:
      return {Kind::change, {0, 0, Comment{note->id, step.text}}};
    case Verb::status: {
      Note changed = std::get<Note>(note->body);
      changed.status = step.status;
      return {Kind::change, {note->id, note->revision, std::move(changed)}};
    }
    case Verb::judge:
      return {Kind::change, judge(*note, step.clash, {ownName(model), step.text})};
    case Verb::view:
      return {Kind::change,
              {0, 0, NamedView{step.text, worldFromCamera(camera), camera.distance, {}, false, {}, {}}}};
    default:
      ASSERT(step.verb == Verb::note);
      return {Kind::change, {0, 0, noteAtHand(model, step.part, step.text)}};
  }
}

}  // namespace

Note noteAtHand(const ViewModel& model, PartId part, std::string text) {
  Note note;
  note.text = std::move(text);
  note.place = model.hand.worldFromProxy.position;
  note.part = part != kNoPart ? part : model.hand.touched;
  if (note.part == kNoPart) return note;
  const Pose& worldFromPart = model.worldFromPart[note.part];
  if (part != kNoPart) note.place = nearestSurfacePoint(*model.scene, part, worldFromPart, note.place).point;
  note.place = transformPoint(inverse(worldFromPart), note.place);
  return note;
}

namespace {

/// The two parts whose clearance a step wants; none if it is of one part or none.
std::optional<std::pair<PartId, PartId>> partsOf(const ScriptStep& step,
                                                 const std::vector<MeasuredPlace>& places) {
  if (step.figure != FigureKind::clearance) return std::nullopt;
  if (step.parts.size() == 2) return std::pair{step.parts[0], step.parts[1]};
  if (places.size() < 2 || places[0].part == places[1].part) return std::nullopt;
  return std::pair{places[0].part, places[1].part};
}

}  // namespace

Result<Measure> measureByStep(const ScriptStep& step, const haptics::ContactScene& contact,
                              const ViewModel& model) {
  ASSERT(step.places.size() <= placesOf(step.figure));
  std::vector<glm::dvec3> at = step.places;
  if (step.parts.empty()) at.resize(placesOf(step.figure), model.hand.worldFromProxy.position);
  std::vector<MeasuredPlace> places;
  for (const glm::dvec3& point : at)
    if (const auto place = measurePlace(contact, point, model.worldFromPart)) places.push_back(*place);
  std::optional<Clash> parts;
  if (const auto pair = partsOf(step, places))
    parts = measurePair(PartClosings(contact), pair->first, model.worldFromPart[pair->first], pair->second,
                        model.worldFromPart[pair->second]);
  for (const Figure& figure : figuresOf(places, parts))
    if (figure.kind == step.figure) return toMeasure(figure, *model.scene, model.worldFromPart, step.text);
  return Error{std::string("there is no ") + kFigureNames[static_cast<std::size_t>(step.figure)] +
               " to measure"};
}

sync::Inspection inspectByStep(const ScriptStep& step, const haptics::ContactScene& contact,
                               const ViewModel& model) {
  sync::Inspection looks;
  const std::vector<Pose>& poses = model.worldFromPart;
  if (step.parts.size() == 2) {
    const PartId a = step.parts[0], b = step.parts[1];
    const auto clash = measurePair(PartClosings(contact), a, poses[a], b, poses[b]);
    if (clash)
      putClash(*clash, poses[a], poses[b], looks);
    else
      looks.a = a, looks.b = b;
  }
  for (const glm::dvec3& point : step.places) {
    looks.measuring = true;
    if (const auto place = measurePlace(contact, point, poses))
      looks.marks.push_back({place->part, transformPoint(inverse(poses[place->part]), place->point)});
  }
  return looks;
}

ScriptWriter::ScriptWriter(const HandScript& script, const haptics::ContactScene& contact)
    : contact_(contact) {
  std::copy_if(script.steps.begin(), script.steps.end(), std::back_inserter(steps_),
               [](const ScriptStep& step) { return step.writes(); });
}

/// A step that finds something in the scene to write.
void ScriptWriter::find(const ScriptStep& step, const ViewModel& model, Written& written) const {
  using Kind = DocumentWish::Kind;
  if (step.verb == Verb::findClashes) {
    const ClashFindings findings = searchClashes(contact_, {0.0, false}, model.worldFromPart);
    std::vector<Clash> found;
    for (const FoundClash& each : findings.found) found.push_back(each.clash);
    for (Change& change : mergeClashes(*model.document, found, findings.complete, ownName(model)))
      written.wishes.push_back({Kind::change, std::move(change)});
    return;
  }
  Result<Measure> measure = measureByStep(step, contact_, model);
  if (measure)
    written.wishes.push_back({Kind::change, {0, 0, std::move(*measure)}});
  else
    written.problems.push_back(measure.error().message);
}

ScriptWriter::Written ScriptWriter::write(double now, std::uint32_t begun, const ViewModel& model,
                                          const Camera& camera) {
  Written written;
  if (model.document == nullptr || !model.documentStanding.complete) return written;
  for (; done_ < begun && !steps_.empty(); ++done_, steps_.pop_front()) {
    const ScriptStep& step = steps_.front();
    const Entry* note = answers(step.verb) ? answered(step, *model.document) : nullptr;
    if (step.shows()) {
      written.shown.push_back(step);
      if (step.verb == Verb::inspect) written.shown.back().inspection = inspectByStep(step, contact_, model);
    } else if (step.verb == Verb::measure || step.verb == Verb::findClashes) {
      find(step, model, written);
    } else if (!answers(step.verb) || note != nullptr) {
      written.wishes.push_back(wishOf(step, model, camera, note));
    } else if (waitsSince_ < 0.0 || model.documentStanding.unsent > 0 || now - waitsSince_ < kPatience) {
      if (waitsSince_ < 0.0 || model.documentStanding.unsent > 0) waitsSince_ = now;
      return written;
    } else {
      written.problems.push_back(missing(step));
    }
    waitsSince_ = -1.0;
  }
  return written;
}

}  // namespace tandem::client
