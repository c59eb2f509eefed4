#include "haptics/scene/primitive_samples.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/constants.h"
#include "haptics/geometry/outward.h"

namespace tandem::haptics {
namespace {

using assets::ImplicitShape;

constexpr int kAround = 32;      // patches of a full turn of a rim or side
constexpr int kZones = 11;       // of a sphere from pole to pole
constexpr int kMaxRings = 12;    // of a side
constexpr double kLonger = 4.0;  // length of a patch of a side relative to its width
// Places of a face beside a rim that is sharper than a right angle, and how near to it, of its radius.
constexpr int kBesideRim = 16;
constexpr double kInset = 0x1p-7;
// Patches of a zone are about square: half their diagonal over their side, with a margin for the pole.
constexpr double kHalfDiagonal = 0.75;
constexpr double kOverlap = 1.02;  // of neighbouring patches, so that the deepest point is inside one

glm::dvec3 across(double angle) { return {std::sin(angle), 0.0, std::cos(angle)}; }

ContactPatch ringPatch(ContactPatch::Kind kind, const Pose& pose, double y, int i) {
  ContactPatch patch;
  patch.kind = kind;
  patch.centre = transformPoint(pose, {0.0, y, 0.0});
  patch.axis = pose.orientation * glm::dvec3(0.0, 1.0, 0.0);
  patch.out = pose.orientation * across(2.0 * kPi * i / kAround);
  patch.angle = kOverlap * kPi / kAround;
  return patch;
}

/// Samples the visible surfaces of several shapes.
class PrimitiveSampler {
 public:
  explicit PrimitiveSampler(double spacing) : spacing_(spacing) {}

  SampleSet sample(std::span<const ImplicitShape> shapes, const assets::Mesh& mesh) {
    const std::vector<Primitive> primitives = primitivesOf(shapes, mesh);
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      const std::size_t first = out_.samples.size();
      sampleShape(shapes[i], primitives[i].triangle());
      if (primitives.size() > 1) uncover(primitives, i, first);
    }
    return std::move(out_);
  }

 private:
  void sampleShape(const ImplicitShape& shape, std::uint32_t triangle);
  void addPatch(const ContactPatch& patch, std::uint32_t triangle);
  void addPoint(const glm::dvec3& point, std::span<const glm::dvec3> normals, std::uint32_t triangle);
  void sampleBox(const Pose& pose, const glm::dvec3& size, bool flat, std::uint32_t triangle);
  /// A zone of a sphere, between two angles from the Y axis of the pose.
  void sampleZone(const Pose& pose, double y, double radius, double from, double to, std::uint32_t triangle);
  /// `low` and `high` are the heights of the centres of the spheres that touch the side at its ends; `radius`
  /// is that of the lower one.
  void sampleSide(const Pose& pose, double low, double high, double radius, double grow,
                  std::uint32_t triangle);
  /// `face` is 1 for the upper face, -1 for the lower one.
  void sampleRim(const Pose& pose, double y, double radius, double face, double grow, std::uint32_t triangle);
  /// Removes the samples from `firstSample` on, which are those of one shape, that the other shapes cover.
  void uncover(std::span<const Primitive> shapes, std::size_t which, std::size_t firstSample);
  /// Replaces normals of a sample by those that are visible where a face ends there; false if none is
  /// visible.
  bool uncoverNormals(std::span<const Primitive> shapes, std::size_t which, const ContactSample& sample);

  double spacing_;  // m, of samples along a straight edge
  SampleSet out_;
};

void PrimitiveSampler::uncover(std::span<const Primitive> shapes, std::size_t which,
                               std::size_t firstSample) {
  const auto hidden = [&](const ContactSample& sample) {
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      if (i != which &&
          shapes[i].at(sample.point).distance < -1e-6 * spacing_ - static_cast<double>(sample.along))
        return true;
    }
    return !uncoverNormals(shapes, which, sample);
  };
  out_.samples.erase(std::remove_if(out_.samples.begin() + static_cast<std::ptrdiff_t>(firstSample),
                                    out_.samples.end(), hidden),
                     out_.samples.end());
}

