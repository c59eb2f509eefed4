#include "haptics/devices/hid_record.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <sstream>

namespace tandem::haptics {
namespace {

using Bytes = std::vector<std::uint8_t>;

std::string hexOf(std::span<const std::uint8_t> bytes) {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

/// Empty when the text is no bytes.
Bytes bytesOf(const std::string& hex) {
  Bytes bytes;
  if (hex.size() % 2 != 0 || hex.size() > 2 * kLongestReport) return bytes;
  const auto digit = [](char c) {
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
  };
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    const int high = digit(hex[i]), low = digit(hex[i + 1]);
    if (high < 0 || low < 0) return {};
    bytes.push_back(static_cast<std::uint8_t>(high << 4 | low));
  }
  return bytes;
}

}  // namespace

/// The file, shared by the connections of one recording.
class RecordingHidBus::Writer {
 public:
  explicit Writer(std::FILE* file) : file_(file) {}
  ~Writer() {
    if (file_) std::fclose(file_);
  }
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  void device(const HidInfo& info, const Bytes& descriptor) {
    const std::lock_guard lock(mutex_);
    if (!file_) return;
    std::string name = info.productName;
    std::replace_if(
        name.begin(), name.end(), [](unsigned char c) { return c < 0x20; }, ' ');
    std::fprintf(file_, "device %04x:%04x %x:%x %s\n", info.vendor, info.product, info.usagePage, info.usage,
                 name.c_str());
    if (!descriptor.empty()) std::fprintf(file_, "descriptor %s\n", hexOf(descriptor).c_str());
  }
  void feature(std::span<const std::uint8_t> bytes) {
    const std::lock_guard lock(mutex_);
    if (file_) std::fprintf(file_, "feature %s\n", hexOf(bytes).c_str());
  }
  void input(std::span<const std::uint8_t> bytes) {
    const std::lock_guard lock(mutex_);
    if (!file_) return;
    const std::chrono::duration<double> since = std::chrono::steady_clock::now() - start_;
    std::fprintf(file_, "in %.6f %s\n", since.count(), hexOf(bytes).c_str());
    ++count_;
  }
  Result<std::uint64_t> finish() {
    const std::lock_guard lock(mutex_);
    if (!file_) return count_;
    const bool failed = std::ferror(file_) != 0;
    const bool closed = std::fclose(file_) == 0;
    file_ = nullptr;
    if (failed || !closed)
      return Error{std::string("the recording could not be written: ") + std::strerror(errno)};
    return count_;
  }

 private:
  std::mutex mutex_;
  std::FILE* file_;
  std::uint64_t count_ = 0;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

class RecordingHidBus::Connection : public HidConnection {
 public:
  Connection(std::unique_ptr<HidConnection> inner, std::shared_ptr<Writer> writer)
      : inner_(std::move(inner)), writer_(std::move(writer)) {}

  int read(std::span<std::uint8_t> buffer, int timeout_ms) override {
    const int length = inner_->read(buffer, timeout_ms);
    if (length > 0) writer_->input(buffer.first(static_cast<std::size_t>(length)));
    return length;
  }
  Status write(std::span<const std::uint8_t> report) override { return inner_->write(report); }
  Status sendFeature(std::span<const std::uint8_t> report) override { return inner_->sendFeature(report); }
  Result<std::size_t> getFeature(std::span<std::uint8_t> report) override {
    Result<std::size_t> length = inner_->getFeature(report);
    if (length) writer_->feature(report.first(std::min(*length, report.size())));
    return length;
  }
  Result<Bytes> descriptor() override { return inner_->descriptor(); }

 private:
  std::unique_ptr<HidConnection> inner_;
  std::shared_ptr<Writer> writer_;
};

RecordingHidBus::RecordingHidBus(HidBus& bus, std::shared_ptr<Writer> writer)
    : bus_(bus), writer_(std::move(writer)) {}

RecordingHidBus::~RecordingHidBus() = default;

Result<std::unique_ptr<RecordingHidBus>> RecordingHidBus::create(HidBus& bus, const std::string& file) {
  std::FILE* const out = std::fopen(file.c_str(), "w");
  if (!out) return Error{file + ": " + std::strerror(errno)};
  return std::unique_ptr<RecordingHidBus>(new RecordingHidBus(bus, std::make_shared<Writer>(out)));
}

std::vector<HidInfo> RecordingHidBus::enumerate() { return bus_.enumerate(); }
Result<Bytes> RecordingHidBus::descriptor(const std::string& path) { return bus_.descriptor(path); }
bool RecordingHidBus::forbids(const std::string& path) { return bus_.forbids(path); }
bool RecordingHidBus::present(const std::string& path) { return bus_.present(path); }
Result<std::uint64_t> RecordingHidBus::finish() { return writer_->finish(); }

Result<std::unique_ptr<HidConnection>> RecordingHidBus::open(const std::string& path) {
  auto opened = bus_.open(path);
  if (!opened) return opened;
  HidInfo info;
  for (HidInfo& known : bus_.enumerate())
    if (known.path == path) info = std::move(known);
  Result<Bytes> descriptor = bus_.descriptor(path);
  writer_->device(info, descriptor ? *descriptor : Bytes{});
  return std::unique_ptr<HidConnection>(std::make_unique<Connection>(std::move(opened).value(), writer_));
}

Result<HidRecording> parseHidRecording(const std::string& text, const std::string& source) {
  HidRecording recording;
  std::istringstream lines(text);
  std::string line;
  bool device = false;
  for (int number = 1; std::getline(lines, line); ++number) {
    const Error wrong{source + ", line " + std::to_string(number) + ": not a line of a HID recording"};
    std::istringstream words(line);
    std::string kind, hex;
    words >> kind;
    if (kind == "device") {
      unsigned vendor = 0, product = 0, page = 0, usage = 0;
      int name = 0;
      if (std::sscanf(line.c_str(), "device %4x:%4x %4x:%4x %n", &vendor, &product, &page, &usage, &name) !=
          4)
        return wrong;
      recording.info.vendor = static_cast<std::uint16_t>(vendor);
      recording.info.product = static_cast<std::uint16_t>(product);
      recording.info.usagePage = static_cast<std::uint16_t>(page);
      recording.info.usage = static_cast<std::uint16_t>(usage);
      if (name > 0) recording.info.productName = line.substr(static_cast<std::size_t>(name));
      device = true;
      continue;
    }
    HidRecording::Report report;
    if (kind == "in" && (!(words >> report.time) || !std::isfinite(report.time))) return wrong;
    words >> hex;
    report.bytes = bytesOf(hex);
    if (!device || report.bytes.empty()) return wrong;
    if (kind == "in")
      recording.reports.push_back(std::move(report));
    else if (kind == "feature")
      recording.features.push_back(std::move(report.bytes));
    else if (kind == "descriptor")
      recording.descriptor = std::move(report.bytes);
    else
      return wrong;
  }
  if (!device) return Error{source + ": no HID recording: it names no device"};
  return recording;
}

}  // namespace tandem::haptics
