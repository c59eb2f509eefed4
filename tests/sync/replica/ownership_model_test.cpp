// Three sites, two parts, a server that crashes, a network that delays, doubles and reorders state: every
// interleaving that a seed gives is run through OwnershipTable and OwnershipView, and an independent checker,
// which uses neither, checks what is granted, published and applied. Each control breaks the protocol in one
// place, which the checker must detect.

#include <gtest/gtest.h>

#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <tuple>

#include "sync/replica/lease_rules.h"
#include "sync/replica/ownership_table.h"
#include "sync/replica/ownership_view.h"
#include "sync/wire/ownership_messages.h"
#include "sync/wire/participant_messages.h"
#include "sync/wire/state_update.h"
#include "sync/wire/time.h"
#include "tests/sync/wire/random_messages.h"

namespace tandem::sync {
namespace {

constexpr int kSites = 3;
constexpr PartId kParts = 2;

enum class Mutation {
  none,
  epochNotKept,
  earlyRegrant,
  noEpochCheck,
  noSequenceCheck,
  noRecovery,
  forgetfulRequests,
  publishesForever,
  revivedLease,
  noHeir,
  coHoldersInAnyOrder
};

/// Checks the rules S1-S5, S7, S8 and L2 from outside.
class Checker {
 public:
  std::vector<std::string> violations;

  /// `passedOn`: from its owner to a co-holder, which is no grant while other owners are out.
  void granted(PartId part, Epoch epoch, SiteId site, Micros now, bool passedOn = false) {
    const auto [found, first] = grants_.try_emplace({part, epoch}, site);
    if (!first && found->second != site) violations.push_back("S1: two grants of one epoch");
    if (first && epoch <= highest_[part]) violations.push_back("S1: an epoch that is not larger");
    highest_[part] = std::max(highest_[part], epoch);
    if (first && !passedOn && now < quietUntil_ && !heldOut_.empty())
      violations.push_back("S8: granted while holders are out");
    grantedAt_[{part, epoch}] = now;
    owner_[part] = site;
  }
  void regrantable(PartId part, SiteId oldOwner, Epoch epoch, Micros now) {
    over_[{part, epoch}] = {oldOwner, now};
  }
  void published(PartId part, Epoch epoch, SiteId site, Micros now) {
    const auto over = over_.find({part, epoch});
    if (over != over_.end() && over->second.first == site && now >= over->second.second) {
      violations.push_back("S3: published after the server was free to grant again");
    }
    const auto grant = grants_.find({part, epoch});
    if (grant == grants_.end() || grant->second != site)
      violations.push_back("S1: published without a grant");
  }
  void applied(int at, PartId part, Epoch epoch, std::uint32_t sequence) {
    auto& last = applied_[{at, part}];
    if (std::pair(epoch, sequence) <= last) violations.push_back("S2: something older was applied");
    last = {epoch, sequence};
  }
  void engages(PartId part, SiteId site) { coHolders_[part].insert(site); }
  void disengaged(PartId part, SiteId site) { coHolders_[part].erase(site); }
  /// What the server publishes of a part: its owner and its co-holders.
  void published(PartId part, SiteId owner, const CoHolderRecord& coHolders) {
    std::set<SiteId> sites(coHolders.sites.begin(), coHolders.sites.end());
    if (sites.size() != coHolders.sites.size() || sites.contains(owner))
      violations.push_back("S5: a site is on the list twice, or owns the part");
    if (owner == kNoSite && !sites.empty()) violations.push_back("S5: a part that is simulated has no owner");
    coHolders_[part] = std::move(sites);
  }
  void freed(PartId part) {
    if (!coHolders_[part].empty()) violations.push_back("S5: freed while sites simulate it");
  }
  void coHoldersApplied(int at, const CoHolderRecord& coHolders, int server) {
    const auto [found, first] =
        lists_.try_emplace({server, coHolders.part, coHolders.epoch, coHolders.version}, coHolders.sites);
    if (!first && found->second != coHolders.sites) violations.push_back("S5: two lists of one version");
    auto& last = lastList_[{at, coHolders.part}];
    const std::tuple newest(server, coHolders.epoch, coHolders.version);
    if (newest <= last) violations.push_back("S5: an older list was applied");
    last = newest;
  }
  void answered(SiteId site, RequestId request, const GrabReply& reply) {
    const auto [found, first] = answers_.try_emplace({site, request}, reply.denial, reply.part.epoch);
    if (!first && found->second != std::pair(reply.denial, reply.part.epoch)) {
      violations.push_back("S7: another answer to the same request");
    }
  }
  void serverRestarted(std::set<std::pair<PartId, SiteId>> holders, Micros quietUntil) {
    heldOut_ = std::move(holders);
    quietUntil_ = quietUntil;
    coHolders_.clear();
    answers_.clear();  // answers are not remembered over a restart; see ownership_table.h, invariant 3
  }
  void cameBack(PartId part, SiteId site) { heldOut_.erase({part, site}); }

