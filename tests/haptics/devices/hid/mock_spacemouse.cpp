#include "tests/haptics/devices/hid/mock_spacemouse.h"

#include <fcntl.h>
#include <linux/capability.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <umockdev.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>
#include <utility>

namespace tandem::haptics::testing {
namespace {

constexpr auto kPatience = std::chrono::seconds(2);

/// Multi-axis controller with the reports of the Pro: 1 translation, 2 rotation, 3 buttons, 4 the light.
constexpr std::uint8_t kDescriptor[] = {
    0x05, 0x01, 0x09, 0x08, 0xa1, 0x01,                          // generic desktop, multi-axis controller
    0xa1, 0x00, 0x85, 0x01,                                      // report 1
    0x16, 0xa2, 0xfe, 0x26, 0x5e, 0x01, 0x75, 0x10, 0x95, 0x03,  // -350..350, three of 16 bits
    0x09, 0x30, 0x09, 0x31, 0x09, 0x32, 0x81, 0x06, 0xc0,        // X Y Z, input, relative
    0xa1, 0x00, 0x85, 0x02, 0x09, 0x33, 0x09, 0x34, 0x09, 0x35, 0x81, 0x06, 0xc0,  // report 2: Rx Ry Rz
    0xa1, 0x00, 0x85, 0x03, 0x05, 0x09, 0x19, 0x01, 0x29, 0x20,                    // report 3: buttons 1..32
    0x15, 0x00, 0x25, 0x01, 0x75, 0x01, 0x95, 0x20, 0x81, 0x02, 0xc0,              // of one bit
    0xa1, 0x02, 0x85, 0x04, 0x05, 0x08, 0x09, 0x4b,                                // report 4: the light
    0x75, 0x08, 0x95, 0x01, 0x91, 0x02, 0xc0, 0xc0};

std::string hex(std::span<const std::uint8_t> bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    char digits[3];
    std::snprintf(digits, sizeof digits, "%02X", byte);
    text += digits;
  }
  return text;
}

/// The answers to HIDIOCGRDESCSIZE and HIDIOCGRDESC, in umockdev's format for recorded ioctls.
std::string recordedIoctls(const std::string& node) {
  const auto size = static_cast<std::uint8_t>(sizeof kDescriptor);
  static_assert(sizeof kDescriptor < 256);
  std::vector<std::uint8_t> structure{size, 0, 0, 0};
  structure.insert(structure.end(), std::begin(kDescriptor), std::end(kDescriptor));
  structure.resize(4 + 4096);  // struct hidraw_report_descriptor
  return "@DEV " + node + "\nHIDIOCGRDESCSIZE 0 " + hex(std::span(structure).first(4)) + "\nHIDIOCGRDESC 0 " +
         hex(structure) + "\n";
}

/// 0003:046D:C62B and the like.
std::string busName(const MockModel& model) {
  char text[32];
  std::snprintf(text, sizeof text, "0003:%04X:%04X", model.vendor, model.product);
  return text;
}

std::string description(std::span<const std::string> paths, int number, const MockModel& model) {
  const std::string name = "hidraw" + std::to_string(number);
  char ids[64], hidId[48];
  std::snprintf(ids, sizeof ids, "A: idVendor=%04x\\n\nA: idProduct=%04x\\n\n", model.vendor, model.product);
  std::snprintf(hidId, sizeof hidId, "0003:%08X:%08X", model.vendor, model.product);
  return "P: " + paths[0] + "\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\n" + ids +
         "A: manufacturer=Maker\\n\nA: product=" + model.name + "\\n\nA: bcdDevice=0431\\n\n\n" +
         "P: " + paths[1] + "\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_interface\nA: bInterfaceNumber=00\\n\n\n" +
         "P: " + paths[2] + "\nE: SUBSYSTEM=hid\nE: HID_ID=" + hidId + "\nE: HID_NAME=" + model.name +
         "\nE: HID_UNIQ=\nH: report_descriptor=" + hex(model.descriptor) + "\n\nP: " + paths[3] +
         "\nN: " + name + "\nE: SUBSYSTEM=hidraw\nE: DEVNAME=/dev/" + name +
         "\nE: MAJOR=240\nE: MINOR=" + std::to_string(number) + "\nL: device=../../../" + busName(model) +
         ".0001\n\n";
}

/// False, with a line on stderr, when there was an error.
bool succeeded(gboolean done, GError* error, const char* what) {
  if (done) return true;
  std::fprintf(stderr, "umockdev, %s: %s\n", what, error ? error->message : "no reason given");
  g_clear_error(&error);
  return false;
}

void capabilities(long call, __user_cap_data_struct (&data)[2]) {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  if (syscall(call, &header, data) != 0) std::perror("capabilities");
}

gboolean onIoctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer bus) {
  return static_cast<MockBus*>(bus)->handleIoctl(client) ? TRUE : FALSE;
}

}  // namespace

