// Measuring in the window: marks by key, live figures while a part is moved, what is kept, and the picture.

#include "client/marks/measure_list.h"

#include <GLFW/glfw3.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <thread>

#include <glm/geometric.hpp>

#include "client/findings/measure_watch.h"
#include "client/viewer/viewer.h"
#include "haptics/scene/contact_scene.h"
#include "tests/client/viewer/picture.h"
#include "tests/support/shapes.h"

namespace tandem::client {
namespace {

using namespace document;

/// Two cubes of 0.1 m, 0.2 m from middle to middle.
struct Measuring : testing::Test {
  test::SceneBuilder builder;
  Document document;
  ViewModel model;
  MeasureUi ui;

  Measuring() {
    builder.addPart(test::boxMesh(glm::dvec3(0.1)), {}, 1.0);
    builder.addPart(test::boxMesh(glm::dvec3(0.1)), {}, 1.0);
    builder.scene.bounds = {glm::dvec3(-0.05), {0.25, 0.05, 0.05}};
    model.scene = &builder.scene;
    model.document = &document;
    model.role = sync::Role::participant;
    model.owner = {kNoSite, kNoSite};
    model.measure.possible = true;
    place(0.2);
  }
  void place(double x) { model.worldFromPart = {Pose{}, Pose{{x, 0.0, 0.0}, glm::dquat(1, 0, 0, 0)}}; }
  EntryId put(const Body& body) {
    const Document::Outcome made = document.apply({0, 0, body}, {1, "ada", 1, 0});
    EXPECT_EQ(made.refusal, Refusal::none) << made.reason;
    return made.entry.id;
  }
};

TEST_F(Measuring, AKeyMarksWhatIsUnderTheCursorElseWhatTheToolTouches) {
  measureKey(ui, model, kNoPart, {});
  EXPECT_TRUE(ui.open) << "over nothing it opens the panel";
  measureKey(ui, model, 1, {0.15, 0.01, 0.0});
  ASSERT_EQ(ui.marks.size(), 1u);
  EXPECT_EQ(ui.marks[0].part, 1u);
  EXPECT_NEAR(glm::distance(ui.marks[0].point, glm::dvec3(-0.05, 0.01, 0.0)), 0.0, 1e-15);
  model.hand.touched = 0;
  model.hand.worldFromProxy.position = {0.05, 0.0, 0.0};
  measureKey(ui, model, kNoPart, {});
  ASSERT_EQ(ui.marks.size(), 2u);
  EXPECT_EQ(ui.marks[1].part, 0u);
  measureKey(ui, model, 0, {0.0, 0.05, 0.0});
  EXPECT_EQ(ui.marks.size(), 1u) << "a third begins anew";
  clearMeasure(ui);
  EXPECT_TRUE(ui.marks.empty() && ui.open);
  clearMeasure(ui);
  EXPECT_FALSE(ui.open);
  model.measure.possible = false;
  measureKey(ui, model, 0, {});
  EXPECT_FALSE(ui.open) << "a recording measures nothing";
}

TEST_F(Measuring, FiguresFollowAPartThatIsMoved) {
  const haptics::ContactScene contact(builder.scene, 1);
  MeasureWatch watch(contact);
  EXPECT_TRUE(watch.update({}, model.worldFromPart).figures.empty());
  markPlace(ui, model, 0, {0.05, 0.0, 0.0});
  markPlace(ui, model, 1, {0.15, 0.0, 0.0});
  const auto clearanceAt = [&](double x) {
    place(x);
    double found = -1.0;
    for (int tries = 0; tries < 400; ++tries) {
      for (const Figure& figure : watch.update(ui.marks, model.worldFromPart).figures) {
        if (figure.kind == FigureKind::distance) {
          EXPECT_NEAR(figure.value, x - 0.1, 1e-12) << "in the same frame";
        }
        if (figure.kind == FigureKind::clearance) found = figure.value;
      }
      if (std::abs(found - (x - 0.1)) < 1e-9) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return found;
  };
  EXPECT_NEAR(clearanceAt(0.2), 0.1, 1e-9);
  EXPECT_NEAR(clearanceAt(0.13), 0.03, 1e-9);
  EXPECT_NEAR(clearanceAt(0.5), 0.4, 1e-9);
  const std::vector<Anchor> one{ui.marks[0]};
  for (int tries = 0; tries < 400 && watch.update(one, model.worldFromPart).figures.size() != 1; ++tries)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const MeasureView view = watch.update(one, model.worldFromPart);
  ASSERT_EQ(view.figures.size(), 1u);
  EXPECT_EQ(view.figures[0].kind, FigureKind::length) << "of other marks nothing is left";
}

TEST_F(Measuring, AKeptMeasureFollowsItsPartsAndIsMeasuredAgainWhenChosen) {
  const Figure figure{FigureKind::distance, 0.1, {{0.05, 0.0, 0.0}, {0.15, 0.0, 0.0}}, {0, 1}, false};
  const DocumentWish wish = keepFigure(figure, model);
  const EntryId id = put(wish.change.body);
  const Measure& measure = std::get<Measure>(document.find(id)->body);
  EXPECT_EQ(measure.value, 0.1);
  place(0.3);
  const std::vector<glm::dvec3> line = lineOf(measure, model);
  ASSERT_EQ(line.size(), 2u);
  EXPECT_NEAR(line[1].x, 0.25, 1e-12);
  chooseMeasure(ui, *document.find(id), 2);
  EXPECT_EQ(ui.marks.size(), 2u);
  chooseMeasure(ui, *document.find(id), 2);
  EXPECT_TRUE(ui.marks.empty()) << "a second click lets go";
  chooseMeasure(ui, *document.find(id), 1);
  EXPECT_EQ(ui.marks.size(), 1u) << "a part that the scene lacks is passed over";
  put(Measure{"later", MeasureKind::length, 0.2, {}});
  EXPECT_EQ(measureRows(document).front()->id, 2u);
  EXPECT_TRUE(lineOf(Measure{"", MeasureKind::length, 0.2, {{7, {}}}}, model).empty());
}

TEST_F(Measuring, APlaceIsNotedWhereItIs) {
  MeasuredPlace place;
  place.part = 1;
  place.point = {0.15, 0.0, 0.0};
  place.normal = {-1.0, 0.0, 0.0};
  place.cylinder = assets::Cylinder{{0.2, 0.0, 0.0}, {0.0, 1.0, 0.0}, 0.05, 0.05, 48, true};
  const Note note = std::get<Note>(notePlace(place, model).change.body);
  EXPECT_EQ(note.part, 1u);
  EXPECT_NEAR(note.place.x, -0.05, 1e-15);
  EXPECT_EQ(
      note.text,
      "part1, at 150.000 0.000 0.000 mm, faces -1.000 0.000 0.000, bore, axis through 200.000 0.000 0.000 "
      "mm, along 0.000 1.000 0.000");
}

TEST_F(Measuring, TheWindowMarksByKeyAndDrawsTheFigures) {
  ViewerOptions options;
  options.width = 1024;
  options.height = 640;
  auto opened = Viewer::openOffscreen(builder.scene, options);
  if (!opened) GTEST_SKIP() << opened.error().message;
  Viewer& viewer = **opened;
  viewer.frame(model);
  viewer.frame(model);
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("tandem_measures_" + std::to_string(getpid()));
  std::filesystem::create_directory(folder);
  ASSERT_TRUE(viewer.screenshot(folder / "before.png").ok());
  const haptics::ContactScene contact(builder.scene, 1);
  MeasureWatch watch(contact);
  ViewActions actions;
  for (const double x : {460.0, 610.0}) {
    viewer.pointMouse({x, 330.0}, false);
    viewer.frame(model);
    viewer.pressKey(GLFW_KEY_M);
    actions = viewer.frame(model);
  }
  ASSERT_EQ(actions.marks.size(), 2u);
  EXPECT_NE(actions.marks[0].part, actions.marks[1].part);
  for (int tries = 0; tries < 400 && model.measure.figures.size() < 3; ++tries) {
    model.measure = watch.update(actions.marks, model.worldFromPart);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  put(Measure{"cubes", MeasureKind::distance, 0.2, {{0, {0.0, 0.05, 0.0}}, {1, {0.0, 0.05, 0.0}}}});
  for (int i = 0; i < 3; ++i) viewer.frame(model);
  const std::string path = std::getenv("TANDEM_KEEP_PICTURE") != nullptr
                               ? std::string(std::getenv("TANDEM_KEEP_PICTURE"))
                               : std::string(folder / "after.png");
  ASSERT_TRUE(viewer.screenshot(path).ok());
  EXPECT_GT(countDifferent(readPng(folder / "before.png"), readPng(path), 24), 5000);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace tandem::client