bool PrimitiveSampler::uncoverNormals(std::span<const Primitive> shapes, std::size_t which,
                                      const ContactSample& sample) {
  if (sample.normalCount < 2 || sample.normalCount > 3) return true;
  const std::size_t first = sample.firstNormal, count = sample.normalCount;
  std::array<glm::dvec3, 3> own;
  glm::dvec3 sum(0.0);
  for (std::size_t k = 0; k < count; ++k) sum += own[k] = out_.normals[first + k];
  if (!(glm::length(sum) > 1e-6)) return true;  // a sheet
  std::size_t covered = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const glm::dvec3 others = sum - own[k], into = -(others - own[k] * glm::dot(own[k], others));
    const double length = glm::length(into);
    if (!(length > 1e-9)) continue;
    covered += coveredFace(shapes, which, sample.point, into / length, glm::normalize(sum), 1e-3 * spacing_,
                           out_.normals[first + k])
                   ? 1
                   : 0;
  }
  if (covered == count) return false;
  if (covered == 0 || sample.patch == assets::kNone) return true;
  ContactPatch& patch = out_.patches[sample.patch];
  if (patch.kind != ContactPatch::Kind::rim) return true;
  patch.grow = std::clamp(-glm::dot(out_.normals[first], patch.axis), -1.0, 1.0);
  patch.cap = std::clamp(glm::dot(out_.normals[first + 1], patch.out), -1.0, 1.0);
  return true;
}

void PrimitiveSampler::addPatch(const ContactPatch& patch, std::uint32_t triangle) {
  ContactSample sample;
  sample.point = patch.sample();
  std::array<glm::dvec3, 2> normals;
  const ContactPatch::Place place{patch.out, 0.0};
  sample.normalCount = static_cast<std::uint32_t>(patch.normalsAt(place, normals));
  sample.firstNormal = static_cast<std::uint32_t>(out_.normals.size());
  out_.normals.insert(out_.normals.end(), normals.begin(), normals.begin() + sample.normalCount);
  sample.triangle = triangle;
  sample.along = roundUp(patch.reach());
  sample.patch = static_cast<std::uint32_t>(out_.patches.size());
  out_.patches.push_back(patch);
  out_.samples.push_back(sample);
}

void PrimitiveSampler::addPoint(const glm::dvec3& point, std::span<const glm::dvec3> normals,
                                std::uint32_t triangle) {
  ContactSample sample;
  sample.point = point;
  sample.firstNormal = static_cast<std::uint32_t>(out_.normals.size());
  sample.normalCount = static_cast<std::uint32_t>(normals.size());
  sample.triangle = triangle;
  out_.normals.insert(out_.normals.end(), normals.begin(), normals.end());
  out_.samples.push_back(sample);
}