 private:
  std::map<std::pair<PartId, Epoch>, SiteId> grants_;
  std::map<std::pair<PartId, Epoch>, Micros> grantedAt_;
  std::map<std::pair<PartId, Epoch>, std::pair<SiteId, Micros>> over_;
  std::map<PartId, Epoch> highest_;
  std::map<PartId, SiteId> owner_;
  std::map<std::pair<int, PartId>, std::pair<Epoch, std::uint32_t>> applied_;
  std::map<std::pair<SiteId, RequestId>, std::pair<Denial, Epoch>> answers_;
  std::map<PartId, std::set<SiteId>> coHolders_;
  std::map<std::tuple<int, PartId, Epoch, std::uint32_t>, std::vector<SiteId>> lists_;
  std::map<std::pair<int, PartId>, std::tuple<int, Epoch, std::uint32_t>> lastList_;
  std::set<std::pair<PartId, SiteId>> heldOut_;
  Micros quietUntil_ = 0;
};

class Model {
 public:
  Model(std::uint64_t seed, Mutation mutation) : random_(seed), mutation_(mutation) {
    rules_.lease = 200 * kMillisecond;
    rules_.margin = 5 * kMillisecond;
    for (int i = 0; i < kSites; ++i) {
      sites_.emplace_back(kParts, rules_);
      sites_.back().id = static_cast<SiteId>(i + 1);
      sites_.back().view.setSelf(static_cast<SiteId>(i + 1));
      sites_.back().clockRate = 1.0 + random_.real(-1.0, 1.0) * 0.4 * rules_.driftPpm * 1e-6;
    }
    startServer();
  }

  Checker run(int steps) {
    for (int i = 0; i < steps; ++i) {
      now_ += 1 + static_cast<Micros>(random_.number(8000));
      deliverDue();
      if (table_) serverDuties();
      for (Site& site : sites_) {
        if (site.pausedUntil <= now_) siteActs(site);
      }
      disturb();
    }
    return checker_;
  }

 private:
  struct Site {
    Site(std::size_t parts, LeaseRules rules) : view(parts, rules) {}
    SiteId id = 0;
    OwnershipView view;
    double clockRate = 1.0;
    Micros pausedUntil = 0;
    RequestId nextRequest = 1;
    std::uint32_t sequence = 0;
    std::optional<Grab> waiting;
    std::uint32_t waitingLapses = 0;  // lapses of the lease when the request was first sent
    Micros controlArrives = 0;        // when the last message of the ordered stream from the server arrives
    int connection = 0;
    bool connected = true;
  };
  using Action = std::function<void()>;

  Micros local(const Site& site) const {
    return static_cast<Micros>(static_cast<double>(now_) * site.clockRate);
  }
  void later(Micros delay, Action action) { due_.emplace(now_ + delay, std::move(action)); }
  void deliverDue() {
    while (!due_.empty() && due_.begin()->first <= now_) {
      const Micros time = now_;
      const Action action = std::move(due_.begin()->second);
      due_.erase(due_.begin());
      action();
      now_ = time;
    }
  }
  Micros delay() { return static_cast<Micros>(1000 + random_.number(random_.chance(0.1) ? 150000 : 20000)); }

