// Sections, views and places that one site shows another through a real session on virtual time, and what the
// other's hand feels of them.

#include "client/join/headless_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

#include "client/base/felt_sections.h"
#include "client/hand/hand_loop.h"
#include "client/session/server_connection.h"
#include "tests/client/hand/box_row.h"
#include "tests/server/session_rig.h"

namespace tandem::client {
namespace {

using namespace sync;
using Verb = ScriptStep::Verb;

ScriptStep step(Verb verb) {
  ScriptStep made;
  made.verb = verb;
  return made;
}
ScriptStep share(Shares what) {
  ScriptStep made = step(Verb::share);
  made.shares = what;
  return made;
}
ScriptStep cutBefore(double x) {
  ScriptStep made = step(Verb::section);
  made.planes = {{{x, 0.0, 0.0}, {-1.0, 0.0, 0.0}}};
  return made;
}

/// A site without a window, with a hand over a box of 4 cm.
struct Site {
  explicit Site(const assets::Scene& scene) : contact(scene) { begin(); }

  void begin() {
    hand = std::make_unique<HandLoop>(contact, *exchange);
    exchange->timeBase.write({1000000, 5000, SiteId{1}});
  }
  /// Feels the sections, or nothing; `naive`: as a hand that begins anew with them.
  void feel(const std::vector<document::SectionPlane>& planes, bool lifted) {
    const haptics::Sections felt = feltSections(planes);
    const bool changed = std::exchange(settings.lifted, lifted) != lifted ||
                         felt.size() != settings.sectionCount ||
                         !std::equal(felt.begin(), felt.end(), settings.sections.begin());
    settings.sectionCount = felt.size();
    std::copy(felt.begin(), felt.end(), settings.sections.begin());
    if (changed && naive) begin();
    exchange->settings.write(settings);
  }
  void tick(Micros now) {
    haptics::DeviceSample sample;
    sample.worldFromDevice.position = device;
    sample.valid = true;
    sample.time = toSeconds(now);
    forces.push_back(hand->tick(sample, now).force);
    const std::size_t from = forces.size() > kWindow ? forces.size() - 1 - kWindow : 0;
    for (std::size_t i = from; i < forces.size() && watched; ++i)
      kick = std::max(kick, glm::length(forces.back() - forces[i]));
  }
  double force() const { return glm::length(forces.back()); }

  static constexpr std::size_t kWindow = 20;  // ticks
  haptics::ContactScene contact;
  std::unique_ptr<Exchange> exchange = std::make_unique<Exchange>();
  std::unique_ptr<ServerConnection> connection;
  HeadlessView view{Camera{}, {}, true};
  std::unique_ptr<HandLoop> hand;
  HandSettingsInput settings;
  glm::dvec3 device{0.0, 0.0, 0.05};
  std::vector<glm::dvec3> forces;
  double kick = 0.0;  // N in 20 ms, since it is watched
  bool naive = false, watched = false;
  ViewModel model;
  std::vector<ChatLine> chat;
  std::vector<std::string> notices;
};

struct SharedViews : testing::Test, server::SessionRig {
  assets::Scene boxes = test::rowOfBoxes();
  std::vector<std::unique_ptr<Site>> people;

