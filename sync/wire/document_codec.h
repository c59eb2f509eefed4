#pragma once

// Entries of the session's document as bytes, in messages and in the journal. Fields stand in the order of
// assets/document/describe.h, little-endian.
//
// 1. Bytes are hostile until decoding returns ok; what is decoded then keeps the limits of its kind.
// 2. One document has one encoding: what decodes encodes to the same bytes.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "assets/base/result.h"
#include "assets/document/entry.h"

namespace tandem::sync {

/// Bytes of an entry without its author's name and its body.
inline constexpr std::size_t kEntryHead = 8 + 8 + 2 + 4 + 2 + 8 + 2 + 4 + 8;
inline constexpr std::size_t kMinEntryBytes = kEntryHead + 1;

/// Strings must keep their limits: the encoding cuts nothing.
std::vector<std::uint8_t> encodeBody(const document::Body& body);
Result<document::Body> decodeBody(std::span<const std::uint8_t> bytes);

std::vector<std::uint8_t> encodeEntry(const document::Entry& entry);
Result<document::Entry> decodeEntry(std::span<const std::uint8_t> bytes);

}  // namespace tandem::sync