  void startServer() {
    ++serverRuns_;
    table_.emplace(std::vector<bool>(kParts, true), std::vector<Pose>(kParts), serverRules());
    if (mutation_ == Mutation::epochNotKept) {
      for (PartRecord& record : journal_) record.epoch -= std::min<Epoch>(record.epoch, 1);
    }
    std::set<std::pair<PartId, SiteId>> holders;
    for (PartRecord& record : journal_) {
      if (record.owner != kNoSite) holders.insert({record.part, record.owner});
      if (mutation_ == Mutation::noRecovery) record.owner = kNoSite;
    }
    table_->restore(journal_, now_);
    checker_.serverRestarted(holders, now_ + rules_.serverLease());
  }
  LeaseRules serverRules() const {
    LeaseRules rules = rules_;
    if (mutation_ == Mutation::earlyRegrant) rules.lease /= 8;
    return rules;
  }
  void keep(const PartRecord& record) {
    std::erase_if(journal_, [&](const PartRecord& r) { return r.part == record.part; });
    journal_.push_back(record);
  }
  /// Delivered in order to one site; lost if its connection ends before.
  void publishTo(Site& site, const PartRecord& record) {
    if (!site.connected) return;
    site.controlArrives = std::max(site.controlArrives, now_ + delay());
    const int connection = site.connection;
    later(site.controlArrives - now_, [&site, record, connection] {
      if (site.connection == connection) site.view.apply(record);
    });
  }
  void ended(const PartRecord& record, Epoch oldEpoch, SiteId oldOwner, bool byLease) {
    keep(record);
    if (byLease) checker_.regrantable(record.part, oldOwner, oldEpoch, now_);
    if (record.owner != kNoSite) {
      checker_.granted(record.part, record.epoch, record.owner, now_, true);
    } else {
      checker_.freed(record.part);
    }
    checker_.cameBack(record.part, oldOwner);
    for (Site& site : sites_) publishTo(site, record);
  }
  void publishCoHolders() {
    if (mutation_ == Mutation::noHeir) return;
    for (const CoHolderRecord& coHolders : table_->drainChangedCoHolders()) {
      checker_.published(coHolders.part, table_->part(coHolders.part).owner, coHolders);
      for (Site& site : sites_) publishTo(site, coHolders);
    }
  }
  void publishTo(Site& site, const CoHolderRecord& coHolders) {
    if (!site.connected) return;
    site.controlArrives = std::max(site.controlArrives, now_ + delay());
    const Micros after = mutation_ == Mutation::coHoldersInAnyOrder ? delay() : site.controlArrives - now_;
    const int connection = site.connection, server = serverRuns_;
    later(after, [this, &site, coHolders, connection, server] {
      if (site.connection != connection) return;
      if (site.view.apply(coHolders) || mutation_ == Mutation::coHoldersInAnyOrder)
        checker_.coHoldersApplied(site.id, coHolders, server);
    });
  }
  /// A server that frees parts although they have co-holders.
  void forgetCoHolders(PartId part) {
    for (const SiteId site : table_->coHolders(part).sites) table_->disengage(site, {0, part});
  }

  void serverDuties() {
    std::map<PartId, PartRecord> before;
    for (PartId part = 0; part < kParts; ++part) before[part] = table_->part(part);
    const std::vector<PartRecord> over = table_->expire(now_);
    tellExpired();
    for (const PartRecord& record : over)
      ended(record, before[record.part].epoch, before[record.part].owner, true);
    publishCoHolders();
  }
  /// A site whose pings stopped is no co-holder any more before its parts are passed on.
  void tellExpired() {
    for (PartId part = 0; part < kParts; ++part) {
      const CoHolderRecord coHolders = table_->coHolders(part);
      for (const Site& site : sites_) {
        const bool on =
            std::find(coHolders.sites.begin(), coHolders.sites.end(), site.id) != coHolders.sites.end();
        if (!on) checker_.disengaged(part, site.id);
      }
    }
  }
  void serverGrab(Site& site, const Grab& request) {
    if (!table_ || !site.connected) return;
    const PartRecord before = table_->part(request.part);
    Grab asked = request;
    if (mutation_ == Mutation::forgetfulRequests) asked.request += 1000000 * ++forgotten_;
    auto decision = table_->grab(site.id, Role::participant, asked, now_);
    decision.reply.request = request.request;
    if (decision.reply.denial == Denial::none && before.owner == site.id)
      checker_.cameBack(request.part, site.id);
    if (decision.changed) {
      keep(decision.reply.part);
      if (before.owner != kNoSite) checker_.regrantable(before.part, before.owner, before.epoch, now_);
      const SiteId owner = decision.reply.part.owner;
      checker_.granted(request.part, decision.reply.part.epoch, owner, now_,
                       decision.reply.denial != Denial::none);
      for (Site& other : sites_) publishTo(other, decision.reply.part);
      publishCoHolders();
    }
    checker_.answered(site.id, request.request, decision.reply);
    const GrabReply reply = decision.reply;
    site.controlArrives = std::max(site.controlArrives, now_ + delay());
    later(site.controlArrives - now_, [&site, reply, connection = site.connection] {
      if (site.connection != connection) return;
      site.view.apply(reply.part);
      if (!site.waiting || site.waiting->request != reply.request) return;
      site.waiting.reset();
      if (reply.denial == Denial::none && site.view.lapses() == site.waitingLapses)
        site.view.confirmed(reply.part.part, reply.part.epoch);
    });
  }
  void serverRelease(Site& site, const Release& request) {
    if (!table_ || !site.connected) return;
    if (mutation_ == Mutation::noHeir) forgetCoHolders(request.part);
    const auto decision = table_->release(site.id, request);
    if (decision.changed) ended(decision.reply.part, request.epoch, site.id, false);
    publishCoHolders();
  }
  void serverEngage(Site& site, PartId part, bool on, std::uint32_t lapses) {
    if (!table_ || !site.connected) return;
    if (on) {
      const auto decision = table_->engage(site.id, Role::participant, {0, part}, now_);
      if (decision.changed) checker_.engages(part, site.id);
      if (decision.reply.denial == Denial::none) {
        site.controlArrives = std::max(site.controlArrives, now_ + delay());
        later(site.controlArrives - now_, [&site, part, lapses, c = site.connection] {
          if (site.connection == c && site.view.lapses() == lapses) site.view.coHoldingConfirmed(part);
        });
      }
    } else if (table_->disengage(site.id, {0, part}).changed) {
      checker_.disengaged(part, site.id);
    }
    publishCoHolders();
  }
  void serverState(Site& site, const PartState& state) {
    if (!table_) return;
    if (!table_->accept(site.id, state) && mutation_ != Mutation::noEpochCheck) return;
    if (table_->part(state.part).owner == site.id) checker_.cameBack(state.part, site.id);
    checker_.applied(0, state.part, state.epoch, state.sequence);
    for (Site& other : sites_) {
      if (other.id == site.id) continue;
      for (int copies = random_.chance(0.1) ? 2 : 1; copies > 0; --copies) {
        later(delay(), [this, &other, &site, state] { siteState(other, site.id, state); });
      }
    }
  }
  void siteState(Site& site, SiteId from, const PartState& state) {
    const auto verdict = site.view.accept(from, state);
    const bool use =
        verdict == OwnershipView::Verdict::accepted ||
        (mutation_ == Mutation::noSequenceCheck && verdict == OwnershipView::Verdict::oldSequence);
    if (use) checker_.applied(site.id, state.part, state.epoch, state.sequence);
  }

