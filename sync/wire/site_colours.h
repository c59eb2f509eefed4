#pragma once

// Colours that distinguish people. The server assigns them, so that no two people have the same one while
// there are enough.

#include <array>
#include <cstddef>
#include <cstdint>

namespace tandem::sync {

using SiteColour = std::array<std::uint8_t, 3>;  // sRGB

/// The colour of a Hello that leaves the choice to the server. A site that wants black sends {1, 1, 1}.
inline constexpr SiteColour kAnyColour{0, 0, 0};

/// Distinguishable with every common colour blindness (Okabe & Ito 2008). Their black is left out, because
/// edges are black; olive (Tol 2021) replaces their yellow, on which white letters cannot be read.
inline constexpr std::array<SiteColour, 7> kSiteColours{{{0, 114, 178},
                                                         {230, 159, 0},
                                                         {0, 158, 115},
                                                         {204, 121, 167},
                                                         {86, 180, 233},
                                                         {213, 94, 0},
                                                         {153, 153, 51}}};

/// The n-th person's colour where no server assigns them.
inline constexpr SiteColour siteColour(std::size_t n) { return kSiteColours[n % kSiteColours.size()]; }

}  // namespace tandem::sync
