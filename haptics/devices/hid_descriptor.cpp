#include "haptics/devices/hid_descriptor.h"

#include <algorithm>

#include "assets/base/assert.h"

namespace tandem::haptics {
namespace {

constexpr std::size_t kMaxFields = 4096, kMaxUsages = 1024, kMaxDepth = 16;
constexpr std::uint32_t kMaxBits = 8 * 4096;  // of one report: the kernel's limit

/// The global items, in force until changed, saved by Push.
struct Globals {
  std::uint32_t page = 0;
  std::int64_t low = 0, high = 0;
  std::uint32_t size = 0, count = 0;
  std::uint8_t report = 0;
};

/// The local items, in force for one main item.
struct Locals {
  std::vector<HidUsage> usages;
  HidUsage first = 0;
  bool ranged = false;
};

class Parser {
 public:
  Status item(unsigned type, unsigned tag, std::uint32_t value, unsigned bytes) {
    if (type == 0) return main(tag, value);
    if (type == 1) return global(tag, value, bytes);
    if (type == 2) return local(tag, value, bytes);
    return Error{"HID descriptor: an item of an unknown type"};
  }
  Result<HidLayout> finish() {
    if (!inside_.empty()) return Error{"HID descriptor: a collection is not closed"};
    return std::move(layout_);
  }

 private:
  static std::int64_t extended(std::uint32_t value, unsigned bytes) {
    if (bytes == 1) return static_cast<std::int8_t>(value);
    if (bytes == 2) return static_cast<std::int16_t>(value);
    return static_cast<std::int32_t>(value);
  }

  Status main(unsigned tag, std::uint32_t value) {
    Status done;
    if (tag == 8 || tag == 9 || tag == 11) {
      const HidKind kind = tag == 8 ? HidKind::kInput : tag == 9 ? HidKind::kOutput : HidKind::kFeature;
      done = fields(kind, value);
    } else if (tag == 10) {
      if (inside_.size() == kMaxDepth) return Error{"HID descriptor: collections are nested too deep"};
      inside_.push_back(locals_.usages.empty() ? 0 : locals_.usages.front());
    } else if (tag == 12) {
      if (inside_.empty()) return Error{"HID descriptor: a collection is closed that was not opened"};
      inside_.pop_back();
    }
    locals_ = {};
    return done;
  }

  Status fields(HidKind kind, std::uint32_t flags) {
    std::uint32_t& at = layout_.bits[{kind, now_.report}];
    const std::uint64_t total = std::uint64_t{now_.size} * now_.count;
    if (at + total > kMaxBits) return Error{"HID descriptor: a report is too long"};
    const bool constant = (flags & 1) != 0, variable = (flags & 2) != 0;
    if (!constant && !locals_.usages.empty() && total > 0) {
      if (now_.size > 32) return Error{"HID descriptor: a field is wider than 32 bits"};
      for (std::uint32_t i = 0; i < now_.count; ++i) {
        if (layout_.fields.size() == kMaxFields) return Error{"HID descriptor: too many fields"};
        HidField field{kind, now_.report, at + i * now_.size, now_.size, now_.low, now_.high, !variable,
                       {},   inside_};
        if (variable)
          field.usages = {locals_.usages[std::min<std::size_t>(i, locals_.usages.size() - 1)]};
        else
          field.usages = locals_.usages;
        ASSERT(!field.usages.empty() && field.bits <= 32);
        layout_.fields.push_back(std::move(field));
      }
    }
    at += static_cast<std::uint32_t>(total);
    return {};
  }

  Status global(unsigned tag, std::uint32_t value, unsigned bytes) {
    switch (tag) {
      case 0:
        now_.page = value & 0xFFFF;
        break;
      case 1:
        now_.low = extended(value, bytes);
        break;
      // A maximum of 255 in one byte would read as -1: it is unsigned where the minimum is not negative.
      case 2:
        now_.high = now_.low >= 0 ? std::int64_t{value} : extended(value, bytes);
        break;
      case 7:
        now_.size = value;
        break;
      case 8:
        if (value == 0 || value > 255) return Error{"HID descriptor: a report id out of range"};
        now_.report = static_cast<std::uint8_t>(value);
        layout_.numbered = true;
        break;
      case 9:
        now_.count = value;
        break;
      case 10:
        if (saved_.size() == kMaxDepth) return Error{"HID descriptor: too many pushes"};
        saved_.push_back(now_);
        break;
      case 11:
        if (saved_.empty()) return Error{"HID descriptor: a pop without a push"};
        now_ = saved_.back();
        saved_.pop_back();
        break;
      default:
        break;  // physical range and units: of no use where firmware leaves them out
    }
    return {};
  }

