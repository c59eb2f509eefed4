#include "haptics/fit/interference_fit.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "haptics/base/simd4.h"
#include "haptics/base/six_axes.h"

namespace tandem::haptics {
namespace {

constexpr double kCells = 16.0;  // along the diagonal of an overlap
constexpr double kStep = 0.7;    // spacings between the places from which points are sought
constexpr double kApart = 0.7;   // spacings between points at least
constexpr double kMaxPlaces = 20'000.0;
// Share of a field's smallest cell up to which its error leaves it a direction, and the least slope of one.
constexpr double kRough = 0.2, kStraight = 0.8;
// Cosines of angles between surfaces: up to the first they do not face each other, from the second on they
// do.
constexpr float kAskew = 0.5f, kFacing = 0.7f;
// Share of its points' distances by which a wall looks at its own middle.
constexpr double kHollow = 0.05;
// Tolerances of the field that a wall is in the plug at least.
constexpr double kLeast = 0.25;

/// A place of a surface near a point.
struct Surface {
  double distance = 0.0;  // m, of the point, below 0 inside
  glm::dvec3 point{0.0, 0.0, 0.0}, normal{0.0, 0.0, 0.0};
};

/// The surface near p, at most `reach` m away, by the part's field; false if there is none, or if p is before
/// a sharp edge, where the field knows no direction.
bool surfaceNear(const PartModel& part, const glm::dvec3& p, double reach, Surface& found) {
  const DistanceField::Reading read = part.field.read(glm::vec3(p - part.field.origin()));
  const double distance = static_cast<double>(read.distance), error = static_cast<double>(read.error);
  if (std::abs(distance) > reach || (error == 0.0 && distance > 0.0)) return false;
  const glm::dvec3 up(read.gradient);
  const double slope = glm::length(up);
  if (error > kRough * part.field.smallestCell() || slope < kStraight) return false;
  found = {distance, p - distance / slope * up, up / slope};
  return true;
}

}  // namespace

bool InterferenceFit::begin(const assets::Bounds& near) {
  points_.clear();
  cells_.clear();
  fours_.clear();
  depth_ = 0.0;
  box_ = {};
  const glm::dvec3 size = near.max - near.min;
  spacing_ = glm::length(size) / kCells;
  origin_ = near.min;
  if (!(spacing_ > 0.0)) return false;
  places_ = glm::ivec3(glm::ceil(size / (kStep * spacing_))) + 1;
  return static_cast<double>(places_.x) * places_.y * places_.z <= kMaxPlaces;
}

bool InterferenceFit::lookAt(int place, const SampledModels& plugFromHollow, double deepest) {
  const PartModel &hollow = *plugFromHollow.from, &plug = *plugFromHollow.to;
  const Pose& pose = plugFromHollow.toFromSamples;
  const double step = kStep * spacing_, least = kLeast * hollow.field.tolerance();
  const glm::ivec3 at(place % places_.x, place / places_.x % places_.y, place / (places_.x * places_.y));
  Surface wall, inside;
  if (!surfaceNear(hollow, origin_ + step * glm::dvec3(at), step, wall)) return true;
  const glm::dvec3 facing = pose.orientation * wall.normal;
  if (!surfaceNear(plug, transformPoint(pose, wall.point), deepest, inside)) return true;
  // Where another side of the plug is nearer, this wall is not what holds it.
  if (inside.distance > -least || glm::dot(inside.normal, facing) > -static_cast<double>(kFacing))
    return true;
  return add({glm::vec3(wall.point - origin_), glm::vec3(wall.normal)});
}

bool InterferenceFit::end() { return isHollow() && index(); }

bool InterferenceFit::add(const Point& point) {
  const auto apart = static_cast<float>(kApart * spacing_);
  for (const Point& known : points_) {
    if (glm::length(known.at - point.at) < apart && glm::dot(known.normal, point.normal) > 0.95f) return true;
  }
  if (points_.full()) return false;
  points_.push_back(point);
  return true;
}

bool InterferenceFit::isHollow() const {
  if (points_.empty()) return false;
  glm::dvec3 middle(0.0);
  for (const Point& point : points_) middle += glm::dvec3(point.at) / static_cast<double>(points_.size());
  double inward = 0.0, distance = 0.0;
  for (const Point& point : points_) {
    const glm::dvec3 off = glm::dvec3(point.at) - middle;
    inward -= glm::dot(glm::dvec3(point.normal), off);
    distance += glm::length(off);
  }
  return inward > kHollow * distance;
}

std::uint32_t InterferenceFit::cellOf(const glm::vec3& at) const {
  // Points lie within the first box, and reach no further than some cells beyond it.
  const glm::vec3 cell = glm::floor(at / (2.0f * reach())) + 512.0f;
  const glm::uvec3 in(glm::clamp(cell, 0.0f, 1023.0f));
  return in.z << 20 | in.y << 10 | in.x;
}

bool InterferenceFit::index() {
  FixedVector<Entry, kMaxEntries> entries;
  const glm::dvec3 whole(kWhole * spacing_);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Point& point = points_[i];
    const glm::dvec3 at = origin_ + glm::dvec3(point.at);
    box_.min = glm::min(box_.min, at - whole);
    box_.max = glm::max(box_.max, at + whole);
    const std::size_t first = entries.size();
    for (int corner = 0; corner < 8; ++corner) {
      const glm::vec3 off((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1, (corner & 4) != 0 ? 1 : -1);
      const std::uint32_t cell = cellOf(point.at + reach() * off);
      const auto known = [&](const Entry& entry) { return entry.cell == cell; };
      if (std::any_of(entries.begin() + static_cast<std::ptrdiff_t>(first), entries.end(), known)) continue;
      entries.push_back({cell, static_cast<std::uint16_t>(i)});
    }
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.cell != b.cell ? a.cell < b.cell : a.point < b.point;
  });
  std::size_t among = 0;  // entries of the present cell so far
  for (const Entry& entry : entries) {
    if (cells_.empty() || cells_.back().cell != entry.cell) {
      if (cells_.full()) return false;
      const auto next = static_cast<std::uint32_t>(fours_.size());
      cells_.push_back({entry.cell, next, next});
      among = 0;
    }
    addToCell(points_[entry.point], among++);
  }
  return true;
}

