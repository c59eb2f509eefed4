#pragma once

// A SpaceMouse Pro that exists only in this process: umockdev shows it to libudev and to libc, so that the
// unmodified libhidapi-hidraw finds, opens, reads and writes it.
//
// The program must run with umockdev's library preloaded. One device at a time; all calls from one thread.

#include <cstdint>
#include <functional>
#include <mutex>
#include <span>
#include <string>
#include <vector>

struct _UMockdevTestbed;
struct _UMockdevIoctlBase;

namespace tandem::haptics::testing {

/// Whether umockdev's library is preloaded; without it nothing here works.
bool mockedBusAvailable();

/// Another device in the SpaceMouse's place.
struct MockModel {
  std::uint16_t vendor = 0, product = 0;
  std::string name;
  std::vector<std::uint8_t> descriptor;
  /// The feature report of an id, as the device answers it; empty: it stalls. Called from another thread.
  std::function<std::vector<std::uint8_t>(std::uint8_t id)> feature;
};

/// A bus with nothing on it.
class MockBus {
 public:
  MockBus();
  ~MockBus();
  MockBus(const MockBus&) = delete;
  MockBus& operator=(const MockBus&) = delete;

  /// Plugs the device in as /dev/hidrawN. False when umockdev refuses it.
  bool plug(int number);
  bool plug(int number, const MockModel& model);
  void unplug();

  /// The device sends one input report; waits (at most two seconds) until the driver seems to have read it: a
  /// hidraw node keeps reports apart, the terminal that stands in for it may run two of them together.
  bool deliver(std::span<const std::uint8_t> report);
  /// What the driver has written since the last call, waiting at most two seconds for `count` bytes.
  std::vector<std::uint8_t> written(std::size_t count);

  /// Feature reports that the driver has set, oldest first.
  std::vector<std::vector<std::uint8_t>> features();
  /// Called by umockdev for each ioctl of a MockModel; false: not known here.
  bool handleIoctl(void* client);

  /// Permission bits of the device's node.
  bool setMode(unsigned mode);
  /// As the program sees it.
  const std::string& node() const { return node_; }

 private:
  std::string realNode() const;
  bool add(int number, const MockModel& model);
  bool openEnds();

  _UMockdevTestbed* testbed_;
  _UMockdevIoctlBase* handler_ = nullptr;
  MockModel model_;
  std::mutex mutex_;
  std::vector<std::vector<std::uint8_t>> features_;  // under mutex_
  std::string root_, node_;
  std::vector<std::string> paths_;  // in /sys, parents first
  int device_ = -1;                 // the device's end; umockdev owns it
  int probe_ = -1;                  // a second handle on the driver's end
};

/// While it lives, permission bits bind this thread even if it runs as root.
class WithoutRootOverride {
 public:
  WithoutRootOverride();
  ~WithoutRootOverride();
  WithoutRootOverride(const WithoutRootOverride&) = delete;
  WithoutRootOverride& operator=(const WithoutRootOverride&) = delete;

 private:
  std::uint32_t effective_[2] = {};
};

}  // namespace tandem::haptics::testing
