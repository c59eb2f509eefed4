#pragma once

// Numbers with their units as the page writes them.

#include <cstdio>
#include <string>

namespace tandem::client::report {

inline std::string number(double value, int digits = 3) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}

/// A force with the prefix that fits it.
inline std::string newtons(double value) {
  if (value >= 1.0) return number(value) + " N";
  if (value >= 1e-3) return number(1e3 * value) + " mN";
  if (value >= 1e-6) return number(1e6 * value) + " µN";
  return value >= 1e-11 ? number(1e9 * value, 3) + " nN" : "0";
}

inline std::string percent(double share) {
  if (share < 1e-11) return "0";
  if (share >= 1e-5) return number(100.0 * share) + " %";
  return number(1e6 * share, 2) + " ppm";
}

/// A time of so many microseconds.
inline std::string microseconds(double us) {
  return us < 1000.0 ? number(us) + " µs" : number(1e-3 * us) + " ms";
}

/// A length with the prefix that fits it.
inline std::string metres(double value) {
  if (value >= 1e-3) return number(1e3 * value) + " mm";
  if (value >= 1e-6) return number(1e6 * value) + " µm";
  return value >= 1e-12 ? number(1e9 * value) + " nm" : "0";
}

}  // namespace tandem::client::report
