#include "assets/scene/near_names.h"

#include <gtest/gtest.h>

namespace tandem::assets {
namespace {

TEST(NearNames, BeginWithTheOneThatContainsWhatWasWanted) {
  EXPECT_EQ(nearNames("shft", {"cover", "Shaft"}), "; near it are 'Shaft', 'cover'");
  EXPECT_EQ(nearNames("pin", {"pan", "hinge pin"}), "; near it are 'hinge pin', 'pan'");
  EXPECT_EQ(nearNames("pin", {}), "");
}

TEST(NearNames, MeanOneOnlyIfItIsASlipAway) {
  EXPECT_EQ(meantName("chekc", {"join", "check"}), "check");
  EXPECT_EQ(meantName("engine.glb", {"join", "check"}), "");
  EXPECT_EQ(meantName("x", {"ab"}), "");
}

}  // namespace
}  // namespace tandem::assets
