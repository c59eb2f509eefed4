#include "server/control_budget.h"

#include <algorithm>

#include "assets/base/assert.h"

namespace tandem::server {
namespace {

constexpr double kResumeAt = 0.5 * ControlBudget::kRate;
constexpr double kMaxDebt = 2.0 * ControlBudget::kBurst;  // one large message cannot silence a site for long
constexpr sync::Micros kNoticePeriod = 10 * sync::kSecond;

}  // namespace

void ControlBudget::advance(sync::Micros now) {
  ASSERT(now >= at_);
  const sync::Micros elapsed = now - at_;
  at_ = now;
  allowance_ = std::min(kBurst, allowance_ + sync::toSeconds(elapsed) * kRate);
  excess_ = held_ ? excess_ + elapsed : std::max<sync::Micros>(0, excess_ - elapsed / 2);
}

bool ControlBudget::spend(sync::Micros now, double messages) {
  advance(now);
  allowance_ = std::max(-kMaxDebt, allowance_ - messages);
  held_ = allowance_ < 1.0;
  return !held_;
}

bool ControlBudget::mayResume(sync::Micros now) {
  advance(now);
  if (allowance_ >= kResumeAt) held_ = false;
  return !held_;
}

bool ControlBudget::exhausted(sync::Micros now) {
  advance(now);
  return allowance_ < 1.0;
}

bool ControlBudget::abused(sync::Micros now) {
  advance(now);
  return excess_ >= kPatience;
}

bool ControlBudget::drainNotice(sync::Micros now) {
  if (everNoticed_ && now - noticed_ < kNoticePeriod) return false;
  everNoticed_ = true;
  noticed_ = now;
  return true;
}

}  // namespace tandem::server
