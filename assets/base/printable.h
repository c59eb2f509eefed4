#pragma once

// Whether text may be shown to a person as it is: valid UTF-8 in its shortest form, without control
// characters. Text of a peer or of a file is checked by this before it is used.

#include <cstddef>
#include <string>

namespace tandem {

/// Length of the UTF-8 sequence at text[i] if it may be shown, else 0.
std::size_t printableSequence(const std::string& text, std::size_t i);
bool isPrintable(const std::string& text);
/// The text cut to `limit` bytes between two characters; each byte that may not be shown becomes '?'.
std::string printable(const std::string& text, std::size_t limit);

}  // namespace tandem
