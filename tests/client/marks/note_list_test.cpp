// The notes of the session's document in the window: the list apart from drawing, and pins, panel and keys in
// a viewer without a display.

#include "client/marks/note_list.h"

#include <gtest/gtest.h>
#include <imgui/imgui.h>
#include <unistd.h>

#include <filesystem>

#include <glm/geometric.hpp>

#include "client/viewer/viewer.h"
#include "tests/client/viewer/picture.h"

namespace tandem::client {
namespace {

using namespace document;

Note note(const std::string& text, NoteStatus status = NoteStatus::open) {
  Note n;
  n.text = text;
  n.status = status;
  return n;
}

/// A box that was moved from its place, the document of a session, and a person in it.
struct NoteLists : testing::Test {
  assets::Scene scene;
  Document document;
  ViewModel model;

  NoteLists() {
    assets::Part box;
    box.name = "box";
    box.movable = true;
    box.shapes.resize(1);
    box.shapes[0].kind = assets::ImplicitShape::Kind::box;
    box.shapes[0].size = {0.1, 0.1, 0.1};
    scene.parts = {box};
    scene.materials.resize(1);
    scene.bounds = {glm::dvec3(-0.3, -0.05, -0.05), glm::dvec3(0.3, 0.05, 0.05)};
    model.scene = &scene;
    model.document = &document;
    model.role = sync::Role::participant;
    model.owner = {kNoSite};
    place({0.0, 0.0, 0.0});
  }
  void place(const glm::dvec3& at) { model.worldFromPart = {{at, {1.0, 0.0, 0.0, 0.0}}}; }
  EntryId put(const Body& body, const std::string& author = "ada", std::int64_t time = 0) {
    const Document::Outcome made = document.apply({0, 0, body}, {1, author, 1, time});
    EXPECT_EQ(made.refusal, Refusal::none) << made.reason;
    return made.entry.id;
  }
  void apply(const DocumentWish& wish) {
    EXPECT_EQ(document.apply(wish.change, {1, "ada", 1, 0}).refusal, Refusal::none);
  }
};

TEST_F(NoteLists, TheThreadThatChangedLastComesFirst) {
  const EntryId bolt = put(note("bolt"));
  const EntryId lid = put(note("lid", NoteStatus::closed));
  put(note("rim"));
  put(Comment{bolt, "which?"});
  put(Comment{lid, "done"});
  put(Comment{bolt, "the left one"});
  const std::vector<NoteRow> rows = noteRows(document, false);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].note->text, "bolt");
  ASSERT_EQ(rows[0].replies.size(), 2u);
  EXPECT_EQ(std::get<Comment>(rows[0].replies[1]->body).text, "the left one");
  EXPECT_EQ(rows[1].note->text, "rim");
  EXPECT_EQ(noteRows(document, true).size(), 3u);
}

TEST_F(NoteLists, ALineSaysWhoWhenAndHowItStands) {
  Note loose = note("bolt", NoteStatus::inProgress);
  loose.assignee = "ben";
  const EntryId id = put(loose, "ada", 1000);
  EXPECT_EQ(byline(noteRows(document, false)[0], 1030), "in progress, for ben, ada now");
  put(Comment{id, "yes"});
  EXPECT_EQ(byline(noteRows(document, false)[0], 1000 + 5 * 60),
            "in progress, for ben, ada 5 min ago, 1 reply");
  EXPECT_EQ(ageInWords(0, 3 * 3600), "3 h ago");
  EXPECT_EQ(ageInWords(0, 49 * 3600), "2 days ago");
  EXPECT_EQ(ageInWords(100, 0), "now") << "clocks differ";
}

TEST_F(NoteLists, APlaceOnAPartFollowsIt) {
  place({0.2, 0.0, 0.0});
  const Note pinned = noteAt(model, 0, {0.25, 0.0, 0.0});
  const Note inRoom = noteAt(model, kNoPart, {0.25, 0.0, 0.0});
  model.worldFromPart[0] = {{0.0, 1.0, 0.0}, glm::angleAxis(glm::radians(90.0), glm::dvec3(0.0, 0.0, 1.0))};
  EXPECT_LT(glm::length(*placeOf(pinned, model) - glm::dvec3(0.0, 1.05, 0.0)), 1e-12);
  EXPECT_EQ(*placeOf(inRoom, model), glm::dvec3(0.25, 0.0, 0.0));
  Note elsewhere = pinned;
  elsewhere.part = 7;
  EXPECT_FALSE(placeOf(elsewhere, model).has_value());
}