bool mockedBusAvailable() {
  // umockdev looks for its test bed, so there must be one.
  UMockdevTestbed* const testbed = umockdev_testbed_new();
  const bool available = umockdev_in_mock_environment() != 0;
  g_object_unref(testbed);
  return available;
}

MockBus::MockBus() : testbed_(umockdev_testbed_new()) {
  gchar* const root = umockdev_testbed_get_root_dir(testbed_);
  root_ = root;
  g_free(root);
}

MockBus::~MockBus() {
  if (probe_ >= 0) close(probe_);
  if (handler_) {
    if (!node_.empty()) umockdev_testbed_detach_ioctl(testbed_, node_.c_str(), nullptr);
    g_object_unref(handler_);
  }
  g_object_unref(testbed_);
}

std::string MockBus::realNode() const {
  char* const path = realpath((root_ + node_).c_str(), nullptr);
  const std::string real = path ? path : "";
  std::free(path);
  return real;
}

bool MockBus::add(int number, const MockModel& model) {
  const std::string usb = "/devices/pci0000:00/0000:00:14.0/usb1/1-" + std::to_string(number + 1);
  const std::string interface = usb + "/1-" + std::to_string(number + 1) + ":1.0";
  const std::string hid = interface + "/" + busName(model) + ".0001";
  paths_ = {usb, interface, hid, hid + "/hidraw/hidraw" + std::to_string(number)};
  node_ = "/dev/hidraw" + std::to_string(number);
  GError* error = nullptr;
  const std::string text = description(paths_, number, model);
  return succeeded(umockdev_testbed_add_from_string(testbed_, text.c_str(), &error), error, "add");
}