  void siteActs(Site& site) {
    if (!site.connected) return reconnect(site);
    const bool up = table_.has_value();
    if (up && random_.chance(0.3)) {  // ping and pong
      const Micros sent = local(site);
      const int connection = site.connection;
      later(delay(), [this, &site, sent, connection] {
        if (!table_ || site.connection != connection) return;
        table_->renew(site.id, now_);
        later(delay(), [this, &site, sent, connection] {
          if (site.connection != connection) return;
          if (mutation_ == Mutation::revivedLease) {
            site.view.renewed(sent);
          } else {
            site.view.renewed(sent, local(site));
          }
        });
      });
    }
    if (!site.waiting && random_.chance(0.2)) {
      site.waiting = Grab{site.nextRequest++, static_cast<PartId>(random_.number(kParts))};
      site.waitingLapses = site.view.lapses();
      send(site, *site.waiting);
    } else if (site.waiting && random_.chance(0.05)) {
      send(site, *site.waiting);  // again
    }
    if (random_.chance(0.2)) {
      const auto part = static_cast<PartId>(random_.number(kParts));
      later(delay(),
            [this, &site, part, on = random_.chance(0.7), c = site.connection, lapses = site.view.lapses()] {
              if (site.connection == c) serverEngage(site, part, on, lapses);
            });
    }
    for (PartId part = 0; part < kParts; ++part) {
      if (site.view.needsReclaim(part)) reclaim(site, part);
      const bool may = site.view.mayPublish(part, local(site)) ||
                       (mutation_ == Mutation::publishesForever && site.view.owns(part));
      if (!may) continue;
      const PartState state{part, site.view.part(part).epoch, ++site.sequence, {}, {}};
      checker_.published(part, state.epoch, site.id, now_);
      for (int copies = random_.chance(0.1) ? 2 : 1; copies > 0; --copies) {
        // A datagram is sealed for its connection: no datagram of an earlier one is accepted.
        later(delay(), [this, &site, state, c = site.connection] {
          if (site.connection == c) serverState(site, state);
        });
      }
      if (random_.chance(0.1)) {
        const Release release{site.nextRequest++, part, state.epoch, {}};
        later(delay(), [this, &site, release, c = site.connection] {
          if (site.connection == c) serverRelease(site, release);
        });
      }
    }
  }
  void send(Site& site, const Grab& grab) {
    later(delay(), [this, &site, grab, c = site.connection] {
      if (site.connection == c) serverGrab(site, grab);
    });
  }
  void reclaim(Site& site, PartId part) {
    if (!random_.chance(0.3)) return;
    const Reclaim request{site.nextRequest++, part, site.view.part(part).epoch, {}};
    later(delay(), [this, &site, request, c = site.connection, lapses = site.view.lapses()] {
      if (!table_ || site.connection != c) return;
      const auto decision = table_->reclaim(site.id, Role::participant, request, now_);
      if (decision.reply.denial != Denial::none) return;
      checker_.cameBack(request.part, site.id);
      site.controlArrives = std::max(site.controlArrives, now_ + delay());
      later(site.controlArrives - now_, [&site, request, c, lapses] {
        if (site.connection == c && site.view.lapses() == lapses)
          site.view.confirmed(request.part, request.epoch);
      });
    });
  }
  void reconnect(Site& site) {
    if (!table_ || !random_.chance(0.2)) return;
    site.connected = true;
    ++site.connection;
    site.controlArrives = now_;
    site.view.forgetCoHolders();
    for (const PartRecord& record : table_->records()) site.view.apply(record);  // Welcome
    for (const CoHolderRecord& coHolders : table_->allCoHolders()) site.view.apply(coHolders);
    for (PartId part = 0; part < kParts; ++part) {
      if (!site.view.owns(part)) continue;
      const auto decision = table_->reclaim(site.id, Role::participant,
                                            {site.nextRequest++, part, site.view.part(part).epoch, {}}, now_);
      if (decision.reply.denial == Denial::none) checker_.cameBack(part, site.id);
    }
    if (site.waiting) send(site, *site.waiting);
  }
  void disturb() {
    if (table_ && random_.chance(0.01)) {  // the server dies
      table_.reset();
      for (Site& site : sites_) {
        site.connected = false;
        ++site.connection;
      }
    } else if (!table_ && random_.chance(0.1)) {
      startServer();
    }
    if (random_.chance(0.01)) {
      sites_[random_.number(kSites)].pausedUntil = now_ + static_cast<Micros>(random_.number(600000));
    }
  }