TEST_F(NoteLists, AChangeKeepsWhatItDoesNotChange) {
  Note loose = note("bolt");
  loose.assignee = "ben";
  const EntryId id = put(loose);
  apply(changedNote(*document.find(id), [](Note& n) { n.status = NoteStatus::resolved; }));
  const Note& now = std::get<Note>(document.find(id)->body);
  EXPECT_EQ(now.status, NoteStatus::resolved);
  EXPECT_EQ(now.assignee, "ben");
  EXPECT_EQ(now.text, "bolt");
}

TEST_F(NoteLists, AViewGivesBackCameraSectionsAndHowPartsAreSeen) {
  Camera camera;
  camera.target = {0.1, 0.2, 0.3};
  camera.distance = 0.7;
  camera.yaw = 1.1;
  camera.pitch = -0.4;
  SectionSet sections;
  sections.beyond[0] = 0.05;
  sections.before[2] = -0.01;
  sections.oblique.push_back({{0.0, 0.6, 0.8}, 0.02});
  PartDisplay parts(3);
  parts.setHidden(1, true);
  parts.setTransparent(2, true);
  parts.style = {0.5, {0, 2}, document::PartColouring::byBody, true};
  const NamedView view = viewAs("inside", camera, sections, parts);
  Camera like;
  like.distance = 9.0;
  const Camera again = cameraOfView(view, like);
  EXPECT_LT(glm::length(again.target - camera.target), 1e-9);
  EXPECT_NEAR(again.distance, 0.7, 1e-12);
  SectionSet sectionsAgain;
  sectionsAgain.beyond[1] = 1.0;
  PartDisplay partsAgain(3);
  partsAgain.isolate({0});
  partsAgain.setTransparent(0, true);
  applyView(view, sectionsAgain, partsAgain);
  EXPECT_EQ(sectionsAgain.beyond, sections.beyond);
  EXPECT_EQ(sectionsAgain.before, sections.before);
  ASSERT_EQ(sectionsAgain.oblique.size(), 1u);
  EXPECT_LT(glm::length(sectionsAgain.oblique[0].normal - sections.oblique[0].normal), 1e-12);
  EXPECT_NEAR(sectionsAgain.oblique[0].place, 0.02, 1e-12);
  EXPECT_TRUE(partsAgain.visible(0) && !partsAgain.visible(1) && partsAgain.visible(2));
  EXPECT_EQ(partsAgain.style, parts.style);
  const auto transparent = [](const PartDisplay& display) {
    return std::vector<bool>{display.transparent(0), display.transparent(1), display.transparent(2)};
  };
  EXPECT_EQ(transparent(partsAgain), (std::vector<bool>{false, false, true}));
  EXPECT_EQ(view.seenThrough, (document::SeenThrough{false, {2}}));
  // Where most are transparent the others are listed; a part that the scene has not is left out.
  parts.setTransparent(0, true);
  NamedView through = viewAs("through", camera, sections, parts);
  EXPECT_EQ(through.seenThrough, (document::SeenThrough{true, {1}}));
  through.seenThrough.parts.push_back(99);
  applyView(through, sectionsAgain, partsAgain);
  EXPECT_EQ(transparent(partsAgain), (std::vector<bool>{true, false, true}));
  // With more hidden than shown, what is shown is listed; a part that the scene has not is left out.
  parts.setHidden(0, true);
  NamedView most = viewAs("lid", camera, {}, parts);
  EXPECT_TRUE(most.onlyThese);
  EXPECT_EQ(most.parts, std::vector<PartId>{2});
  most.parts.push_back(99);
  most.style.apart.push_back(99);
  applyView(most, sectionsAgain, partsAgain);
  EXPECT_FALSE(sectionsAgain.any());
  EXPECT_EQ(partsAgain.style, parts.style);
  EXPECT_TRUE(!partsAgain.visible(0) && !partsAgain.visible(1) && partsAgain.visible(2));
}

/// The same in a viewer without a display.
struct NotesInViewer : NoteLists {
  static constexpr int kWidth = 900, kHeight = 500;
  std::unique_ptr<Viewer> viewer;
  ViewActions actions;