  Status local(unsigned tag, std::uint32_t value, unsigned bytes) {
    const HidUsage usage = bytes == 4 ? value : hidUsage(now_.page, value);
    if (tag == 0) {
      if (locals_.usages.size() == kMaxUsages) return Error{"HID descriptor: too many usages"};
      locals_.usages.push_back(usage);
    } else if (tag == 1) {
      locals_.first = usage;
      locals_.ranged = true;
    } else if (tag == 2 && locals_.ranged) {
      locals_.ranged = false;
      if (usage < locals_.first || usage - locals_.first >= kMaxUsages - locals_.usages.size())
        return Error{"HID descriptor: a range of usages that is empty or too long"};
      for (HidUsage next = locals_.first; next <= usage; ++next) {
        locals_.usages.push_back(next);
        if (next == 0xFFFFFFFF) break;
      }
    }
    return {};
  }

  Globals now_;
  Locals locals_;
  std::vector<Globals> saved_;
  std::vector<HidUsage> inside_;
  HidLayout layout_;
};

}  // namespace

bool HidField::isInside(HidUsage collection) const {
  return std::ranges::find(inside, collection) != inside.end();
}

std::int64_t HidField::choice(HidUsage usage) const {
  const auto found = std::ranges::find(usages, usage);
  return found == usages.end() ? -1 : low + (found - usages.begin());
}

std::size_t HidLayout::reportBytes(HidKind kind, std::uint8_t report) const {
  const auto found = bits.find({kind, report});
  return found == bits.end() ? 1 : 1 + (found->second + 7) / 8;
}

Result<HidLayout> parseHidDescriptor(std::span<const std::uint8_t> bytes) {
  Parser parser;
  while (!bytes.empty()) {
    const std::uint8_t prefix = bytes[0];
    if (prefix == 0xFE) {  // a long item: none is defined, so it is stepped over
      if (bytes.size() < 3 || bytes.size() < 3u + bytes[1]) return Error{"HID descriptor: cut off"};
      bytes = bytes.subspan(3u + bytes[1]);
      continue;
    }
    const unsigned size = (prefix & 3) == 3 ? 4 : prefix & 3;
    if (bytes.size() < 1 + size) return Error{"HID descriptor: cut off"};
    std::uint32_t value = 0;
    for (unsigned i = 0; i < size; ++i) value |= std::uint32_t{bytes[1 + i]} << (8 * i);
    if (Status done = parser.item(prefix >> 2 & 3, prefix >> 4, value, size); !done) return done.error();
    bytes = bytes.subspan(1 + size);
  }
  return parser.finish();
}

std::int64_t readHidField(const HidField& field, std::span<const std::uint8_t> data) {
  if (std::uint64_t{field.bit} + field.bits > 8 * data.size() || field.bits == 0) return 0;
  ASSERT(field.bits <= 32);
  std::uint64_t value = 0;
  for (std::uint32_t i = 0; i < field.bits; ++i) {
    const std::uint32_t at = field.bit + i;
    value |= std::uint64_t{data[at / 8] >> (at % 8) & 1u} << i;
  }
  if (field.low < 0 && (value >> (field.bits - 1) & 1) != 0) value |= ~std::uint64_t{0} << field.bits;
  return static_cast<std::int64_t>(value);
}

void writeHidField(const HidField& field, std::span<std::uint8_t> data, std::int64_t value) {
  if (std::uint64_t{field.bit} + field.bits > 8 * data.size()) return;
  ASSERT(field.bits <= 32);
  if (field.low <= field.high) value = std::clamp(value, field.low, field.high);
  for (std::uint32_t i = 0; i < field.bits; ++i) {
    const std::uint32_t at = field.bit + i;
    const auto mask = static_cast<std::uint8_t>(1u << (at % 8));
    if ((value >> i & 1) != 0)
      data[at / 8] |= mask;
    else
      data[at / 8] &= static_cast<std::uint8_t>(~mask);
  }
}

}  // namespace tandem::haptics