void InterferenceFit::addToCell(const Point& point, std::size_t among) {
  if (among % 4 == 0) {
    fours_.push_back({});
    ++cells_.back().end;
  }
  Four& four = fours_.back();
  for (int k = 0; k < 3; ++k) {
    four.at[k][among % 4] = point.at[k];
    four.normal[k][among % 4] = point.normal[k];
  }
}

float InterferenceFit::shareOf(const Four& points, const glm::vec3& at, const glm::vec3& facing) const {
  const auto dot = [](const Float4* a, const Float4* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  Float4 normal[3], direction[3], off[3];
  for (int k = 0; k < 3; ++k) {
    normal[k] = Float4::load(points.normal[k]);
    direction[k] = Float4(facing[k]);
    off[k] = Float4(at[k]) - Float4::load(points.at[k]);
  }
  const Float4 askew(kAskew), cosine = dot(normal, direction);
  if (lessMask(askew, cosine) == 0) return 0.0f;
  // A jump would be felt.
  const Float4 none, one(1.0f), spacing(static_cast<float>(spacing_));
  const Float4 turned = (cosine - askew) / Float4(kFacing - kAskew);
  const Float4 beside = Float4(reach()) - sqrt(dot(off, off));
  alignas(16) float lanes[4];
  (min(max(turned, none), one) * min(max(beside, none) / spacing, one)).store(lanes);
  return std::max(std::max(lanes[0], lanes[1]), std::max(lanes[2], lanes[3]));
}

float InterferenceFit::shareAt(const glm::vec3& at, const glm::vec3& direction, Hint& hint) const {
  // The share is the largest of all points, and none is above 1.
  if (hint.four < fours_.size() && shareOf(fours_[hint.four], at, direction) >= 1.0f) return 1.0f;
  const std::uint32_t number = cellOf(at);
  const auto before = [](const Cell& cell, std::uint32_t value) { return cell.cell < value; };
  const auto cell = std::lower_bound(cells_.begin(), cells_.end(), number, before);
  if (cell == cells_.end() || cell->cell != number) return 0.0f;
  float share = 0.0f;
  for (std::uint32_t i = cell->first; i < cell->end && share < 1.0f; ++i) {
    share = std::max(share, shareOf(fours_[i], at, direction));
    if (share >= 1.0f) hint.four = i;
  }
  return share;
}

glm::dvec3 InterferenceFit::shiftOf(const SampledModels& models, const ContactSample& sample, bool ofHollow,
                                    Hint& hint) const {
  glm::dvec3 shift(0.0);
  const glm::dvec3 at = ofHollow ? sample.point : transformPoint(models.toFromSamples, sample.point);
  const glm::dvec3 off = glm::max(glm::max(box_.min - at, at - box_.max), glm::dvec3(0.0));
  if (glm::dot(off, off) >= spacing_ * spacing_) return shift;
  const glm::vec3 place(at - origin_);
  const auto normals = models.from->samples.normals(sample);
  for (const glm::dvec3& normal : normals.first(std::min(normals.size(), kMostNormals))) {
    // Surfaces that the sample meets look in this direction.
    const glm::dvec3 direction = ofHollow ? normal : -(models.toFromSamples.orientation * normal);
    const auto share = static_cast<double>(shareAt(place, glm::vec3(direction), hint));
    const double more = share * depth_ - glm::dot(shift, direction);
    if (more > 0.0) shift += more * direction;
  }
  return shortened(shift, greatestShift());
}

glm::dvec3 InterferenceFit::shift(const SampledModels& models, const ContactSample& sample, bool ofHollow,
                                  Hint& hint) const {
  const glm::dvec3 shift = shiftOf(models, sample, ofHollow, hint);
  return ofHollow ? -(models.toFromSamples.orientation * shift) : shift;
}

}  // namespace tandem::haptics
