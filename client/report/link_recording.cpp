#include "client/report/link_recording.h"

#include <algorithm>
#include <utility>

#include "assets/base/assert.h"

namespace tandem::client::report {
namespace {

class RecordedEnd : public bench::LinkEnd {
 public:
  RecordedEnd(std::unique_ptr<bench::LinkEnd> end, std::shared_ptr<LinkRecording> recording)
      : end_(std::move(end)), recording_(std::move(recording)) {}

  void receive(const haptics::LinkPacket& packet) override {
    recording_->received.push_back(packet);
    end_->receive(packet);
  }
  haptics::LinkPull pull(double now, const Pose& worldFromCentre, const Twist& twist) override {
    LinkRecording::Tick& tick = recording_->ticks.emplace_back();
    tick.now = now;
    tick.before = worldFromCentre;
    tick.twistBefore = twist;
    tick.received = recording_->received.size();
    return end_->pull(now, worldFromCentre, twist);
  }
  void account(const Pose& worldFromCentre, const Twist& twist) override {
    ASSERT(!recording_->ticks.empty());  // pull() begins a tick
    recording_->ticks.back().after = worldFromCentre;
    recording_->ticks.back().twistAfter = twist;
    end_->account(worldFromCentre, twist);
    recording_->ticks.back().off = end_->apart();
  }
  haptics::LinkPacket packet(double now) override {
    ASSERT(!recording_->ticks.empty());
    recording_->ticks.back().sends = true;
    return recording_->sent.emplace_back(end_->packet(now));
  }
  double addedMass() const override { return end_->addedMass(); }
  bool apart() const override { return end_->apart(); }
  double delay() const override { return end_->delay(); }
  haptics::LinkAccount account() const override { return end_->account(); }

 private:
  std::unique_ptr<bench::LinkEnd> end_;
  std::shared_ptr<LinkRecording> recording_;
};

}  // namespace

double LinkRecording::offShare() const {
  const auto off = std::count_if(ticks.begin(), ticks.end(), [](const Tick& tick) { return tick.off; });
  return static_cast<double>(off) / static_cast<double>(std::max<std::size_t>(1, ticks.size()));
}

bench::LinkEndMaker recordingFirst(bench::LinkEndMaker make, std::shared_ptr<LinkRecording> recording) {
  return [make = std::move(make), recording = std::move(recording), first = true](
             const haptics::LinkParameters& parameters,
             double delay) mutable -> std::unique_ptr<bench::LinkEnd> {
    std::unique_ptr<bench::LinkEnd> end = make(parameters, delay);
    if (!std::exchange(first, false)) return end;
    return std::make_unique<RecordedEnd>(std::move(end), recording);
  };
}

void replay(const LinkRecording& recording, bench::LinkEnd& end) {
  std::size_t received = 0;
  for (const LinkRecording::Tick& tick : recording.ticks) {
    ASSERT(tick.received <= recording.received.size());
    for (; received < tick.received; ++received) end.receive(recording.received[received]);
    end.pull(tick.now, tick.before, tick.twistBefore);
    end.account(tick.after, tick.twistAfter);
    if (tick.sends) end.packet(tick.now);
  }
}

}  // namespace tandem::client::report
