#include "haptics/devices/pid_codec.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "assets/base/assert.h"

namespace tandem::haptics {
namespace {

constexpr HidUsage pid(std::uint32_t id) { return hidUsage(0x0F, id); }
constexpr HidUsage kX = hidUsage(1, 0x30), kY = hidUsage(1, 0x31), kSteering = hidUsage(2, 0xC8);
constexpr HidUsage kBlock = pid(0x22), kDirection = pid(0x57);
constexpr std::uint32_t kButtonPage = 9;

double shareOf(const HidField& field, std::int64_t value) {
  if (field.high <= field.low) return 0.0;
  const double span = static_cast<double>(field.high) - static_cast<double>(field.low);
  return std::clamp(2.0 * (static_cast<double>(value) - static_cast<double>(field.low)) / span - 1.0, -1.0,
                    1.0);
}

/// -1..1 onto a range about zero (or, where it has no negative numbers, onto its positive side).
std::int64_t signedValue(const HidField& field, double share) {
  if (!std::isfinite(share)) return 0;
  share = std::clamp(share, -1.0, 1.0);
  const double end = share < 0.0 ? -static_cast<double>(field.low) : static_cast<double>(field.high);
  return std::llround(share * end);
}

/// Reports of one kind that lie in a collection (or, with the usage itself as a field, hold it).
PidReport reportIn(const HidLayout& hid, HidKind kind, HidUsage collection) {
  PidReport report;
  for (const HidField& field : hid.fields) {
    const bool here = field.isInside(collection) || (field.array && field.choice(collection) >= 0) ||
                      (!field.array && field.usages.front() == collection);
    if (field.kind != kind || !here) continue;
    if (report.present() && field.report != report.id) continue;
    report.kind = kind;
    report.id = field.report;
    report.bytes = hid.reportBytes(kind, field.report);
    report.fields.push_back(field);
  }
  return report;
}

/// A report that firmware may send as an output or as a feature.
PidReport outOrFeature(const HidLayout& hid, HidUsage collection) {
  PidReport report = reportIn(hid, HidKind::kOutput, collection);
  return report.present() ? report : reportIn(hid, HidKind::kFeature, collection);
}

PidBytes blank(const PidReport& report) {
  PidBytes bytes(report.bytes, 0);
  if (!bytes.empty()) bytes[0] = report.id;
  return bytes;
}

std::span<std::uint8_t> dataOf(PidBytes& bytes) { return std::span(bytes).subspan(bytes.empty() ? 0 : 1); }

void put(const PidReport& report, PidBytes& bytes, HidUsage usage, std::int64_t value) {
  if (const HidField* field = report.find(usage)) writeHidField(*field, dataOf(bytes), value);
}

/// Chooses a usage of an array field, or sets the bit that stands for it.
bool choose(const PidReport& report, PidBytes& bytes, HidUsage usage) {
  const HidField* field = report.find(usage);
  if (field == nullptr) return false;
  writeHidField(*field, dataOf(bytes), field->array ? field->choice(usage) : 1);
  return true;
}

void findInputs(PidLayout& layout) {
  const HidField* steering = nullptr;
  for (const HidUsage wanted : {kX, kY})
    for (const HidField& field : layout.hid.fields)
      if (field.kind == HidKind::kInput && !field.array && field.usages.front() == wanted) {
        layout.axes.push_back(field);
        break;
      }
  for (const HidField& field : layout.hid.fields) {
    if (field.kind != HidKind::kInput || field.array) continue;
    if (field.usages.front() == kSteering && steering == nullptr) steering = &field;
    if (field.usages.front() >> 16 == kButtonPage && layout.buttons.size() < 32)
      layout.buttons.push_back(field);
  }
  if (layout.axes.empty() && steering != nullptr) layout.axes.push_back(*steering);
  ASSERT(layout.axes.size() <= 2 && layout.buttons.size() <= 32);
}

const char* missing(const PidLayout& layout) {
  if (layout.axes.empty()) return "it has no X or Y axis";
  if (!layout.create.present() || !layout.load.present()) return "effects cannot be created";
  if (layout.load.find(kBlock) == nullptr) return "it does not name the effects that it creates";
  if (!layout.set.present() || layout.set.find(kBlock) == nullptr) return "it has no Set Effect report";
  if (!layout.constant.present() || layout.constant.find(pid(0x70)) == nullptr)
    return "it has no constant force";
  if (layout.operation.find(pid(0x79)) == nullptr) return "effects cannot be started";
  return nullptr;
}

}  // namespace

const HidField* PidReport::find(HidUsage usage) const {
  for (const HidField& field : fields)
    if (std::ranges::find(field.usages, usage) != field.usages.end()) return &field;
  return nullptr;
}

int PidLayout::forceAxes() const { return static_cast<int>(axes.size()); }

Result<PidLayout> findPid(std::span<const std::uint8_t> descriptor) {
  Result<HidLayout> hid = parseHidDescriptor(descriptor);
  if (!hid) return hid.error();
  PidLayout layout;
  layout.hid = std::move(*hid);
  findInputs(layout);
  layout.control = reportIn(layout.hid, HidKind::kOutput, pid(0x96));
  if (!layout.control.present()) layout.control = reportIn(layout.hid, HidKind::kOutput, pid(0x95));
  layout.gain = outOrFeature(layout.hid, pid(0x7D));
  layout.pool = reportIn(layout.hid, HidKind::kFeature, pid(0x7F));
  layout.create = reportIn(layout.hid, HidKind::kFeature, pid(0xAB));
  layout.load = reportIn(layout.hid, HidKind::kFeature, pid(0x89));
  layout.free = reportIn(layout.hid, HidKind::kOutput, pid(0x90));
  layout.set = reportIn(layout.hid, HidKind::kOutput, pid(0x21));
  layout.constant = reportIn(layout.hid, HidKind::kOutput, pid(0x73));
  layout.condition = reportIn(layout.hid, HidKind::kOutput, pid(0x5F));
  layout.operation = reportIn(layout.hid, HidKind::kOutput, pid(0x77));
  if (const char* what = missing(layout))
    return Error{std::string("not a PID force-feedback device: ") + what};
  return layout;
}

bool decodePidInput(const PidLayout& layout, std::span<const std::uint8_t> report, PidState& state) {
  ASSERT(layout.buttons.size() <= 32);  // a bit each in state.buttons
  std::uint8_t id = 0;
  if (layout.hid.numbered) {
    if (report.empty()) return false;
    id = report[0];
    report = report.subspan(1);
  }
  bool used = false;
  const auto fits = [&](const HidField& field) {
    return field.report == id && std::uint64_t{field.bit} + field.bits <= 8 * report.size();
  };
  for (std::size_t i = 0; i < layout.axes.size() && i < state.axes.size(); ++i)
    if (fits(layout.axes[i])) {
      state.axes[i] = shareOf(layout.axes[i], readHidField(layout.axes[i], report));
      used = true;
    }
  for (std::size_t i = 0; i < layout.buttons.size(); ++i)
    if (fits(layout.buttons[i])) {
      const std::uint32_t bit = 1u << i;
      state.buttons =
          readHidField(layout.buttons[i], report) != 0 ? state.buttons | bit : state.buttons & ~bit;
      used = true;
    }
  return used;
}

PidBytes encodeControl(const PidLayout& layout, PidControl what) {
  PidBytes bytes = blank(layout.control);
  return choose(layout.control, bytes, pid(static_cast<std::uint16_t>(what))) ? bytes : PidBytes{};
}

PidBytes encodeGain(const PidLayout& layout, double share) {
  PidBytes bytes = blank(layout.gain);
  const HidField* field = layout.gain.find(pid(0x7E));
  if (field == nullptr) return {};
  writeHidField(*field, dataOf(bytes), signedValue(*field, std::max(share, 0.0)));
  return bytes;
}

PidBytes encodeCreate(const PidLayout& layout, PidEffect type) {
  PidBytes bytes = blank(layout.create);
  return choose(layout.create, bytes, pid(static_cast<std::uint16_t>(type))) ? bytes : PidBytes{};
}

PidBlock decodeBlockLoad(const PidLayout& layout, std::span<const std::uint8_t> report) {
  PidBlock block;
  if (report.empty() || report[0] != layout.load.id) return block;
  const auto data = report.subspan(1);
  const HidField* index = layout.load.find(kBlock);
  const HidField* status = layout.load.find(pid(0x8C));
  if (index == nullptr || std::uint64_t{index->bit} + index->bits > 8 * data.size()) return block;
  const std::int64_t number = readHidField(*index, data);
  if (number < 0 || number > 255) return block;
  block.index = static_cast<std::uint8_t>(number);
  if (status == nullptr) return block;
  const std::int64_t value = readHidField(*status, data);
  const auto is = [&](std::uint32_t usage) {
    const HidField* field = layout.load.find(pid(usage));
    if (field == nullptr) return false;
    return field->array ? value == field->choice(pid(usage)) : readHidField(*field, data) == 1;
  };
  block.status = is(0x8C)   ? PidBlock::kLoaded
                 : is(0x8D) ? PidBlock::kFull
                 : is(0x8E) ? PidBlock::kError
                            : PidBlock::kUnknown;
  return block;
}

PidBytes encodeSetEffect(const PidLayout& layout, std::uint8_t blockIndex, PidEffect type, int axis) {
  ASSERT(axis == 0 || axis == 1);
  PidBytes bytes = blank(layout.set);
  put(layout.set, bytes, kBlock, blockIndex);
  choose(layout.set, bytes, pid(static_cast<std::uint16_t>(type)));
  // The largest duration is the one without end. No trigger button: 0, which is outside its range.
  for (const std::uint32_t usage : {0x50u, 0x52u})
    if (const HidField* field = layout.set.find(pid(usage)))
      writeHidField(*field, dataOf(bytes), field->high);
  const HidUsage axisUsage = axis == 0 ? kX : kY;
  const HidField* bit = nullptr;
  for (const HidField& field : layout.set.fields)
    if (field.isInside(pid(0x55)) && !field.array && field.usages.front() == axisUsage) bit = &field;
  if (bit != nullptr) {
    writeHidField(*bit, dataOf(bytes), 1);
    return bytes;
  }
  // An effect without axes of its own has a direction: 0 is away from the user, a quarter turn is to the
  // right.
  put(layout.set, bytes, pid(0x56), 1);
  for (const HidField& field : layout.set.fields)
    if (field.isInside(kDirection) || field.usages.front() == kDirection) {
      writeHidField(field, dataOf(bytes), axis == 0 ? field.high / 4 : 0);
      break;
    }
  return bytes;
}

PidBytes encodeConstant(const PidLayout& layout, std::uint8_t blockIndex, double share) {
  PidBytes bytes = blank(layout.constant);
  put(layout.constant, bytes, kBlock, blockIndex);
  if (const HidField* magnitude = layout.constant.find(pid(0x70)))
    writeHidField(*magnitude, dataOf(bytes), signedValue(*magnitude, share));
  return bytes;
}

PidBytes encodeCondition(const PidLayout& layout, std::uint8_t blockIndex, int axis,
                         const PidCondition& condition) {
  ASSERT(axis == 0 || axis == 1);
  const PidReport& report = layout.condition;
  PidBytes bytes = blank(report);
  if (bytes.empty()) return bytes;
  put(report, bytes, kBlock, blockIndex);
  put(report, bytes, pid(0x23), axis);
  const auto share = [&](std::uint32_t usage, double value) {
    if (const HidField* field = report.find(pid(usage)))
      writeHidField(*field, dataOf(bytes), signedValue(*field, value));
  };
  share(0x60, condition.centre);
  share(0x61, condition.coefficient), share(0x62, condition.coefficient);
  share(0x63, condition.saturation), share(0x64, condition.saturation);
  share(0x65, condition.deadBand);
  return bytes;
}

PidBytes encodeOperation(const PidLayout& layout, std::uint8_t blockIndex, PidOperation what) {
  PidBytes bytes = blank(layout.operation);
  put(layout.operation, bytes, kBlock, blockIndex);
  choose(layout.operation, bytes, pid(static_cast<std::uint16_t>(what)));
  if (const HidField* loops = layout.operation.find(pid(0x7C)))
    writeHidField(*loops, dataOf(bytes), what == PidOperation::kStart ? 1 : 0);
  return bytes;
}

PidBytes encodeFree(const PidLayout& layout, std::uint8_t blockIndex) {
  PidBytes bytes = blank(layout.free);
  put(layout.free, bytes, kBlock, blockIndex);
  return bytes;
}

}  // namespace tandem::haptics
