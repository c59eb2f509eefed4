// Surfaces, textures, fields and controls through the codec: random ones, member by member.

#include "assets/scene/scene_codec.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "assets/scene/scene_check.h"

namespace tandem::assets {
namespace {

class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(seed) {}
  std::uint32_t below(std::uint32_t limit) { return static_cast<std::uint32_t>(engine_() % limit); }
  bool flag() { return below(2) == 1; }
  /// Not negative, over many magnitudes, now and then 0.
  double size() { return below(5) == 0 ? 0.0 : std::pow(10.0, number(-6.0, 3.0)); }
  double any() { return flag() ? size() : -size(); }
  double number(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  glm::dvec3 sizes() { return {size(), size(), size()}; }
  glm::dvec3 vector() { return {any(), any(), any()}; }
  Pose pose() { return {vector(), fromRotationVector({number(-3, 3), number(-3, 3), number(-3, 3)})}; }

 private:
  std::mt19937 engine_;
};

Surface randomSurface(Random& random, std::uint32_t textures) {
  Surface s;
  for (double* value : {&s.creaseAngle, &s.viscosity, &s.vibrationFrequency, &s.vibrationAmplitude,
                        &s.stickSlipForce, &s.stickSlipStiffness, &s.magneticForce, &s.magneticDistance,
                        &s.popThroughForce, &s.stiffness2, &s.relaxation, &s.yieldForce, &s.hardening,
                        &s.texture.amplitude, &s.texture.amplitudeForce, &s.texture.frictionScale})
    *value = random.size();
  s.creaseAngle = random.number(0.0, 3.0);
  s.texture.amplitude = random.number(0.0, 1.0);
  s.texture.wavelength = random.number(1e-5, 1.0);
  s.texture.pattern = static_cast<SurfaceTexture::Pattern>(random.below(6));
  if (s.texture.pattern == SurfaceTexture::Pattern::image) s.texture.image = random.below(textures);
  s.law = static_cast<Surface::Law>(random.below(3));
  return s;
}

TextureImage randomTexture(Random& random) {
  TextureImage image{1 + random.below(9), 1 + random.below(9), {}};
  for (std::uint32_t i = 0; i < image.width * image.height; ++i)
    image.texels.push_back(static_cast<std::uint8_t>(random.below(256)));
  return image;
}

ForceField randomField(Random& random, std::uint32_t parts) {
  using Kind = ForceField::Kind;
  ForceField f;
  f.name = "field " + std::to_string(random.below(1000));
  f.kind = static_cast<Kind>(random.below(8));
  f.part = random.flag() ? kNoPart : random.below(parts);
  f.partFromField = random.pose();
  f.maxForce = random.size() + 1e-3;
  f.region = {static_cast<FieldRegion::Kind>(random.below(3)), random.sizes(), random.size(),
              random.size() + 1e-6};
  f.force = random.vector();
  f.waveform = {static_cast<FieldWaveform::Kind>(random.below(4)),
                random.number(0.1, 500.0),
                random.number(0.1, 500.0),
                random.size() + 0.1,
                random.any(),
                random.size(),
                random.number(0.0, 1.0),
                random.flag() ? 1e300 : random.number(2.0, 9.0)};
  f.anchor = static_cast<ForceField::Anchor>(random.below(4));
  if (f.kind == Kind::guide) f.anchor = ForceField::Anchor::path;
  f.axis =
      glm::normalize(glm::dvec3(random.number(0.1, 1.0), random.number(-1.0, 1.0), random.number(-1.0, 1.0)));
  f.oneSided = random.flag();
  f.closed = random.flag();
  f.smooth = random.flag();
  if (f.anchor == ForceField::Anchor::path)
    for (std::uint32_t i = 0, n = 3 + random.below(5); i < n; ++i)
      f.points.emplace_back(random.number(-1.0, 1.0), random.number(-1.0, 1.0), i);
  f.stiffness = random.size();
  f.radius = random.size() + 1e-6;
  f.fade = random.size() + 1e-6;
  f.range = random.flag() ? 0.0 : f.fade * random.number(1.0, 3.0);
  f.drive = random.any();
  f.damping = random.sizes();
  f.strength = random.any();
  f.potential = static_cast<ForceField::Potential>(random.below(3));
  f.depth = random.any();
  f.sigma = random.sizes() + glm::dvec3(1e-6);
  for (std::uint32_t i = 0, n = random.below(4); i < n; ++i)
    f.terms.push_back(
        {random.any(),
         {static_cast<std::uint8_t>(random.below(5)), static_cast<std::uint8_t>(random.below(5)),
          static_cast<std::uint8_t>(random.below(5))}});
  return f;
}

Control randomControl(Random& random, PartId part, std::uint32_t parts) {
  Control c;
  c.name = "control " + std::to_string(part);
  c.part = part;
  c.kind = static_cast<ControlKind>(random.below(5));
  c.worldFromAxis = random.pose();
  c.axisFromPart = random.pose();
  c.endless = c.kind == ControlKind::dial && random.flag();
  c.min = c.endless ? -3.141592653589793 : random.number(-2.0, 0.0);
  c.max = c.endless ? 3.141592653589793 : random.number(0.5, 2.0);
  c.initial = random.number(c.min, c.max);
  c.inertia = random.size() + 1e-6;
  c.springStiffness = random.size();
  c.springRest = random.number(-3.0, 3.0);
  c.damping = random.size();
  c.friction = random.size();
  for (std::uint32_t i = 0, n = random.below(4); i < n; ++i)
    c.detents.places.push_back(c.min + (c.max - c.min) * (i + 0.5) / n);
  c.detents.force = random.size();
  c.detents.width = random.number(0.0, 0.05);
  c.click = {random.number(c.min, c.max), random.size(), random.number(0.01, 0.2)};
  c.roles = random.below(8);
  for (std::uint32_t i = 0, n = random.below(3); i < n; ++i) c.shows.push_back(random.below(parts));
  c.threshold = random.number(c.min, c.max);
  return c;
}

Scene randomScene(std::uint32_t seed) {
  Random random(seed);
  constexpr std::uint32_t kParts = 6, kTextures = 2;
  Scene scene;
  scene.materials.resize(4);
  for (std::uint32_t i = 0; i < 4; ++i) scene.surfaces.push_back(randomSurface(random, kTextures));
  for (std::uint32_t i = 0; i < 4; ++i) scene.materials[i].surface = random.flag() ? kNone : random.below(4);
  for (std::uint32_t i = 0; i < kTextures; ++i) scene.textures.push_back(randomTexture(random));
  for (std::uint32_t i = 0; i < kParts; ++i) {
    Part part;
    part.name = "part " + std::to_string(i);
    part.movable = true;
    part.massProperties = {1.0, glm::dvec3(0.0), glm::dmat3(1.0)};
    scene.parts.push_back(part);
  }
  scene.tree.push_back({"root", kNone});
  for (Part& part : scene.parts) part.treeNode = 0;
  for (std::uint32_t i = 0; i < 5; ++i) scene.fields.push_back(randomField(random, kParts));
  for (PartId part = 0; part < 3; ++part) scene.controls.push_back(randomControl(random, part, kParts));
  scene.bounds = {glm::dvec3(-1.0), glm::dvec3(1.0)};
  return scene;
}

/// Every number of a thing in a row, named one by one here so that a member that the codec forgets is missed.
struct Numbers {
  std::vector<double> all;
  std::vector<std::string> texts;

