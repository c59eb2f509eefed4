#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "assets/base/constants.h"
#include "assets/generate/common.h"

// Plates side by side, one for each surface effect.

namespace tandem::generate {
namespace {

using assets::Surface;
using Pattern = assets::SurfaceTexture::Pattern;

constexpr double kSide = 36.0 * mm, kHeight = 6.0 * mm, kPlatePitch = 48.0 * mm;
constexpr int kColumns = 6;

/// One plate or dome.
struct Sample {
  Feel feel;  // its name is the part's
  AppearanceId appearance = kPaint;
  bool dome = false;
};

Sample plain(const char* name, AppearanceId appearance, double stiffness = 1000.0) {
  Sample sample{{name, 1150.0}, appearance};
  sample.feel.stiffness = stiffness;
  return sample;
}

Sample patterned(const char* name, AppearanceId appearance, Pattern pattern, double amplitude,
                 double wavelength) {
  Sample sample = plain(name, appearance);
  sample.feel.surface.texture.pattern = pattern;
  sample.feel.surface.texture.amplitude = amplitude;
  sample.feel.surface.texture.wavelength = wavelength;
  return sample;
}

/// Into SampleScene::images.
enum ImageId : std::uint32_t { kHills, kRamp };

/// Three hills along each side of the plate, of the image's full height.
assets::TextureImage hills() {
  assets::TextureImage image{96, 96, {}};
  for (std::uint32_t y = 0; y < image.height; ++y)
    for (std::uint32_t x = 0; x < image.width; ++x) {
      const double along = std::cos(6.0 * kPi * (x + 0.5) / image.width);
      const double across = std::cos(6.0 * kPi * (y + 0.5) / image.height);
      image.texels.push_back(static_cast<std::uint8_t>(std::lround(127.5 * (1.0 + along * across))));
    }
  return image;
}

/// Black on the left, white on the right.
assets::TextureImage ramp() {
  assets::TextureImage image{128, 2, {}};
  for (std::uint32_t y = 0; y < image.height; ++y)
    for (std::uint32_t x = 0; x < image.width; ++x) image.texels.push_back(static_cast<std::uint8_t>(2 * x));
  return image;
}

Sample imaged(const char* name, AppearanceId appearance, ImageId image, double amplitude) {
  Sample sample = patterned(name, appearance, Pattern::image, amplitude, 0.0);
  sample.feel.surface.texture.image = image;
  return sample;
}

std::vector<Sample> reliefAndFriction() {
  Sample friction = plain("friction", kRubber);
  friction.feel.staticFriction = 0.8;
  friction.feel.dynamicFriction = 0.5;
  Sample map = imaged("friction map", kPaper, kRamp, 0.0);
  map.feel.staticFriction = map.feel.dynamicFriction = 0.2;
  map.feel.surface.texture.frictionScale = 4.0;
  return {friction,
          map,
          imaged("image relief", kLime, kHills, 0.3 * mm),
          patterned("waves", kMachined, Pattern::sine, 0.15 * mm, 4.0 * mm),
          patterned("grid", kMachined, Pattern::grid, 0.15 * mm, 4.0 * mm),
          patterned("bumps", kMachined, Pattern::bumps, 0.25 * mm, 5.0 * mm),
          patterned("noise", kUsedPaper, Pattern::noise, 0.2 * mm, 3.0 * mm)};
}

std::vector<Sample> forces() {
  Sample viscosity = plain("viscosity", kPaint);
  viscosity.feel.surface.viscosity = 6.0;
  Sample vibration = plain("vibration", kPlastic);
  vibration.feel.surface.vibrationFrequency = 80.0;
  vibration.feel.surface.vibrationAmplitude = 0.4;
  Sample stickSlip = plain("stick-slip", kBrass);
  stickSlip.feel.surface.stickSlipForce = 0.6;
  stickSlip.feel.surface.stickSlipStiffness = 500.0;
  Sample magnet = plain("magnet", kSteel);
  magnet.feel.surface.magneticForce = 0.8;
  magnet.feel.surface.magneticDistance = 8.0 * mm;
  Sample popThrough = plain("pop-through", kPaper);
  popThrough.feel.surface.popThroughForce = 1.5;
  return {viscosity, vibration, stickSlip, magnet, popThrough};
}

std::vector<Sample> lawsAndShading() {
  Sample viscoelastic = plain("viscoelastic", kLime, 300.0);
  viscoelastic.feel.surface.law = Surface::Law::viscoelastic;
  viscoelastic.feel.surface.stiffness2 = 900.0;
  viscoelastic.feel.surface.relaxation = 0.25;
  Sample plastic = plain("plastic", kUsedPaper);
  plastic.feel.surface.law = Surface::Law::plastic;
  plastic.feel.surface.yieldForce = 0.8;
  plastic.feel.surface.hardening = 120.0;
  Sample smooth = plain("smooth dome", kMachined);
  smooth.feel.surface.creaseAngle = 0.5;
  Sample facets = plain("facetted dome", kMachined);
  smooth.dome = facets.dome = true;
  return {viscoelastic, plastic, smooth, facets};
}

/// A cap of a sphere of 20 mm radius whose facets can be felt one by one.
SampleShape dome(const std::string& name, AppearanceId appearance, std::size_t feel) {
  SampleShape shape{name, {}, {appearance}, feel};
  constexpr double kRadius = 20.0 * mm, kLowest = 0.35 * kPi;  // angle from the pole
  constexpr int kRings = 5;
  std::vector<ProfilePoint> profile = {{0.0, 0.0}};
  for (int i = 0; i <= kRings; ++i) {
    const double angle = kLowest * (kRings - i) / kRings;
    profile.push_back(
        {i == kRings ? 0.0 : kRadius * std::sin(angle), kRadius * (std::cos(angle) - std::cos(kLowest))});
  }
  shape.solid.revolve(profile, 16);
  return shape;
}

}  // namespace

SampleScene makeSurfaces() {
  SampleScene scene{"surfaces", commonAppearances(), commonFeels(), {}, {}, {hills(), ramp()}};
  scene.shapes = {benchTop(glm::dvec2(320.0 * mm, 180.0 * mm))};
  scene.parts = {{"bench", 0, glm::dvec3(0.0), false}};
  Sample damped = plain("damping", kPlastic, 600.0);
  damped.feel.damping = 8.0;
  std::vector<Sample> samples = {plain("elastic", kPaint), damped};
  for (const std::vector<Sample>& more : {reliefAndFriction(), forces(), lawsAndShading()})
    samples.insert(samples.end(), more.begin(), more.end());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Sample& sample = samples[i];
    const std::size_t feel = scene.feels.size();
    scene.feels.push_back(sample.feel);
    const glm::dvec2 size(kSide);
    SampleShape shape = sample.dome ? dome(sample.feel.name, sample.appearance, feel)
                                    : block(sample.feel.name, size, kHeight, sample.appearance, feel);
    if (sample.feel.surface.texture.pattern == Pattern::image) shape.repeat = kSide;
    scene.shapes.push_back(std::move(shape));
    const int column = static_cast<int>(i) % kColumns, row = static_cast<int>(i) / kColumns;
    scene.parts.push_back({sample.feel.name, scene.shapes.size() - 1,
                           glm::dvec3((column - 2.5) * kPlatePitch, kRestGap, (row - 1.0) * kPlatePitch),
                           false});
  }
  return scene;
}

}  // namespace tandem::generate