void PrimitiveSampler::sampleShape(const ImplicitShape& shape, std::uint32_t triangle) {
  const Pose& pose = shape.partFromShape;
  const double half = 0.5 * std::abs(shape.height);
  double top = std::abs(shape.radiusTop), bottom = std::abs(shape.radiusBottom);
  const double more = top - bottom;
  switch (shape.kind) {
    case ImplicitShape::Kind::box:
      sampleBox(pose, glm::abs(shape.size), false, triangle);
      break;
    case ImplicitShape::Kind::plane:
      sampleBox(pose, glm::abs(shape.size), true, triangle);
      break;
    case ImplicitShape::Kind::sphere:
      sampleZone(pose, 0.0, bottom, 0.0, kPi, triangle);
      break;
    case ImplicitShape::Kind::capsule: {
      if (2.0 * half <= std::abs(more)) {
        sampleZone(pose, more > 0.0 ? half : -half, std::max(top, bottom), 0.0, kPi, triangle);
        break;
      }
      // The cone leaves both spheres at the same angle from the axis.
      const double grow = more / (2.0 * half), leaves = std::acos(-grow);
      sampleZone(pose, half, top, 0.0, leaves, triangle);
      sampleZone(pose, -half, bottom, leaves, kPi, triangle);
      sampleSide(pose, -half, half, bottom, grow, triangle);
      break;
    }
    case ImplicitShape::Kind::cylinder: {
      if (!(half > 0.0)) top = bottom = std::max(top, bottom);
      const double slant = std::hypot(2.0 * half, top - bottom);
      const double grow = slant > 0.0 ? (top - bottom) / slant : 0.0;
      sampleRim(pose, half, top, 1.0, grow, triangle);
      sampleRim(pose, -half, bottom, -1.0, grow, triangle);
      if (!(half > 0.0)) break;
      // The spheres that touch the side at its rims, see ContactPatch.
      const double lean = slant / (2.0 * half);
      sampleSide(pose, -half + grow * bottom * lean, half + grow * top * lean, bottom * lean, grow, triangle);
      break;
    }
  }
}

void PrimitiveSampler::sampleBox(const Pose& pose, const glm::dvec3& size, bool flat,
                                 std::uint32_t triangle) {
  glm::dvec3 half = 0.5 * size;
  if (flat) half.y = 0.0;
  const auto normal = [&](int axis, double sign) {
    glm::dvec3 n(0.0);
    n[axis] = sign;
    return pose.orientation * n;
  };
  const glm::dvec3 up = normal(1, 1.0);
  for (int along = 0; along < 3; ++along) {
    if (flat && along == 1) continue;
    const int i = (along + 1) % 3, j = (along + 2) % 3;
    for (int side = 0; side < 4; ++side) {
      const double si = (side & 1) != 0 ? 1.0 : -1.0, sj = (side & 2) != 0 ? 1.0 : -1.0;
      if (flat && (i == 1 ? si : sj) < 0.0) continue;
      const double length = 2.0 * half[along];
      const int inner = std::max(1, static_cast<int>(std::ceil(length / spacing_)) - 1);
      for (int k = 1; k <= inner; ++k) {
        glm::dvec3 p(0.0);
        p[i] = si * half[i];
        p[j] = sj * half[j];
        p[along] = length * (static_cast<double>(k) / (inner + 1) - 0.5);
        ContactPatch patch;
        patch.kind = ContactPatch::Kind::straight;
        patch.centre = transformPoint(pose, p);
        patch.axis = normal(along, 1.0);
        patch.along = length / (inner + 1);
        addPatch(patch, triangle);
        const std::array<glm::dvec3, 2> faces = {flat ? up : normal(i, si), flat ? -up : normal(j, sj)};
        out_.samples.back().firstNormal = static_cast<std::uint32_t>(out_.normals.size());
        out_.samples.back().normalCount = 2;
        out_.normals.insert(out_.normals.end(), faces.begin(), faces.end());
      }
    }
  }
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 sign((corner & 1) != 0 ? 1.0 : -1.0, (corner & 2) != 0 ? 1.0 : -1.0,
                          (corner & 4) != 0 ? 1.0 : -1.0);
    if (flat && sign.y < 0.0) continue;
    const std::array<glm::dvec3, 3> faces = {normal(0, sign.x), normal(1, sign.y), normal(2, sign.z)};
    const std::array<glm::dvec3, 2> sides = {up, -up};
    const std::span<const glm::dvec3> of = flat ? std::span<const glm::dvec3>(sides) : faces;
    addPoint(transformPoint(pose, sign * half), of, triangle);
  }
}

