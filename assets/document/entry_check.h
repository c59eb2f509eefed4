#pragma once

// Whether a body keeps within the limits of its kind, whatever it came from.

#include <cstddef>

#include "assets/base/result.h"
#include "assets/document/entry.h"

namespace tandem::document {

/// The error names the field and what is wrong with it.
Status check(const Body& body);
/// Bytes that the body takes on the wire, within a few; the document's size is the sum of these.
std::size_t sizeOf(const Body& body);
/// The entry that a body refers to, which must be there as long as it is; 0 if there is none.
EntryId reference(const Body& body);

/// No body that passes check() is larger.
inline constexpr std::size_t kMaxBodyBytes = 15 * 1024;

}  // namespace tandem::document