  void SetUp() override { open(true); }
  void open(bool panels) {
    ViewerOptions options;
    options.width = kWidth;
    options.height = kHeight;
    options.panels = panels;
    auto opened = Viewer::openOffscreen(scene, options);
    if (!opened) GTEST_SKIP() << opened.error().message;
    viewer = std::move(*opened);
    Camera& camera = viewer->camera();
    camera = fitView(scene.bounds, 1.5);
    camera.yaw = camera.pitch = 0.0;
    camera.distance = 1.0;
  }
  /// Draws some frames; returns all wishes.
  std::vector<DocumentWish> frames(int count) {
    std::vector<DocumentWish> wishes;
    for (int i = 0; i < count; ++i) {
      actions = viewer->frame(model);
      wishes.insert(wishes.end(), actions.documentWishes.begin(), actions.documentWishes.end());
    }
    return wishes;
  }
  void typeText(const char* text) {
    ImGui::GetIO().AddInputCharactersUTF8(text);
    frames(3);
  }
  std::vector<DocumentWish> enter() {
    constexpr int kEnter = 257;  // of no backend: nothing else has mapped keys
    ImGui::GetIO().KeyMap[ImGuiKey_Enter] = kEnter;
    ImGui::GetIO().KeysDown[kEnter] = true;
    const std::vector<DocumentWish> wishes = frames(2);
    ImGui::GetIO().KeysDown[kEnter] = false;
    frames(1);
    return wishes;
  }
  Picture picture() {
    const std::string path = testing::TempDir() + "tandem_notes_" + std::to_string(::getpid()) + ".png";
    EXPECT_TRUE(viewer->screenshot(path).ok());
    Picture read = readPng(path);
    std::filesystem::remove(path);
    return read;
  }
  /// The mean column of orange pixels, which only the pin of an open note has; -1 without any.
  double pinColumn() {
    const Picture shown = picture();
    double sum = 0.0;
    int count = 0;
    for (int y = 0; y < shown.height; ++y)
      for (int x = 0; x < shown.width; ++x) {
        const Rgb c = shown.at(x, y);
        if (c[0] < 150 || c[2] > c[0] / 3 || c[1] > 3 * c[0] / 4) continue;
        sum += x;
        ++count;
      }
    return count > 20 ? sum / count : -1.0;
  }
};

TEST_F(NotesInViewer, APinFollowsItsPart) {
  open(false);
  if (!viewer) return;
  frames(2);
  EXPECT_EQ(pinColumn(), -1.0);
  Note pinned = noteAt(model, 0, {0.0, 0.05, 0.05});
  pinned.text = "bolt";
  const EntryId id = put(pinned);
  place({-0.2, 0.0, 0.0});
  frames(2);
  const double left = pinColumn();
  place({0.2, 0.0, 0.0});
  frames(2);
  const double right = pinColumn();
  EXPECT_GT(left, 0.0);
  EXPECT_GT(right, left + 0.2 * kWidth);
  apply(changedNote(*document.find(id), [](Note& n) { n.status = NoteStatus::closed; }));
  frames(2);
  EXPECT_EQ(pinColumn(), -1.0) << "a closed note has no pin";
}

TEST_F(NotesInViewer, TheKeyWritesANoteAtThePlaceUnderTheMouse) {
  if (!viewer) return;
  frames(3);
  // The middle of the scene's part of the window, where the box is.
  const double left = 0.25 * kWidth, right = kWidth - 0.3 * kWidth;
  viewer->pointMouse({0.5 * (left + right), 0.5 * kHeight - 10.0}, false);
  frames(2);
  viewer->pressKey('N');
  EXPECT_TRUE(frames(3).empty());
  typeText("bolt is loose");
  frames(2);
  const std::vector<DocumentWish> wishes = enter();
  ASSERT_EQ(wishes.size(), 1u);
  const Note& written = std::get<Note>(wishes[0].change.body);
  EXPECT_EQ(written.text, "bolt is loose");
  EXPECT_EQ(written.part, 0);
  EXPECT_NEAR(written.place.z, 0.05, 1e-3) << "on the box's front";
}

TEST_F(NotesInViewer, WhoOnlyWatchesWritesNothing) {
  if (!viewer) return;
  model.role = sync::Role::observer;
  frames(2);
  viewer->pressKey('N');
  EXPECT_TRUE(frames(3).empty());
  typeText("x");
  EXPECT_TRUE(enter().empty());
}

}  // namespace
}  // namespace tandem::client
