#pragma once

// Parser of HID report descriptors: which bits of which report mean what. Pure; safe for any bytes.
//
// Source: USB Device Class Definition for Human Interface Devices 1.11, sections 5 and 6.2.2.

#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "assets/base/result.h"

namespace tandem::haptics {

enum class HidKind : std::uint8_t { kInput, kOutput, kFeature };

/// A usage with its page: 0x000F0070 is usage 70 of page 0F.
using HidUsage = std::uint32_t;
constexpr HidUsage hidUsage(std::uint32_t page, std::uint32_t id) { return page << 16 | (id & 0xFFFF); }

/// One value in a report.
struct HidField {
  HidKind kind = HidKind::kInput;
  std::uint8_t report = 0;         // its id; 0: the device does not number its reports
  std::uint32_t bit = 0;           // of the first one, after the id byte
  std::uint32_t bits = 0;          // 1..32
  std::int64_t low = 0, high = 0;  // logical range
  bool array = false;              // the value chooses one of `usages`: low + index
  std::vector<HidUsage> usages;    // one for a variable; all choices of an array
  std::vector<HidUsage> inside;    // the collections it is in, outermost first

  bool isInside(HidUsage collection) const;
  /// The value that chooses a usage of an array, or -1.
  std::int64_t choice(HidUsage usage) const;
};

struct HidLayout {
  std::vector<HidField> fields;
  bool numbered = false;                                           // reports begin with an id byte
  std::map<std::pair<HidKind, std::uint8_t>, std::uint32_t> bits;  // of each report, padding included

  /// Length in bytes of a report as hidapi exchanges it for writing: the id byte first, 0 if reports have
  /// none.
  std::size_t reportBytes(HidKind kind, std::uint8_t report) const;
};

/// Parses a descriptor. Refused with a reason: truncated items, unbalanced collections or pushes, more than
/// 4096 fields, fields over 32 bits that carry a usage. Padding is skipped but counted in the offsets.
Result<HidLayout> parseHidDescriptor(std::span<const std::uint8_t> bytes);

/// The value of a field in a report's data (after the id byte), sign-extended when its range has negative
/// numbers. 0 where the data are too short.
std::int64_t readHidField(const HidField& field, std::span<const std::uint8_t> data);

/// Writes a value, clamped to the logical range, into a report's data. Nothing where the data are too short.
void writeHidField(const HidField& field, std::span<std::uint8_t> data, std::int64_t value);

}  // namespace tandem::haptics
