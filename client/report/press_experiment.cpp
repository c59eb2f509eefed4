#include "client/report/press_experiment.h"

#include <cmath>

#include "assets/base/assert.h"
#include "haptics/measure/touching_height.h"

namespace tandem::client::report {
namespace {

using generate::Family;

constexpr double kHighest = 0.06,
                 kSearchedEvery = 0.004;  // m: no part reaches higher over the other's origin
constexpr unsigned kPosesOfAPair = 1000;

struct FamilyTexts {
  Family family;
  const char *title, *about;
};
constexpr FamilyTexts kFamilies[] = {
    {Family::blobs, "Lumpy blobs", "Spheres under a few waves, their facets of many sizes."},
    {Family::blocks, "Stepped blocks", "Prisms over stairs whose corners are sharp, cut or rounded."},
    {Family::turned, "Turned parts",
     "Cylinders, cones and vaults about an axis, and ridges where they meet."}};

}  // namespace

std::vector<ExperimentInfo> allPressExperiments() {
  std::vector<ExperimentInfo> all;
  for (const FamilyTexts& family : kFamilies)
    all.push_back({std::string("press-") + generate::familyName(family.family), "press", family.title,
                   family.about, true});
  for (ExperimentInfo& info : all) info.exact = false;
  return all;
}

Family familyOf(const std::string& id) {
  for (const FamilyTexts& family : kFamilies)
    if (id == std::string("press-") + generate::familyName(family.family)) return family.family;
  ASSERT(false);
  return Family::blobs;
}

PartExperiment buildPress(Family family, unsigned pair, unsigned pose) {
  assets::Mesh under = generate::irregularMesh(family, 2 * pair);
  assets::Mesh held = generate::irregularMesh(family, 2 * pair + 1);
  generate::PressPath way(kPosesOfAPair * pair + pose);
  const haptics::DepthModel underModel(under), heldModel(held);
  way.beginAt(haptics::touchingHeight(underModel, {{0.0, 0.0, 0.0}, way.lying()}, heldModel, way.start(),
                                      kHighest, kSearchedEvery));
  PartExperiment e;
  const int ticks = static_cast<int>(way.duration() / kDt + 0.5);
  for (int i = 0; i < ticks; ++i) {
    const Pose at = way.at(kDt * i);
    PartPathPoint& point = e.path.emplace_back();
    point.goal = at.position;
    point.turned = at.orientation * glm::conjugate(way.start().orientation);
    point.depth = true;
  }
  addParts(e, std::move(held), std::move(under), way.start().orientation, way.lying());
  return e;
}

}  // namespace tandem::client::report
