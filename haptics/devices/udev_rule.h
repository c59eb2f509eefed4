#pragma once

// The udev rule that lets the person at the seat open the devices that a driver knows, so that a program that
// was installed without it can still hand it out.

#include <string_view>

namespace tandem::haptics {

/// Where a rule put in by hand belongs.
inline constexpr std::string_view kUdevRulePath = "/etc/udev/rules.d/70-tandem-hid.rules";

/// The text of 70-tandem-hid.rules, as it was when this was built.
std::string_view udevRule();

}  // namespace tandem::haptics