void PrimitiveSampler::sampleZone(const Pose& pose, double y, double radius, double from, double to,
                                  std::uint32_t triangle) {
  const int zones = std::max(1, static_cast<int>(std::ceil(kZones * (to - from) / kPi - 1e-9)));
  const double side = kPi / kZones, high = (to - from) / zones;
  ContactPatch patch;
  patch.kind = ContactPatch::Kind::cap;
  patch.centre = transformPoint(pose, {0.0, y, 0.0});
  patch.radius = radius;
  patch.angle = kHalfDiagonal * side;
  for (int zone = 0; zone < zones; ++zone) {
    const double polar = from + high * (zone + 0.5);
    const double widest = std::sin(std::clamp(0.5 * kPi, polar - 0.5 * high, polar + 0.5 * high));
    const int count = std::max(1, static_cast<int>(std::ceil(2.0 * kPi * widest / side)));
    for (int i = 0; i < count; ++i) {
      const glm::dvec3 out = std::sin(polar) * across(2.0 * kPi * (i + 0.5 * (zone % 2)) / count) +
                             glm::dvec3(0.0, std::cos(polar), 0.0);
      patch.out = pose.orientation * out;
      addPatch(patch, triangle);
    }
  }
}

void PrimitiveSampler::sampleSide(const Pose& pose, double low, double high, double radius, double grow,
                                  std::uint32_t triangle) {
  const double largest = std::max(radius, radius + (high - low) * grow);
  const double usual = kLonger * 2.0 * kPi * largest / kAround;
  const double wanted = usual > 0.0 ? std::ceil((high - low) / usual) : 1.0;
  const int rings = static_cast<int>(std::clamp(wanted, 1.0, static_cast<double>(kMaxRings)));
  for (int ring = 0; ring < rings; ++ring) {
    // Patches overlap, and end where the side does.
    const double length = (high - low) / rings, middle = low + length * (ring + 0.5);
    const double from = std::max(low, middle - 0.5 * kOverlap * length),
                 to = std::min(high, middle + 0.5 * kOverlap * length), y = 0.5 * (from + to);
    for (int i = 0; i < kAround; ++i) {
      ContactPatch patch = ringPatch(ContactPatch::Kind::side, pose, y, i);
      patch.radius = radius + (y - low) * grow;
      patch.grow = grow;
      patch.along = 0.5 * (to - from);
      addPatch(patch, triangle);
    }
  }
}

void PrimitiveSampler::sampleRim(const Pose& pose, double y, double radius, double face, double grow,
                                 std::uint32_t triangle) {
  if (!(radius > 0.0)) {
    // A tip, whose normals are those of the side around it.
    std::array<glm::dvec3, 12> normals;
    const double lean = std::sqrt(std::max(0.0, 1.0 - grow * grow));
    for (std::size_t i = 0; i < normals.size(); ++i)
      normals[i] = pose.orientation *
                   (lean * across(2.0 * kPi * static_cast<double>(i) / 12.0) - glm::dvec3(0.0, grow, 0.0));
    addPoint(transformPoint(pose, {0.0, y, 0.0}), normals, triangle);
    return;
  }
  for (int i = 0; i < kAround; ++i) {
    ContactPatch patch = ringPatch(ContactPatch::Kind::rim, pose, y, i);
    patch.axis *= face;
    patch.radius = radius;
    patch.grow = face * grow;
    addPatch(patch, triangle);
  }
  // Where two such rims of equal size lie on each other, both pass the other part's side, whatever the depth
  // of the faces.
  if (face * grow <= 0.0) return;
  const std::array<glm::dvec3, 1> up = {pose.orientation * glm::dvec3(0.0, face, 0.0)};
  for (int i = 0; i < kBesideRim; ++i) {
    const glm::dvec3 out = across(2.0 * kPi * i / kBesideRim);
    addPoint(transformPoint(pose, glm::dvec3(0.0, y, 0.0) + (1.0 - kInset) * radius * out), up, triangle);
  }
}

}  // namespace

SampleSet sampleShapes(std::span<const ImplicitShape> shapes, const assets::Mesh& mesh, double spacing) {
  return PrimitiveSampler(spacing).sample(shapes, mesh);
}

}  // namespace tandem::haptics