bool MockBus::openEnds() {
  device_ = umockdev_testbed_get_dev_fd(testbed_, node_.c_str());
  probe_ = open(realNode().c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  return device_ >= 0 && probe_ >= 0;
}

bool MockBus::plug(int number) {
  const MockModel spaceMouse{
      0x046d, 0xc62b, "SpaceMouse Pro", {std::begin(kDescriptor), std::end(kDescriptor)}, {}};
  if (!add(number, spaceMouse)) return false;
  const std::string recorded = root_ + "/recorded_ioctls";
  std::FILE* const file = std::fopen(recorded.c_str(), "w");
  if (!file) return false;
  std::fputs(recordedIoctls(node_).c_str(), file);
  std::fclose(file);
  GError* error = nullptr;
  const gboolean loaded = umockdev_testbed_load_ioctl(testbed_, node_.c_str(), recorded.c_str(), &error);
  return succeeded(loaded, error, "ioctls") && openEnds();
}

bool MockBus::plug(int number, const MockModel& model) {
  model_ = model;
  if (!add(number, model)) return false;
  handler_ = umockdev_ioctl_base_new();
  g_signal_connect(handler_, "handle-ioctl", G_CALLBACK(&onIoctl), this);
  GError* error = nullptr;
  const gboolean attached = umockdev_testbed_attach_ioctl(testbed_, node_.c_str(), handler_, &error);
  return succeeded(attached, error, "attach") && openEnds();
}

bool MockBus::handleIoctl(void* opaque) {
  auto* const client = static_cast<UMockdevIoctlClient*>(opaque);
  const gulong request = umockdev_ioctl_client_get_request(client);
  if (_IOC_TYPE(request) != 'H') return false;
  UMockdevIoctlData* const data =
      umockdev_ioctl_data_resolve(umockdev_ioctl_client_get_arg(client), 0, _IOC_SIZE(request), nullptr);
  if (!data) return false;
  const std::span<std::uint8_t> bytes(static_cast<std::uint8_t*>(static_cast<void*>(data->data)),
                                      _IOC_SIZE(request));
  long result = static_cast<long>(bytes.size());
  if (_IOC_NR(request) == 0x01 || _IOC_NR(request) == 0x02) {  // size of the descriptor; the descriptor
    const auto size = static_cast<std::uint32_t>(model_.descriptor.size());
    std::memcpy(bytes.data(), &size, sizeof size);
    if (_IOC_NR(request) == 0x02) std::ranges::copy(model_.descriptor, bytes.begin() + sizeof size);
    result = 0;
  } else if (_IOC_NR(request) == 0x06) {  // set a feature
    const std::lock_guard lock(mutex_);
    features_.emplace_back(bytes.begin(), bytes.end());
  } else if (_IOC_NR(request) == 0x07) {  // get a feature
    const std::vector<std::uint8_t> answer =
        model_.feature ? model_.feature(bytes[0]) : std::vector<std::uint8_t>{};
    result = answer.empty() ? -1 : static_cast<long>(std::min(answer.size(), bytes.size()));
    if (result > 0) std::copy_n(answer.begin(), result, bytes.begin());
  } else {
    result = -1;
  }
  umockdev_ioctl_client_complete(client, result, result < 0 ? EPIPE : 0);
  g_object_unref(data);
  return true;
}

std::vector<std::vector<std::uint8_t>> MockBus::features() {
  const std::lock_guard lock(mutex_);
  return std::exchange(features_, {});
}

void MockBus::unplug() {
  if (probe_ >= 0) close(probe_);
  probe_ = device_ = -1;
  for (auto path = paths_.rbegin(); path != paths_.rend(); ++path)
    umockdev_testbed_remove_device(testbed_, ("/sys" + *path).c_str());
  unlink((root_ + node_).c_str());  // umockdev leaves the node, a kernel does not
  paths_.clear();
}

bool MockBus::deliver(std::span<const std::uint8_t> report) {
  if (write(device_, report.data(), report.size()) != static_cast<ssize_t>(report.size())) return false;
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  // The kernel carries bytes across a terminal in the background: empty once may mean not there yet.
  for (int empty = 0, unread = 0; empty < 3; empty = unread == 0 ? empty + 1 : 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    // Not ioctl(), which umockdev would answer from its recording.
    if (syscall(SYS_ioctl, probe_, FIONREAD, &unread) != 0) return false;
    if (std::chrono::steady_clock::now() > deadline) return false;
  }
  return true;
}

std::vector<std::uint8_t> MockBus::written(std::size_t count) {
  std::vector<std::uint8_t> bytes;
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (bytes.size() < count && std::chrono::steady_clock::now() < deadline) {
    pollfd ready{device_, POLLIN, 0};
    if (poll(&ready, 1, 50) <= 0) continue;
    std::uint8_t buffer[64];
    const ssize_t got = read(device_, buffer, sizeof buffer);
    if (got <= 0) break;
    bytes.insert(bytes.end(), buffer, buffer + got);
  }
  return bytes;
}

bool MockBus::setMode(unsigned mode) { return chmod(realNode().c_str(), mode) == 0; }

WithoutRootOverride::WithoutRootOverride() {
  __user_cap_data_struct data[2] = {};
  capabilities(SYS_capget, data);
  for (int i = 0; i < 2; ++i) effective_[i] = data[i].effective;
  data[0].effective &= ~(1u << CAP_DAC_OVERRIDE | 1u << CAP_DAC_READ_SEARCH);
  capabilities(SYS_capset, data);
}

WithoutRootOverride::~WithoutRootOverride() {
  __user_cap_data_struct data[2] = {};
  capabilities(SYS_capget, data);
  for (int i = 0; i < 2; ++i) data[i].effective = effective_[i];
  capabilities(SYS_capset, data);
}

}  // namespace tandem::haptics::testing
