// What a script shows the others is done in a window as without one.

#include "client/commands/script_in_window.h"

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "client/viewer/ui_state.h"
#include "tests/client/hand/box_row.h"

namespace tandem::client {
namespace {

using Verb = ScriptStep::Verb;

TEST(ScriptInWindow, DoesWhatTheOthersSee) {
  const assets::Scene scene = test::rowOfBoxes();
  ViewModel model;
  model.scene = &scene;
  for (const assets::Part& part : scene.parts) model.worldFromPart.push_back(part.worldFromPart);
  model.owner.assign(scene.parts.size(), kNoSite);
  model.role = sync::Role::participant;
  model.hand.worldFromProxy.position = {0.0, 0.0, 1.0};
  ViewerOptions options;
  options.width = 320;
  options.height = 200;
  options.panels = false;
  auto opened = Viewer::openOffscreen(scene, options);
  if (!opened) GTEST_SKIP() << opened.error().message;
  Viewer& viewer = **opened;
  const Result<HandScript> script = parseHandScript(
      R"([{"t": 0, "do": "share", "what": "view"}, {"t": 0, "do": "section", "planes": [[0, 0, 2, 0.5]]},
          {"t": 0, "do": "hide", "parts": ["box 1"]}, {"t": 0, "do": "select", "part": "box 2"},
          {"t": 0, "do": "explode", "factor": 0.5}, {"t": 0, "do": "colour", "what": "body"},
          {"t": 0, "do": "ghosts", "on": true}, {"t": 0, "do": "point", "part": "box 0"},
          {"t": 0, "do": "look", "from": [0, 0, 2], "to": [0, 0, 0]},
          {"t": 0, "do": "say", "text": "see [box 1]"}])",
      "test", scene);
  ASSERT_TRUE(script.ok()) << script.error().message;
  std::vector<sync::Say> says;
  for (const ScriptStep& step : script->steps) showInWindow(step, model, viewer, says);
  const ViewActions actions = viewer.frame(model);
  const sync::Presentation& shown = actions.shown;
  EXPECT_EQ(shown.shares, sync::Shares::view);
  ASSERT_EQ(shown.sections.size(), 1u);
  EXPECT_EQ(shown.sections[0].point, glm::dvec3(0.0, 0.0, 0.5));
  EXPECT_EQ(shown.hidden, std::vector<std::uint8_t>{1u << 1});
  EXPECT_EQ(shown.selected, 2);
  EXPECT_EQ(shown.style, (document::PartStyle{0.5, {}, document::PartColouring::byBody, true}));
  EXPECT_TRUE(actions.lifted);
  EXPECT_EQ(shown.pointedAt, 0);
  EXPECT_NEAR(shown.place.z, 0.02, 1e-9) << "the top of the box";
  EXPECT_LT(glm::distance(actions.worldFromCamera.position, {0.0, 0.0, 2.0}), 1e-9);
  ASSERT_EQ(says.size(), 1u);
  EXPECT_EQ(says[0].parts, std::vector<PartId>{1});
  ScriptStep nowhere;
  nowhere.verb = Verb::point;
  showInWindow(nowhere, model, viewer, says);
  EXPECT_EQ(viewer.frame(model).shown.pointedAt, kNoPart);
}

}  // namespace
}  // namespace tandem::client
