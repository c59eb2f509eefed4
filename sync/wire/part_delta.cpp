#include "sync/wire/part_delta.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "assets/base/assert.h"

namespace tandem::sync {
namespace {

constexpr int kOrderBits = 4;
constexpr int kHighestOrder = (1 << kOrderBits) - 1;
constexpr int kLongestPrefix = 32;

/// How a state is predicted from its baseline.
enum class Rule : std::uint8_t { steady, changing };

// ---- three small numbers: Exp-Golomb codes (Teuhola 1978) of an order that is sent with them ----

std::uint64_t folded(std::int64_t x) {
  return x >= 0 ? 2 * static_cast<std::uint64_t>(x) : 2 * static_cast<std::uint64_t>(-x) - 1;
}
std::int64_t unfolded(std::uint64_t u) {
  return u % 2 == 0 ? static_cast<std::int64_t>(u / 2) : -static_cast<std::int64_t>(u / 2) - 1;
}

int golombBits(std::uint64_t u, int order) {
  return 2 * static_cast<int>(std::bit_width((u >> order) + 1)) - 1 + order;
}
void putGolomb(BitWriter& writer, std::uint64_t u, int order) {
  const std::uint64_t group = (u >> order) + 1;
  const int low = static_cast<int>(std::bit_width(group)) - 1;
  writer.put((std::uint64_t{1} << low) - 1, low + 1);  // as many ones as bits follow, and a zero
  writer.put(group, low);                              // its highest bit is known
  writer.put(u, order);
}
std::uint64_t getGolomb(BitReader& reader, int order) {
  int low = 0;
  while (reader.get(1) == 1) {
    if (++low > kLongestPrefix) reader.fail();
  }
  const std::uint64_t group = (std::uint64_t{1} << low) + reader.get(low);
  return ((group - 1) << order) + reader.get(order);
}

int threeBits(const Code3& code, int order) {
  int bits = 0;
  for (const std::int64_t x : code) bits += golombBits(folded(x), order);
  return bits;
}
/// The order that takes the fewest bits.
int bestOrder(const Code3& code) {
  int best = 0, fewest = threeBits(code, 0);
  for (int order = 1; order <= kHighestOrder; ++order) {
    const int bits = threeBits(code, order);
    if (bits < fewest) best = order, fewest = bits;
  }
  return best;
}
void putThree(BitWriter& writer, const Code3& code, int order) {
  for (const std::int64_t x : code) putGolomb(writer, folded(x), order);
}
Code3 getThree(BitReader& reader, int order) {
  Code3 code;
  for (std::int64_t& x : code) x = unfolded(getGolomb(reader, order));
  return code;
}

// ---- prediction ----

std::int64_t rounded(double value, std::int64_t max) {
  return std::clamp<std::int64_t>(std::llround(value), -max, max);
}
Code3 operator-(const Code3& a, const Code3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Code3 operator+(const Code3& a, const Code3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
bool within(const Code3& code, std::int64_t least, std::int64_t most) {
  return std::all_of(code.begin(), code.end(), [&](std::int64_t x) { return x >= least && x <= most; });
}

/// The velocity after d seconds, extrapolated from that at the baseline and the one h seconds before it.
Code3 predictedSpeed(const Code3& before, const Code3& at, Rule rule, double h, double d) {
  if (rule == Rule::steady) return at;
  Code3 code;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto v = static_cast<double>(at[i]);
    code[i] = rounded(v + (v - static_cast<double>(before[i])) * (d / h), kSpeedMax);
  }
  return code;
}

/// The displacement from 0 to d, in steps of the velocity times seconds: the integral of v(t) = at + b t + c
/// t^2 through the known velocities (the trapezoid rule, where c = 0).
glm::dvec3 displacement(const Code3& before, const Code3& at, const Code3& after, Rule rule, double h,
                        double d) {
  glm::dvec3 sum;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto v0 = static_cast<double>(at[i]);
    const double ahead = (static_cast<double>(after[i]) - v0) / d;
    const double behind = (v0 - static_cast<double>(before[i])) / h;
    const double c = rule == Rule::steady ? 0.0 : (ahead - behind) / (d + h);
    const double b = ahead - c * d;
    sum[static_cast<glm::length_t>(i)] = d * (v0 + d * (b / 2.0 + d * c / 3.0));
  }
  return sum;
}

/// A rotation vector as a quaternion by the series of sine and cosine: exact enough for the angles of a
/// prediction, with the same bits on every machine.
glm::dquat turned(const glm::dvec3& rotation, const glm::dquat& from) {
  const glm::dvec3 v = 0.5 * rotation;
  const double s = v.x * v.x + v.y * v.y + v.z * v.z;
  const double sine = 1.0 - s / 6.0 * (1.0 - s / 20.0), cosine = 1.0 - s / 2.0 * (1.0 - s / 12.0);
  const double w = cosine, x = sine * v.x, y = sine * v.y, z = sine * v.z;
  const glm::dquat q(
      w * from.w - x * from.x - y * from.y - z * from.z, w * from.x + x * from.w + y * from.z - z * from.y,
      w * from.y - x * from.z + y * from.w + z * from.x, w * from.z + x * from.y - y * from.x + z * from.w);
  const double norm = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return glm::dquat(q.w / norm, q.x / norm, q.y / norm, q.z / norm);
}

/// Predicts the state at a time after a baseline, by one of the rules.
class Prediction {
 public:
  Prediction(const PartBaseline& baseline, Micros elapsed, const WireFrame& frame, Rule rule)
      : baseline_(baseline),
        rule_(rule),
        h_(baseline.hasBefore ? toSeconds(baseline.sinceBefore) : 1.0),
        d_(toSeconds(elapsed)),
        stepsPerMetre_((kPositionMax + 1) / frame.halfExtent) {}

