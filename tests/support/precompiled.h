#pragma once

// What every test includes, compiled once for all of them. No test relies on it: each includes what it uses.

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "assets/base/precompiled.h"