  template <typename... T>
  void add(const T&... values) {
    (all.push_back(static_cast<double>(values)), ...);
  }
  void add(const glm::dvec3& v) { add(v.x, v.y, v.z); }
  void add(const Pose& p) {
    add(p.position);
    add(p.orientation.w, p.orientation.x, p.orientation.y, p.orientation.z);
  }
  bool operator==(const Numbers&) const = default;
};

Numbers numbersOf(const ForceField& f) {
  Numbers n;
  n.texts = {f.name};
  n.add(static_cast<int>(f.kind), f.part, f.maxForce, static_cast<int>(f.region.kind), f.region.radius,
        f.region.fade);
  for (const glm::dvec3& v : {f.region.halfSize, f.force, f.axis, f.damping, f.sigma}) n.add(v);
  n.add(f.partFromField);
  const FieldWaveform& w = f.waveform;
  n.add(static_cast<int>(w.kind), w.frequency, w.endFrequency, w.sweep, w.phase, w.width, w.start, w.stop);
  n.add(static_cast<int>(f.anchor), f.oneSided, f.closed, f.smooth, f.stiffness, f.radius, f.range, f.fade,
        f.drive, f.strength, static_cast<int>(f.potential), f.depth, f.points.size(), f.terms.size());
  for (const glm::dvec3& p : f.points) n.add(p);
  for (const PotentialTerm& t : f.terms) n.add(t.coefficient, t.powers[0], t.powers[1], t.powers[2]);
  return n;
}

Numbers numbersOf(const Control& c) {
  Numbers n;
  n.texts = {c.name};
  n.add(c.part, static_cast<int>(c.kind), c.min, c.max, c.endless, c.initial, c.inertia, c.springStiffness,
        c.springRest, c.damping, c.friction, c.detents.force, c.detents.width, c.click.at, c.click.drop,
        c.click.width, c.roles, c.threshold, c.detents.places.size(), c.shows.size());
  n.add(c.worldFromAxis);
  n.add(c.axisFromPart);
  for (const double place : c.detents.places) n.add(place);
  for (const PartId part : c.shows) n.add(part);
  return n;
}

TEST(SceneCodec, GivesBackRandomSurfacesFieldsAndControls) {
  int valid = 0;
  for (std::uint32_t seed = 0; seed < 300; ++seed) {
    const Scene scene = randomScene(seed);
    ASSERT_TRUE(checkScene(scene).ok()) << seed << ": " << checkScene(scene).error().message;
    ++valid;
    const std::vector<std::byte> bytes = encodeScene(scene);
    const Result<Scene> back = decodeScene(bytes);
    ASSERT_TRUE(back.ok()) << seed << ": " << back.error().message;
    EXPECT_TRUE(back->surfaces == scene.surfaces) << seed;
    for (std::size_t i = 0; i < scene.materials.size(); ++i)
      EXPECT_EQ(back->materials[i].surface, scene.materials[i].surface);
    ASSERT_EQ(back->textures.size(), scene.textures.size());
    for (std::size_t i = 0; i < scene.textures.size(); ++i) {
      EXPECT_EQ(back->textures[i].width, scene.textures[i].width);
      EXPECT_EQ(back->textures[i].height, scene.textures[i].height);
      EXPECT_EQ(back->textures[i].texels, scene.textures[i].texels);
    }
    ASSERT_EQ(back->fields.size(), scene.fields.size());
    for (std::size_t i = 0; i < scene.fields.size(); ++i)
      EXPECT_TRUE(numbersOf(back->fields[i]) == numbersOf(scene.fields[i])) << seed << " field " << i;
    ASSERT_EQ(back->controls.size(), scene.controls.size());
    for (std::size_t i = 0; i < scene.controls.size(); ++i)
      EXPECT_TRUE(numbersOf(back->controls[i]) == numbersOf(scene.controls[i])) << seed << " control " << i;
    EXPECT_EQ(encodeScene(*back), bytes) << seed;
  }
  EXPECT_EQ(valid, 300);
}

TEST(SceneCodec, DamagedFeaturesAreRefusedOrPassTheCheck) {
  Random random(7);
  int refused = 0;
  for (std::uint32_t seed = 0; seed < 40; ++seed) {
    const std::vector<std::byte> whole = encodeScene(randomScene(seed));
    for (int damage = 0; damage < 25; ++damage) {
      std::vector<std::byte> bytes = whole;
      bytes[random.below(static_cast<std::uint32_t>(bytes.size()))] ^= std::byte(1u << random.below(8));
      const Result<Scene> scene = decodeScene(bytes);
      refused += scene.ok() ? 0 : 1;
      EXPECT_TRUE(!scene.ok() || checkScene(*scene).ok()) << seed;
    }
    for (std::size_t length = 0; length < whole.size(); length += 37)
      EXPECT_FALSE(decodeScene({whole.data(), length}).ok()) << length;
  }
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace tandem::assets