  Site& enter(const std::string& name, Role role = Role::participant) {
    auto site = std::make_unique<Site>(boxes);
    ConnectionOptions options;
    options.name = name;
    options.token = token(role);
    site->connection = std::make_unique<ServerConnection>(
        options, [this, name]() -> Result<std::unique_ptr<Transport>> { return network.connect(name); });
    site->model.scene = &boxes;
    for (const assets::Part& part : boxes.parts) site->model.worldFromPart.push_back(part.worldFromPart);
    people.push_back(std::move(site));
    run(300 * kMillisecond);
    EXPECT_EQ(people.back()->connection->stage(), ServerConnection::Stage::ready);
    return *people.back();
  }
  void afterStep() override {
    for (const auto& site : people) {
      ServerConnection& connection = *site->connection;
      connection.step(now);
      if (connection.stage() == ServerConnection::Stage::needScene) connection.skipTransfer();
      if (connection.stage() == ServerConnection::Stage::haveScene)
        connection.sceneReady(scene, *site->exchange);
      if (now % (15 * kMillisecond) == 0) exchangeViews(*site);
      site->tick(now);
    }
  }
  void exchangeViews(Site& site) {
    Presentations& presentations = site.connection->presentations();
    site.model.presenting = presentations.view(boxes.parts.size());
    for (ChatLine& line : presentations.drainChat()) site.chat.push_back(line);
    for (const Notice& notice : site.connection->drainNotices()) site.notices.push_back(notice.text);
    const ViewActions actions = site.view.act(site.model);
    presentations.show(actions.shown);
    for (const Say& said : actions.says) presentations.say(said);
    site.feel(actions.sections, actions.lifted);
  }
  /// The hand presses on the box from above.
  void press(Site& site) {
    for (double z = 0.03; z > 0.0161; z -= 1e-4) {
      site.device = {1e-4, 2e-4, z};
      run(kMillisecond);
    }
    run(300 * kMillisecond);
    ASSERT_GT(site.force(), 2.5);
    site.watched = true;
  }
  void settle(Micros length = 300 * kMillisecond) { run(length); }
  void perform(Site& site, const ScriptStep& made) { site.view.perform(made, site.model); }
};

/// Ada moves her plane over the place where Ben presses, and away again.
double kickOfBen(SharedViews& session, double speed, bool naive) {
  Site& ada = session.enter("ada");
  Site& ben = session.enter("ben");
  ben.naive = naive;
  session.perform(ada, cutBefore(-0.1));
  session.perform(ada, share(Shares::sections));
  session.settle();
  EXPECT_TRUE(ben.view.following().followsSections());
  session.press(ben);
  for (double x = -0.03; x < 0.03; x += speed * 1e-3) {
    session.perform(ada, cutBefore(x));
    session.run(kMillisecond);
  }
  session.perform(ada, cutBefore(0.03));
  session.settle(1500 * kMillisecond);
  EXPECT_EQ(ben.force(), 0.0) << "what Ada has cut away is not felt at Ben's site";
  session.perform(ada, share(Shares::nothing));
  session.settle(1500 * kMillisecond);
  EXPECT_EQ(ben.force(), 0.0) << "what returns around the tool is not felt";
  testing::Test::RecordProperty("mN", static_cast<int>(1000.0 * ben.kick));
  return ben.kick;
}

TEST_F(SharedViews, APlaneThatMovesPastAnothersToolDoesNotKickIt) {
  EXPECT_LE(kickOfBen(*this, 0.1, false), 0.3);
}
TEST_F(SharedViews, APlaneThatJumpsPastAnothersToolDoesNotKickIt) {
  EXPECT_LE(kickOfBen(*this, 100.0, false), 0.3);
}
TEST_F(SharedViews, APlaneKicksAHandThatTakesItWithoutCare) { EXPECT_GT(kickOfBen(*this, 0.1, true), 2.0); }

TEST_F(SharedViews, TheMarksOfAClashAndAMeasureGoWithAViewAndEndWithIt) {
  Site& ada = enter("ada");
  Site& ben = enter("ben");
  ScriptStep inspects = step(Verb::inspect);
  Inspection& looks = inspects.inspection;
  looks.a = 0;
  looks.b = 1;
  looks.mark = ClashMark::depth;
  looks.amount = 0.002;
  looks.onA = {0.01, 0.0, 0.0};
  looks.measuring = true;
  looks.marks = {{1, {0.0, 0.01, 0.0}}};
  perform(ada, inspects);
  perform(ada, share(Shares::sections));
  settle();
  const Inspection& told = ben.model.presenting.shared.inspection;
  EXPECT_EQ(told, Inspection{}) << "sections alone are shared";
  perform(ada, share(Shares::view));
  settle();
  EXPECT_EQ(told, looks);
  perform(ada, step(Verb::inspect));
  settle();
  EXPECT_EQ(told, Inspection{}) << "she looks at nothing any more";
  perform(ada, inspects);
  settle();
  EXPECT_EQ(told, looks);
  perform(ada, share(Shares::nothing));
  settle();
  EXPECT_EQ(told, Inspection{});
}

TEST_F(SharedViews, WhoStopsFollowingHasTheirOwnSectionsBack) {
  Site& ada = enter("ada");
  Site& ben = enter("ben");
  perform(ben, cutBefore(-0.5));
  perform(ada, cutBefore(0.01));
  settle();
  EXPECT_EQ(ben.view.sections(ben.model).at(0).point.x, -0.5) << "nothing is shared yet";
  perform(ada, share(Shares::sections));
  settle();
  EXPECT_EQ(ben.view.sections(ben.model).at(0).point.x, 0.01);
  perform(ben, step(Verb::follow));  // nothing
  settle();
  EXPECT_EQ(ben.view.sections(ben.model).at(0).point.x, -0.5);
  ScriptStep again = step(Verb::follow);
  again.shares = Shares::view;
  perform(ben, again);
  perform(ada, cutBefore(0.02));
  settle();
  EXPECT_EQ(ben.view.sections(ben.model).at(0).point.x, 0.02);
  perform(ada, share(Shares::nothing));
  settle();
  EXPECT_EQ(ben.view.sections(ben.model).at(0).point.x, -0.5);
}

TEST_F(SharedViews, AViewBringsHiddenPartsAndSelectionAndPointsAreSeen) {
  Site& ivan = enter("ivan", Role::instructor);
  Site& ben = enter("ben", Role::observer);
  ScriptStep hide = step(Verb::hide), select = step(Verb::select), point = step(Verb::point);
  hide.parts = {PartId{0}, PartId{2}};
  select.part = PartId{1};
  point.part = PartId{1};
  perform(ivan, hide);
  perform(ivan, select);
  perform(ivan, point);
  settle();
  EXPECT_EQ(ben.model.presenting.shared.site, kNoSite);
  ASSERT_EQ(ben.model.presenting.points.size(), 1u) << "to point, nobody needs to present";
  const Presentation pointing = ben.model.presenting.points[0];
  EXPECT_EQ(pointing.pointedAt, 1);
  EXPECT_NEAR(std::max({std::abs(pointing.place.x), std::abs(pointing.place.y), std::abs(pointing.place.z)}),
              0.02, 1e-9)
      << "on the surface of the part";
  perform(ivan, share(Shares::view));
  settle();
  EXPECT_TRUE(ben.view.following().followsView());
  const PresentingView& seen = ben.model.presenting;
  EXPECT_TRUE(seen.hides(PartId{0}) && !seen.hides(PartId{1}) && seen.hides(PartId{2}));
  EXPECT_EQ(seen.shared.selected, 1);
  EXPECT_NE(std::find(ben.notices.begin(), ben.notices.end(), "ivan presents"), ben.notices.end());
  perform(ivan, step(Verb::point));
  settle();
  EXPECT_TRUE(ben.model.presenting.points.empty());
}

TEST_F(SharedViews, WhoPresentsNextTakesOverAndTheFirstOneFollows) {
  Site& ada = enter("ada");
  Site& ben = enter("ben");
  perform(ada, share(Shares::view));
  settle();
  perform(ben, share(Shares::view));
  settle();
  EXPECT_EQ(ada.view.shares(), Shares::nothing);
  EXPECT_TRUE(ada.view.following().followsView());
  EXPECT_EQ(ben.view.shares(), Shares::view);
  EXPECT_FALSE(ben.view.following().followsView());
}

TEST_F(SharedViews, GoOnAfterAnOutageOfTheServer) {
  Site& ada = enter("ada");
  Site& ben = enter("ben");
  perform(ada, cutBefore(0.01));
  perform(ada, share(Shares::sections));
  settle();
  crash();
  settle(3 * kSecond);
  EXPECT_FALSE(ben.view.following().followsSections()) << "nobody is known to share";
  start();
  settle(5 * kSecond);
  EXPECT_EQ(ben.view.sections(ben.model).at(0).point.x, 0.01);
  ben.view.perform(step(Verb::follow), ben.model);
  settle();
  EXPECT_TRUE(ben.view.sections(ben.model).empty());
  crash();
  settle(3 * kSecond);
  start();
  settle(5 * kSecond);
  EXPECT_EQ(ben.model.presenting.shared.shares, Shares::sections);
  EXPECT_EQ(ben.model.presenting.begun, 1u) << "what goes on is nothing new";
}

/// Ada presents and draws parts apart while Ben presses on one, and together again while his tool is in it.
double kickByExplosion(SharedViews& session, bool naive) {
  Site& ada = session.enter("ada");
  Site& ben = session.enter("ben");
  ben.naive = naive;
  session.perform(ada, share(Shares::view));
  session.settle();
  session.press(ben);
  ScriptStep explode = step(Verb::explode), colour = step(Verb::colour);
  explode.style.explode = 0.5;
  colour.style.colouring = document::PartColouring::byBody;
  session.perform(ada, explode);
  session.perform(ada, colour);
  session.settle(kSecond);
  EXPECT_EQ(ben.force(), 0.0) << "what is drawn apart is not felt at the followers either";
  document::NamedView kept;
  ben.view.keepIn(kept, ben.model);
  EXPECT_EQ(kept.style, (document::PartStyle{0.5, {}, document::PartColouring::byBody, false}));
  ben.device.z = 0.005;
  session.run(100 * kMillisecond);
  explode.style.explode = 0.0;
  session.perform(ada, explode);
  session.settle(kSecond);
  EXPECT_FALSE(ben.settings.lifted);
  EXPECT_EQ(ben.force(), 0.0) << "the tool stands inside of the part";
  return ben.kick;
}

TEST_F(SharedViews, DrawingPartsApartNeverKicksAFollower) { EXPECT_LE(kickByExplosion(*this, false), 0.3); }

TEST_F(SharedViews, AHandThatBeganAnewWithThemWouldBeKicked) { EXPECT_GT(kickByExplosion(*this, true), 0.3); }

TEST_F(SharedViews, WhatIsSaidIsHeardByAllWithItsLinks) {
  Site& ada = enter("ada");
  Site& ben = enter("ben");
  ScriptStep say = step(Verb::say);
  say.text = "look at [box 1], not [box 7]";
  perform(ada, say);
  settle();
  for (const Site* site : {&ada, &ben}) {
    ASSERT_EQ(site->chat.size(), 1u);
    EXPECT_EQ(site->chat[0].line.name, "ada");
    EXPECT_EQ(site->chat[0].line.said.parts, (std::vector<PartId>{PartId{1}, kNoPart}));
  }
  EXPECT_NE(std::find(ben.notices.begin(), ben.notices.end(), "ada says: look at box 1, not [box 7]"),
            ben.notices.end());
  for (int i = 0; i < 20; ++i) perform(ada, say);
  settle(20 * kSecond);
  EXPECT_EQ(ben.chat.size(), 6u) << "a few wait for their turn, the rest is too much";
  EXPECT_EQ(session->counters().droppedSays, 0u);
  const Site& eve = enter("eve");
  settle();
  ASSERT_EQ(eve.chat.size(), 6u) << "who comes late has it too";
  EXPECT_TRUE(eve.chat[0].earlier);
  EXPECT_EQ(eve.chat[0].line.said.text, say.text);
  EXPECT_EQ(std::count_if(eve.notices.begin(), eve.notices.end(),
                          [](const std::string& notice) { return notice.find("says") != std::string::npos; }),
            0);
}

}  // namespace
}  // namespace tandem::client