  Code3 linear() const { return speed(baseline_.before.linear, baseline_.code.twist.linear); }
  Code3 angular() const { return speed(baseline_.before.angular, baseline_.code.twist.angular); }
  Code3 position(const Code3& linear) const {
    const glm::dvec3 moved =
        displacement(baseline_.before.linear, baseline_.code.twist.linear, linear, rule_, h_, d_) *
        (kMaxLinearSpeed / kSpeedMax * stepsPerMetre_);
    Code3 code;
    for (std::size_t i = 0; i < 3; ++i)
      code[i] = baseline_.code.pose.position[i] + rounded(moved[static_cast<glm::length_t>(i)], kPositionMax);
    return code;
  }
  glm::dquat orientation(const Code3& angular) const {
    Pose pose;
    const bool valid = fromCode(baseline_.code.pose, {}, pose);
    ASSERT(valid);
    const glm::dvec3 turn =
        displacement(baseline_.before.angular, baseline_.code.twist.angular, angular, rule_, h_, d_) *
        (kMaxAngularSpeed / kSpeedMax);
    return turned(turn, pose.orientation);
  }

 private:
  Code3 speed(const Code3& before, const Code3& at) const {
    return predictedSpeed(before, at, rule_, h_, d_);
  }

  const PartBaseline& baseline_;
  Rule rule_;
  double h_, d_;  // s
  double stepsPerMetre_;
};

/// The codes of the other three components, for a quaternion that leaves out this one.
Code3 threeOf(const glm::dquat& q, int leftOut) {
  ASSERT(leftOut >= 0 && leftOut < 4);
  const double w[4] = {q.w, q.x, q.y, q.z};
  const double sign = w[leftOut] < 0.0 ? -1.0 : 1.0;
  Code3 code{};
  std::size_t k = 0;
  for (int i = 0; i < 4; ++i)
    if (i != leftOut) code[k++] = std::llround(sign * w[i] * (kQuaternionMax / kSmallestThreeRange));
  return code;
}

/// What is sent: differences between the state and its prediction.
struct Residual {
  bool still = false;
  Rule rule = Rule::steady;
  bool largestAsPredicted = true;
  int largest = 0;
  std::array<Code3, 4> threes{};  // in the order of DeltaOrders

