#pragma once

// The udev rule that lets the person at the seat open the supported devices, embedded so that a program
// installed without the rule can still print it.

#include <string_view>

namespace tandem::haptics {

/// Path of a rule installed by hand.
inline constexpr std::string_view kUdevRulePath = "/etc/udev/rules.d/70-tandem-hid.rules";

/// Text of 70-tandem-hid.rules at build time.
std::string_view udevRule();

}  // namespace tandem::haptics
