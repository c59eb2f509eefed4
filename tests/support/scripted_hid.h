#pragma once

// A HID bus with at most one device on it, whose reports the test writes and whose orders it reads.
// Thread-safe.

#include <algorithm>
#include <chrono>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>

#include "haptics/devices/hid_transport.h"

namespace tandem::haptics::testing {

class ScriptedHid : public HidBus {
 public:
  using Bytes = std::vector<std::uint8_t>;

  explicit ScriptedHid(HidInfo info) : info_(std::move(info)) {}

  std::vector<HidInfo> enumerate() override {
    const std::lock_guard lock(mutex_);
    return plugged_ ? std::vector{info_} : std::vector<HidInfo>{};
  }
  Result<std::unique_ptr<HidConnection>> open(const std::string&) override {
    return std::unique_ptr<HidConnection>(std::make_unique<Connection>(*this));
  }
  Result<std::vector<std::uint8_t>> descriptor(const std::string&) override {
    if (descriptor_.empty()) return Error{"no descriptor"};
    return descriptor_;
  }
  bool present(const std::string&) override {
    const std::lock_guard lock(mutex_);
    return plugged_;
  }

  void send(Bytes report) {
    const std::lock_guard lock(mutex_);
    reports_.push_back(std::move(report));
  }
  void plug(bool plugged) {
    const std::lock_guard lock(mutex_);
    plugged_ = plugged;
  }
  void describe(Bytes descriptor) { descriptor_ = std::move(descriptor); }
  /// What the device answers when it is asked for a feature report.
  void answer(std::function<Bytes(std::uint8_t id)> answer) { answer_ = std::move(answer); }
  /// Output reports since the last call, oldest first.
  std::vector<Bytes> written() {
    const std::lock_guard lock(mutex_);
    return std::exchange(written_, {});
  }
  std::vector<Bytes> features() {
    const std::lock_guard lock(mutex_);
    return std::exchange(features_, {});
  }

 private:
  class Connection : public HidConnection {
   public:
    explicit Connection(ScriptedHid& bus) : bus_(bus) {}
    int read(std::span<std::uint8_t> buffer, int) override {
      {
        const std::lock_guard lock(bus_.mutex_);
        if (!bus_.plugged_) return -1;
        if (!bus_.reports_.empty()) {
          const Bytes report = std::move(bus_.reports_.front());
          bus_.reports_.pop_front();
          std::ranges::copy(report, buffer.begin());
          return static_cast<int>(report.size());
        }
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      return 0;
    }
    Status write(std::span<const std::uint8_t> report) override {
      const std::lock_guard lock(bus_.mutex_);
      if (!bus_.plugged_) return Error{"gone"};
      bus_.written_.emplace_back(report.begin(), report.end());
      return {};
    }
    Status sendFeature(std::span<const std::uint8_t> report) override {
      const std::lock_guard lock(bus_.mutex_);
      bus_.features_.emplace_back(report.begin(), report.end());
      return {};
    }
    Result<std::size_t> getFeature(std::span<std::uint8_t> report) override {
      if (!bus_.answer_) return Error{"stalled"};
      const Bytes answer = bus_.answer_(report[0]);
      if (answer.empty()) return Error{"stalled"};
      const std::size_t length = std::min(answer.size(), report.size());
      std::copy_n(answer.begin(), length, report.begin());
      return length;
    }
    Result<Bytes> descriptor() override { return bus_.descriptor(""); }

   private:
    ScriptedHid& bus_;
  };

  std::mutex mutex_;
  HidInfo info_;
  bool plugged_ = true;
  std::deque<Bytes> reports_;
  std::vector<Bytes> written_, features_;
  Bytes descriptor_;
  std::function<Bytes(std::uint8_t)> answer_;
};

}  // namespace tandem::haptics::testing
