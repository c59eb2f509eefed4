#include "client/base/felt_sections.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace tandem::client {
namespace {

TEST(FeltSections, AreTheDocumentsPlanesWithUnitNormals) {
  const std::vector<document::SectionPlane> planes{{{0.0, 0.0, 0.1}, {0.0, 0.0, -4.0}}};
  const haptics::Sections felt = feltSections(planes);
  ASSERT_EQ(felt.size(), 1u);
  EXPECT_EQ(felt[0], (haptics::Section{{0.0, 0.0, -1.0}, -0.1}));
}

TEST(FeltSections, LeaveOutWhatIsNoPlaneAndWhatIsTooMany) {
  const double infinite = std::numeric_limits<double>::infinity();
  std::vector<document::SectionPlane> planes{{{0.0, 0.0, 0.1}, {0.0, 0.0, 0.0}},
                                             {{infinite, 0.0, 0.1}, {1.0, 0.0, 0.0}},
                                             {{0.0, 0.0, 0.1}, {infinite, 0.0, 0.0}}};
  EXPECT_TRUE(feltSections(planes).empty());
  planes.resize(20, {{0.0, 0.0, 0.1}, {1.0, 0.0, 0.0}});
  EXPECT_EQ(feltSections(planes).size(), haptics::kMaxSections);
}

}  // namespace
}  // namespace tandem::client
