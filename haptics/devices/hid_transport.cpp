#include "haptics/devices/hid_transport.h"

#include <hidapi.h>
#include <unistd.h>

#include <algorithm>
#include <mutex>

namespace tandem::haptics {
namespace {

std::string utf8(const wchar_t* text) {
  std::string out;
  for (; text && *text; ++text) {
    const auto c = static_cast<std::uint32_t>(*text);
    const auto put = [&out](std::uint32_t byte) { out.push_back(static_cast<char>(byte)); };
    if (c < 0x80) {
      put(c);
    } else if (c < 0x800) {
      put(0xC0 | c >> 6), put(0x80 | (c & 0x3F));
    } else if (c < 0x10000) {
      put(0xE0 | c >> 12), put(0x80 | (c >> 6 & 0x3F)), put(0x80 | (c & 0x3F));
    } else if (c < 0x110000) {
      put(0xF0 | c >> 18), put(0x80 | (c >> 12 & 0x3F)), put(0x80 | (c >> 6 & 0x3F)), put(0x80 | (c & 0x3F));
    }
  }
  return out;
}

class HidapiConnection : public HidConnection {
 public:
  explicit HidapiConnection(hid_device* device) : device_(device) {}
  ~HidapiConnection() override { hid_close(device_); }
  HidapiConnection(const HidapiConnection&) = delete;
  HidapiConnection& operator=(const HidapiConnection&) = delete;

  int read(std::span<std::uint8_t> buffer, int timeout_ms) override {
    return hid_read_timeout(device_, buffer.data(), buffer.size(), timeout_ms);
  }
  Status write(std::span<const std::uint8_t> report) override {
    if (hid_write(device_, report.data(), report.size()) >= 0) return {};
    return Error{"HID write failed: " + utf8(hid_error(device_))};
  }

 private:
  hid_device* device_;
};

class HidapiBus : public HidBus {
 public:
  std::vector<HidInfo> enumerate() override {
    const std::lock_guard lock(mutex_);
    std::vector<HidInfo> found;
    hid_device_info* const list = hid_enumerate(0, 0);
    for (const hid_device_info* d = list; d; d = d->next) {
      if (!d->path || std::ranges::any_of(found, [d](const HidInfo& info) { return info.path == d->path; }))
        continue;
      found.push_back({d->path, d->vendor_id, d->product_id, utf8(d->manufacturer_string),
                       utf8(d->product_string), utf8(d->serial_number), d->usage_page, d->usage});
    }
    hid_free_enumeration(list);
    return found;
  }

  Result<std::unique_ptr<HidConnection>> open(const std::string& path) override {
    const std::lock_guard lock(mutex_);
    hid_device* const device = hid_open_path(path.c_str());
    if (!device) return Error{path + ": " + utf8(hid_error(nullptr))};
    return std::unique_ptr<HidConnection>(std::make_unique<HidapiConnection>(device));
  }

  bool present(const std::string& path) override { return access(path.c_str(), F_OK) == 0; }

 private:
  std::mutex mutex_;  // hidapi keeps the reason of a failed open or enumeration in one global string
};

}  // namespace

HidBus& systemHidBus() {
  static HidapiBus bus;
  return bus;
}

}  // namespace tandem::haptics
