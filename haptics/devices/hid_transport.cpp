#include "haptics/devices/hid_transport.h"

#include <fcntl.h>
#include <hidapi.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
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

Result<std::vector<std::uint8_t>> descriptorOf(const std::string& path) {
  // hidapi can request it since 0.14; Linux keeps a copy beside the node.
  const std::string node = path.substr(path.rfind('/') + 1);
  const std::string file = "/sys/class/hidraw/" + node + "/device/report_descriptor";
  std::FILE* const in = std::fopen(file.c_str(), "rb");
  if (!in) return Error{file + ": cannot be read"};
  std::vector<std::uint8_t> bytes(4096);  // the kernel's limit
  bytes.resize(std::fread(bytes.data(), 1, bytes.size(), in));
  std::fclose(in);
  return bytes;
}

class HidapiConnection : public HidConnection {
 public:
  HidapiConnection(hid_device* device, std::string path) : device_(device), path_(std::move(path)) {}
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
  Status sendFeature(std::span<const std::uint8_t> report) override {
    if (hid_send_feature_report(device_, report.data(), report.size()) >= 0) return {};
    return Error{"HID feature report refused: " + utf8(hid_error(device_))};
  }
  Result<std::size_t> getFeature(std::span<std::uint8_t> report) override {
    const int length = hid_get_feature_report(device_, report.data(), report.size());
    if (length >= 0) return static_cast<std::size_t>(length);
    return Error{"HID feature report not given: " + utf8(hid_error(device_))};
  }
  Result<std::vector<std::uint8_t>> descriptor() override { return descriptorOf(path_); }

 private:
  hid_device* device_;
  std::string path_;
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
    return std::unique_ptr<HidConnection>(std::make_unique<HidapiConnection>(device, path));
  }

  Result<std::vector<std::uint8_t>> descriptor(const std::string& path) override {
    return descriptorOf(path);
  }

  bool forbids(const std::string& path) override {
    const int file = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    if (file >= 0) ::close(file);
    return file < 0 && (errno == EACCES || errno == EPERM);
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