  testing::RandomMessages random_;
  Mutation mutation_;
  LeaseRules rules_;
  std::deque<Site> sites_;
  std::optional<OwnershipTable> table_;
  std::vector<PartRecord> journal_;
  std::multimap<Micros, Action> due_;
  Checker checker_;
  Micros now_ = 0;
  RequestId forgotten_ = 0;
  int serverRuns_ = 0;
};

TEST(OwnershipModel, KeepsItsPromisesOverTwoThousandFiveHundredHistories) {
  for (std::uint64_t seed = 1; seed <= 2500; ++seed) {
    const Checker checker = Model(seed, Mutation::none).run(300);
    ASSERT_TRUE(checker.violations.empty()) << "seed " << seed << ": " << checker.violations[0];
  }
}

/// How many of the histories break the rule `rule`.
int broken(Mutation mutation, const std::string& rule, std::uint64_t histories = 100) {
  int count = 0;
  for (std::uint64_t seed = 1; seed <= histories; ++seed) {
    const Checker checker = Model(seed, mutation).run(300);
    count += std::any_of(checker.violations.begin(), checker.violations.end(),
                         [&](const std::string& v) { return v.compare(0, 2, rule) == 0; });
  }
  return count;
}

TEST(OwnershipModel, NoticesWhatABrokenProtocolWouldDo) {
  EXPECT_GT(broken(Mutation::epochNotKept, "S1"), 10);
  EXPECT_GT(broken(Mutation::earlyRegrant, "S3"), 10);
  EXPECT_GT(broken(Mutation::revivedLease, "S3", 2500), 0)
      << "a pong revives a lease whose part the server freed";
  EXPECT_GT(broken(Mutation::noEpochCheck, "S2"), 10);
  EXPECT_GT(broken(Mutation::noSequenceCheck, "S2"), 10);
  EXPECT_GT(broken(Mutation::noRecovery, "S8"), 10);
  EXPECT_GT(broken(Mutation::forgetfulRequests, "S7"), 10);
  EXPECT_GT(broken(Mutation::noHeir, "S5"), 10);
  EXPECT_GT(broken(Mutation::coHoldersInAnyOrder, "S5"), 10);
  EXPECT_GT(broken(Mutation::publishesForever, "S3", 400), 4) << "needs a pause of just the right length";
}

}  // namespace
}  // namespace tandem::sync