  /// A part at rest has no velocities.
  std::size_t first() const { return still ? 2 : 0; }
  DeltaOrders bestOrders() const {
    DeltaOrders orders{};
    for (std::size_t i = first(); i < threes.size(); ++i) orders[i] = bestOrder(threes[i]);
    return orders;
  }
  int bitsOfThrees(const DeltaOrders& orders) const {
    int bits = 0;
    for (std::size_t i = first(); i < threes.size(); ++i) bits += threeBits(threes[i], orders[i]);
    return bits;
  }
  int bitsOfOrders() const { return kOrderBits * static_cast<int>(threes.size() - first()); }
  /// Whether the baseline's orders take fewer bits than sending better ones.
  bool inherits(const PartBaseline& baseline) const {
    return baseline.hasBefore && bitsOfThrees(baseline.orders) <= bitsOfThrees(bestOrders()) + bitsOfOrders();
  }
  int bits(const PartBaseline& baseline) const {
    const int numbers =
        inherits(baseline) ? bitsOfThrees(baseline.orders) : bitsOfOrders() + bitsOfThrees(bestOrders());
    return 1 + (baseline.hasBefore ? 2 : 0) + (largestAsPredicted ? 1 : 3) + numbers;
  }
};

Residual residualBy(Rule rule, const PartBaseline& baseline, Micros elapsed, const PartCode& now,
                    const WireFrame& frame) {
  const Prediction prediction(baseline, elapsed, frame, rule);
  Residual residual;
  residual.rule = rule;
  residual.still = now.twist.still();
  if (!residual.still) {
    residual.threes[0] = now.twist.linear - prediction.linear();
    residual.threes[1] = now.twist.angular - prediction.angular();
  }
  residual.threes[2] = now.pose.position - prediction.position(now.twist.linear);
  const glm::dquat q = prediction.orientation(now.twist.angular);
  residual.largest = now.pose.largest;
  residual.largestAsPredicted = now.pose.largest == largestOf(q);
  residual.threes[3] = now.pose.three - threeOf(q, now.pose.largest);
  return residual;
}

Residual bestResidual(const PartBaseline& baseline, Micros elapsed, const PartCode& now,
                      const WireFrame& frame) {
  const Residual steady = residualBy(Rule::steady, baseline, elapsed, now, frame);
  if (!baseline.hasBefore) return steady;
  const Residual changing = residualBy(Rule::changing, baseline, elapsed, now, frame);
  return changing.bits(baseline) < steady.bits(baseline) ? changing : steady;
}

}  // namespace

int deltaBits(const PartBaseline& baseline, Micros elapsed, const PartCode& now, const WireFrame& frame) {
  return bestResidual(baseline, elapsed, now, frame).bits(baseline);
}

DeltaOrders putDelta(BitWriter& writer, const PartBaseline& baseline, Micros elapsed, const PartCode& now,
                     const WireFrame& frame) {
  ASSERT(elapsed > 0 && elapsed <= kLongestElapsed);
  const Residual residual = bestResidual(baseline, elapsed, now, frame);
  const bool inherits = residual.inherits(baseline);
  const DeltaOrders best = residual.bestOrders();
  writer.put(residual.still ? 1 : 0, 1);
  if (baseline.hasBefore) {
    writer.put(residual.rule == Rule::changing ? 1 : 0, 1);
    writer.put(inherits ? 1 : 0, 1);
  }
  writer.put(residual.largestAsPredicted ? 1 : 0, 1);
  if (!residual.largestAsPredicted) writer.put(static_cast<std::uint64_t>(residual.largest), 2);
  for (std::size_t i = residual.first(); i < residual.threes.size(); ++i) {
    if (!inherits) writer.put(static_cast<std::uint64_t>(best[i]), kOrderBits);
    putThree(writer, residual.threes[i], inherits ? baseline.orders[i] : best[i]);
  }
  return best;
}

DeltaOrders getDelta(BitReader& reader, const PartBaseline& baseline, Micros elapsed, const WireFrame& frame,
                     PartCode& now) {
  Residual residual;
  residual.still = reader.get(1) == 1;
  if (baseline.hasBefore && reader.get(1) == 1) residual.rule = Rule::changing;
  const bool inherits = baseline.hasBefore && reader.get(1) == 1;
  residual.largestAsPredicted = reader.get(1) == 1;
  if (!residual.largestAsPredicted) residual.largest = static_cast<int>(reader.get(2));
  for (std::size_t i = residual.first(); i < residual.threes.size(); ++i)
    residual.threes[i] =
        getThree(reader, inherits ? baseline.orders[i] : static_cast<int>(reader.get(kOrderBits)));

  const Prediction prediction(baseline, elapsed, frame, residual.rule);
  now.twist = {};
  if (!residual.still) {
    now.twist.linear = prediction.linear() + residual.threes[0];
    now.twist.angular = prediction.angular() + residual.threes[1];
  }
  // The velocities are checked before they are used, since nothing is predicted from one that is out of
  // range.
  if (!within(now.twist.linear, -kSpeedMax, kSpeedMax) || !within(now.twist.angular, -kSpeedMax, kSpeedMax)) {
    reader.fail();
    return {};
  }
  now.pose.position = prediction.position(now.twist.linear) + residual.threes[2];
  const glm::dquat q = prediction.orientation(now.twist.angular);
  now.pose.largest = residual.largestAsPredicted ? largestOf(q) : residual.largest;
  now.pose.three = threeOf(q, now.pose.largest) + residual.threes[3];
  Pose checked;
  if (!within(now.pose.position, -kPositionMax - 1, kPositionMax) ||
      !within(now.pose.three, -kQuaternionMax, kQuaternionMax) || !fromCode(now.pose, frame, checked))
    reader.fail();
  return residual.bestOrders();
}

PartBaseline encodedAgainst(const PartBaseline& baseline, Micros elapsed, const PartCode& now,
                            const DeltaOrders& orders) {
  ASSERT(elapsed > 0);
  return {now, true, baseline.code.twist, elapsed, orders};
}

}  // namespace tandem::sync
