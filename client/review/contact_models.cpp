#include "client/review/contact_models.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "assets/scene/control.h"
#include "client/base/thread_clock.h"
#include "client/review/facet_sag.h"
#include "haptics/scene/contact_scene_data.h"
#include "haptics/scene/contact_world.h"
#include "haptics/tick.h"

namespace tandem::client {
namespace {

constexpr int kTicksAnAxis = 60;
constexpr double kDraw = 0.01;  // of the part's size

/// Controls are excluded: a held control moves along its axis alone and collides with nothing.
bool canBeHeld(const assets::Scene& scene, PartId part) {
  return scene.parts[part].movable && assets::controlOf(scene, part) == nullptr;
}

/// The times of ticks in which a hand holds the part by its middle and moves it to and fro, us.
std::vector<double> tryPart(const haptics::ContactScene& contact, const haptics::ContactWorld& world,
                            PartId part) {
  haptics::TickState state(contact);
  haptics::TickParameters parameters;
  parameters.effort.taking = haptics::ContactEffort::kTakeAtOnce;
  const haptics::Collider& collider = world.collider(part);
  const glm::dvec3 middle = transformPoint(world.pose(part), collider.centre);
  const std::array<haptics::PartCommand, 2> take{{{haptics::PartCommand::Kind::own, part, world.pose(part)},
                                                  {haptics::PartCommand::Kind::grasp, part, {}}}};
  std::vector<double> times;
  times.reserve(3 * kTicksAnAxis);
  haptics::TickInput input;
  input.hands[0].device.valid = true;
  input.hands[0].device.worldFromDevice.position = middle;
  input.commands = take;
  static_cast<void>(
      haptics::tick(input, contact, parameters, state));  // the tick of the grasp itself is not typical
  input.commands = {};
  for (int axis = 0; axis < 3; ++axis)
    for (int i = 0; i < kTicksAnAxis; ++i) {
      input.hands[0].device.worldFromDevice.position = middle;
      input.hands[0].device.worldFromDevice.position[axis] +=
          2.0 * kDraw * collider.radius * std::sin(2.0 * 3.14159265358979323846 * i / kTicksAnAxis);
      const double start = threadMicroseconds();
      static_cast<void>(haptics::tick(input, contact, parameters, state));
      times.push_back(threadMicroseconds() - start);
    }
  return times;
}

/// Sets the tolerance. Of parts that share a model the strictest decides.
void setTolerance(const haptics::ContactScene& contact, PartId id, ContactModel& model) {
  const haptics::ContactScene::Data& data = contact.data();
  ASSERT(data.tolerances.size() == data.colliders.size() && id < data.colliders.size());
  model.toleranceOf = id;
  for (std::size_t i = 0; i < data.colliders.size(); ++i)
    if (data.colliders[i].model == data.colliders[id].model &&
        data.tolerances[i].tolerance < data.tolerances[model.toleranceOf].tolerance)
      model.toleranceOf = static_cast<PartId>(i);
  const haptics::PartTolerance& from = data.tolerances[model.toleranceOf];
  model.toleranceFrom = from.from;
  model.tolerance = from.tolerance;
  if (from.from != haptics::PartTolerance::From::clearance) return;
  model.clearance = from.clearance;
  model.clearanceTo = from.neighbour;
}

ContactModel modelOf(const haptics::ContactScene& contact, const haptics::ContactWorld& world, PartId id,
                     bool trial) {
  ContactModel model;
  model.part = id;
  model.held = canBeHeld(contact.scene(), id);
  const haptics::PartModel* made = world.model(id);
  if (made == nullptr) return model;
  model.made = true;
  model.byFormula = made->byFormula();
  model.samples = made->samples.samples().size();
  model.cells = made->field.cells();
  model.bytes = made->memory();
  model.cell = model.byFormula ? 0.0 : made->field.smallestCell();
  model.spacing = made->samples.spacing();
  setTolerance(contact, id, model);
  model.fieldError = model.byFormula ? made->field.worstSmoothError()
                                     : std::max(made->field.tolerance(), made->field.worstSmoothError());
  model.sag = model.byFormula ? 0.0 : facetSag(made->tree->mesh());
  model.coarsened = made->field.coarsened();
  model.seconds = made->seconds;
  model.cached = made->cached;
  if (trial && model.held) model.trial_us = tryPart(contact, world, id);
  return model;
}

}  // namespace

std::vector<ContactModel> contactModels(const haptics::ContactScene& contact, bool trial) {
  const assets::Scene& scene = contact.scene();
  const haptics::ContactWorld world(contact);
  std::vector<PartId> held;
  for (std::size_t i = 0; i < scene.parts.size(); ++i)
    if (const auto id = static_cast<PartId>(i); canBeHeld(scene, id) && world.collider(id).tree != nullptr)
      held.push_back(id);
  std::vector<ContactModel> models;
  for (std::size_t i = 0; i < scene.parts.size() && !held.empty(); ++i) {
    const auto id = static_cast<PartId>(i);
    if (world.collider(id).tree == nullptr) continue;
    const bool matters = std::any_of(
        held.begin(), held.end(), [&](PartId other) { return other == id || world.mayCollide(other, id); });
    if (matters) models.push_back(modelOf(contact, world, id, trial));
  }
  return models;
}

}  // namespace tandem::client
